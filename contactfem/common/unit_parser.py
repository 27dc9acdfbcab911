"""Read "35 N/mm^2" into SI and tell its dimension.

Units of everyday mechanics are read here, which takes microseconds; any other is left to pint,
whose import alone would cost half the time that `contactfem check` has.
"""

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from typing import TYPE_CHECKING

from contactfem.common.text import similar
from contactfem.errors import ContactfemError

if TYPE_CHECKING:
    import pint

Exponents = tuple[float, float, float, float]

_NUMBER = re.compile(r"\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)(?![0-9.])")
_TOKEN = re.compile(r"\s*(\*\*|[*/^()·]|[A-Za-zµμ°%_]+|[+-]?[0-9]+(?:\.[0-9]*)?)")
_LONGEST = 200  # characters; nobody writes a longer quantity on purpose


class UnitError(ContactfemError, ValueError):
    """A text that is not a number with a unit."""

    def __init__(self, message: str) -> None:
        super().__init__(" ".join(message.split()))  # a user's text may hold line breaks


@dataclass(frozen=True)
class Unit:
    """One unit in SI.

    Attributes:
        factor: one of it in the SI unit of its dimension.
        exponents: of metre, kilogram, second and kelvin.
    """

    factor: float
    exponents: Exponents = (0.0, 0.0, 0.0, 0.0)

    def __mul__(self, other: "Unit") -> "Unit":
        """Multiply two units."""
        a, b = self.exponents, other.exponents
        return Unit(
            self.factor * other.factor, (a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3])
        )

    def __pow__(self, power: float) -> "Unit":
        """Raise to a power."""
        a = self.exponents
        return Unit(self.factor**power, (a[0] * power, a[1] * power, a[2] * power, a[3] * power))


# symbols that take prefixes, and symbols that do not
PREFIXABLE = {
    "m": Unit(1.0, (1, 0, 0, 0)),
    "g": Unit(1e-3, (0, 1, 0, 0)),
    "s": Unit(1.0, (0, 0, 1, 0)),
    "K": Unit(1.0, (0, 0, 0, 1)),
    "N": Unit(1.0, (1, 1, -2, 0)),
    "Pa": Unit(1.0, (-1, 1, -2, 0)),
    "J": Unit(1.0, (2, 1, -2, 0)),
    "W": Unit(1.0, (2, 1, -3, 0)),
}
PLAIN = {
    "bar": Unit(1e5, (-1, 1, -2, 0)),
    "min": Unit(60.0, (0, 0, 1, 0)),
    "h": Unit(3600.0, (0, 0, 1, 0)),
    "rad": Unit(1.0),
    "%": Unit(1e-2),
}
# scales of temperature with a zero of their own: one degree, and their zero in kelvin
CELSIUS, FAHRENHEIT = (1.0, 273.15), (5.0 / 9.0, 459.67 * 5.0 / 9.0)
SCALES = {
    "degC": CELSIUS,
    "°C": CELSIUS,
    "celsius": CELSIUS,
    "degF": FAHRENHEIT,
    "°F": FAHRENHEIT,
    "fahrenheit": FAHRENHEIT,
}
PREFIXES = {
    "n": 1e-9,
    "µ": 1e-6,
    "μ": 1e-6,
    "u": 1e-6,
    "m": 1e-3,
    "c": 1e-2,
    "d": 1e-1,
    "h": 1e2,
    "k": 1e3,
    "M": 1e6,
    "G": 1e9,
}
DIMENSIONS = {
    "": "number",
    "m": "length",
    "s": "time",
    "K": "temperature",
    "kg": "mass",
    "N": "force",
    "Pa": "stress",
    "N/m": "force per length",
    "N/m^3": "force per volume",
    "1/K": "expansion coefficient",
    "kg/m^3": "density",
    "W/m/K": "conductivity",
    "J/kg/K": "heat capacity",
    "m/s": "velocity",
    "m^2": "area",
    "J": "energy",
    "W/m^2": "heat flux",
    "W/m^3": "heat source",
    "W/m^2/K": "conductance",
}


def split(text: str) -> tuple[float, str]:
    """Split "35 N/mm^2" into its number and its unit.

    Raises:
        UnitError: there is no finite number at the start.
    """
    match = _NUMBER.match(text[:_LONGEST])
    if match is None or len(text) > _LONGEST:
        raise UnitError("is not a finite number followed by a unit")
    number = float(match[1])
    if not math.isfinite(number):
        raise UnitError("is too large a number")
    return number, text[match.end() :].strip()


def unit(text: str) -> Unit:
    """Read a product of units such as "N/mm^2", "W/(m K)" or "1/K"; blanks multiply.

    Args:
        text: the product; empty for a plain number.

    Returns:
        Factor to SI and dimension.

    Raises:
        UnitError: not a product of units, or a unit that neither this module nor pint knows.
    """
    tokens = _tokens(text)
    try:
        result = _product(tokens, _symbol) if tokens else Unit(1.0)
        if not (0.0 < result.factor < math.inf and all(map(math.isfinite, result.exponents))):
            raise OverflowError
    except (OverflowError, ZeroDivisionError):
        raise UnitError(f"'{text}' is out of all bounds") from None
    if tokens:
        raise UnitError(f"'{text}' is not a unit: unexpected '{tokens[0]}'")
    return result


def has_zero(text: str) -> bool:
    """Whether a unit is a scale of temperature such as "degC", whose values are absolute."""
    return text.strip() in SCALES


def kelvin(number: float, scale: str) -> float:
    """Absolute temperature of a value on a scale such as "degC" [K]."""
    degree, zero = SCALES[scale.strip()]
    if degree == 1.0:
        return float(Decimal(repr(number)) + Decimal(repr(zero)))
    return number * degree + zero


def scaled(number: float, factor: float) -> float:
    """Product of both; exact for powers of ten, so that "39.3 mm" is 0.0393."""
    exponent = round(math.log10(factor))
    if abs(factor / 10.0**exponent - 1.0) < 1e-12:
        return float(Decimal(repr(number)).scaleb(exponent))
    return number * factor


def dimension(exponents: Exponents) -> str:
    """Name of a dimension, such as "a length", or its SI unit where it has no name."""
    for symbol, name in DIMENSIONS.items():
        if unit(symbol).exponents == exponents:
            return with_article(name)
    parts = zip(("m", "kg", "s", "K"), exponents, strict=True)
    return "a quantity in " + " ".join(f"{s}^{e:g}" if e != 1 else s for s, e in parts if e)


def with_article(name: str) -> str:
    """Put "a" or "an" before a word."""
    return f"{'an' if name[0] in 'aeiou' else 'a'} {name}"


def _tokens(text: str) -> list[str]:
    def found() -> Iterator[str]:
        place = 0
        while place < len(text):
            match = _TOKEN.match(text, place)
            if match is None:
                raise UnitError(f"'{text}' is not a unit: unexpected '{text[place:].strip()}'")
            yield match[1]
            place = match.end()

    return list(found())


def _product(tokens: list[str], symbol: Callable[[str], Unit]) -> Unit:
    """Consume factors from the left, up to the end or a closing bracket."""
    result = _power(tokens, symbol)
    while tokens and tokens[0] != ")":
        sign = -1.0 if tokens[0] == "/" else 1.0
        if tokens[0] in ("*", "/", "·"):
            tokens.pop(0)
        result = result * _power(tokens, symbol) ** sign
    return result


def _power(tokens: list[str], symbol: Callable[[str], Unit]) -> Unit:
    head = tokens.pop(0) if tokens else ""
    if head == "(":
        base = _product(tokens, symbol)
        if not tokens or tokens.pop(0) != ")":
            raise UnitError("has a bracket that is not closed")
    elif head == "1":
        base = Unit(1.0)
    elif head and (head[0].isalpha() or head[0] in "°%_"):
        base = symbol(head)
    else:
        raise UnitError(f"has {f"'{head}'" if head else 'nothing'} where a unit should be")
    if tokens and tokens[0] in ("^", "**"):
        tokens.pop(0)
        try:
            base = base ** float(tokens.pop(0))
        except (IndexError, ValueError):
            raise UnitError("has a power that is not a number") from None
    return base


def _symbol(name: str) -> Unit:
    """One unit with or without prefix; in a product degC and degF are differences."""
    if name in SCALES:
        return Unit(SCALES[name][0], PREFIXABLE["K"].exponents)
    if name in PLAIN:
        return PLAIN[name]
    if name in PREFIXABLE:
        return PREFIXABLE[name]
    if name[:1] in PREFIXES and name[1:] in PREFIXABLE:
        base = PREFIXABLE[name[1:]]
        return Unit(PREFIXES[name[0]] * base.factor, base.exponents)
    return _from_pint(name)


@cache
def _registry() -> "pint.UnitRegistry":
    import pint

    return pint.UnitRegistry()


def _from_pint(name: str) -> Unit:
    """Ask pint for a unit that is not in the tables above, such as "inch" or "psi"."""
    import pint

    registry = _registry()
    try:
        one = registry.Unit(name)
        if not registry.Quantity(1, one)._is_multiplicative:
            raise UnitError(f"'{name}' has a zero of its own; give kelvin")
        base = registry.Quantity(1.0, one).to_base_units()
        powers = {"[length]": 0.0, "[mass]": 0.0, "[time]": 0.0, "[temperature]": 0.0}
        powers |= {key: float(power) for key, power in base.dimensionality.items()}
    except pint.UndefinedUnitError:
        hint = similar(name, [*PREFIXABLE, *PLAIN, "mm", "kN", "MPa", "GPa", "kg"])
        raise UnitError(f"'{name}' is not a known unit{hint}") from None
    if len(powers) > 4:
        raise UnitError(f"'{name}' is not a unit of mechanics or heat")
    length, mass, time, temperature = powers.values()
    return Unit(float(base.magnitude), (length, mass, time, temperature))
