"""Quantities of a case file: "35 N/mm^2" becomes a float in SI.

A model validated with the context `STRICT` (every case file is) takes strings with units only;
models made in Python also take plain numbers, as SI.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from contactfem.common.place_time import Profile
from contactfem.common.time_table import Table, constant
from contactfem.common.unit_parser import (
    DIMENSIONS,
    UnitError,
    dimension,
    has_zero,
    kelvin,
    scaled,
    split,
    unit,
    with_article,
)
from contactfem.common.user_function import FunctionRef, is_reference, reference

STRICT: Mapping[str, Any] = {"strict_units": True}

LARGEST = 1e60  # in SI: no quantity is larger, and products of several can be calculated with

EXAMPLES = {
    "m": "10 mm",
    "s": "0.5 s",
    "K": "20 K",
    "Pa": "210 GPa",
    "N": "3.5 kN",
    "N/m": "35 kN/m",
    "N/m^3": "78 kN/m^3",
    "1/K": "1.2e-5 1/K",
    "kg/m^3": "7850 kg/m^3",
    "W/m/K": "45 W/m/K",
    "J/kg/K": "460 J/kg/K",
    "W/m^2": "5 kW/m^2",
    "W/m^3": "1 MW/m^3",
    "W/m^2/K": "150 W/m^2/K",
}


def si(text: str, symbol: str, *, difference: bool = False) -> float:
    """Read a quantity.

    Args:
        text: number and unit, such as "35 N/mm^2".
        symbol: SI unit of what is expected, such as "Pa".
        difference: whether "1 degC" is a difference of 1 K, not the temperature 274.15 K.

    Returns:
        The value [symbol].

    Raises:
        UnitError: not a quantity, or one of another dimension.
    """
    number, rest = split(text)
    if symbol and not rest:
        raise UnitError("has no unit")
    found, expected = unit(rest), unit(symbol)
    if found.exponents != expected.exponents:
        raise UnitError(f"is {dimension(found.exponents)}, not {dimension(expected.exponents)}")
    value = kelvin(number, rest) if _on_scale(rest, difference) else scaled(number, found.factor)
    if _on_scale(rest, difference) and value < 0.0:
        raise UnitError("is below absolute zero")
    if not abs(value) <= LARGEST:
        raise UnitError("is too large a number")
    if 0.0 < abs(value) < 1.0 / LARGEST:
        raise UnitError("is too small a number")
    return value


def _on_scale(symbol: str, difference: bool) -> bool:
    return has_zero(symbol) and not difference


def allowed(symbol: str) -> str:
    """What a quantity with an SI unit must be: "a length such as '10 mm'"."""
    name = DIMENSIONS.get(symbol, f"quantity in {symbol}")
    return f"{with_article(name)} such as '{EXAMPLES.get(symbol, f'1 {symbol}')}'"


def _wrong(why: str, allowed: str) -> PydanticCustomError:
    context = {"why": why, "allowed": allowed}
    return PydanticCustomError("quantity", "{why}; give {allowed}", context)


def read_quantity(
    value: object, symbol: str, info: ValidationInfo, *, difference: bool = False
) -> float:
    """One quantity from a case file or from Python; of a difference of temperatures or a value.

    Raises:
        PydanticCustomError: with what is wrong and what is allowed.
    """
    strict = bool((info.context or {}).get("strict_units"))
    if isinstance(value, str):
        try:
            return si(value, symbol, difference=difference)
        except UnitError as error:
            raise _wrong(str(error), allowed(symbol)) from None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise _wrong("is not a quantity", allowed(symbol))
    if strict and symbol:
        raise _wrong("has no unit", allowed(symbol))
    return _finite(value, allowed(symbol))


def _finite(value: float, allowed: str) -> float:
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise _wrong("is not finite", allowed)
    return number


def _string(symbol: str) -> dict[str, Any]:
    return {"type": "string", "examples": [EXAMPLES.get(symbol, f"1 {symbol}")]}


@dataclass(frozen=True)
class Quantity:
    """Marks a float that is read from a number with a unit of the dimension of `symbol`."""

    symbol: str
    difference: bool = False

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Read before the float is checked, so that limits act on the SI value."""

        def read(value: object, info: ValidationInfo) -> float:
            return read_quantity(value, self.symbol, info, difference=self.difference)

        return core_schema.with_info_before_validator_function(read, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Editors see a string, with an example."""
        return {**_string(self.symbol), "description": allowed(self.symbol)}


@dataclass(frozen=True)
class AnyQuantity:
    """Marks a float that is read from a number, or from a string with a unit of any dimension.

    Attributes:
        difference: whether "1 degC" is a difference of 1 K, not the temperature 274.15 K.
    """

    difference: bool = False

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Read strings; leave plain numbers alone."""
        return core_schema.no_info_before_validator_function(self._value, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Editors see a number or a string."""
        return {"anyOf": [{"type": "number"}, {"type": "string", "examples": ["10 mm"]}]}

    def _value(self, value: object) -> object:
        allowed = "a finite number, or one with a unit such as '10 mm'"
        if isinstance(value, str):
            try:
                number, rest = split(value)
                if _on_scale(rest, self.difference):
                    value = kelvin(number, rest)
                else:
                    value = scaled(number, unit(rest).factor)
            except UnitError as error:
                raise _wrong(str(error), allowed) from None
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise _wrong("is not a number", allowed)
        return _finite(value, allowed)


@dataclass(frozen=True)
class TableOf:
    """Marks a `Table` whose values have the dimension of `symbol`."""

    symbol: str

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Read a constant or rows of time and value."""
        return core_schema.with_info_plain_validator_function(self._table)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Editors see a quantity, or rows [time, quantity]."""
        value = _string(self.symbol)
        pair = {"type": "array", "prefixItems": [_string("s"), value], "minItems": 2, "maxItems": 2}
        return {"anyOf": [value, {"type": "array", "items": pair, "minItems": 2}]}

    def _table(self, value: object, info: ValidationInfo) -> Any:
        if isinstance(value, Table):
            return value
        # The case's dimension may ask for another unit, as N for N/m.
        symbol = (info.context or {}).get("units", {}).get(self.symbol, self.symbol)
        if not isinstance(value, list | tuple):
            return constant(read_quantity(value, symbol, info))
        rows = _rows(value, symbol)
        times = tuple(read_quantity(row[0], "s", info) for row in rows)
        for before, after in pairwise(times):
            if not before < after:
                why = f"times are out of order: {after:g} s follows {before:g} s"
                raise _wrong(why, "ascending times")
        return Table(times, tuple(read_quantity(row[1], symbol, info) for row in rows))


@dataclass(frozen=True)
class FieldOf(TableOf):
    """Marks a `Table`, a `Profile`, or a user's function of place and time, of one dimension."""

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Editors see a quantity, rows of time and quantity, or the name of a function."""
        table = super().__get_pydantic_json_schema__(schema, handler)
        example = _profile(self.symbol)
        over = {"type": "object", "required": ["over", "table"], "examples": [example]}
        function = {"type": "string", "examples": ["fields.py:source"]}
        return {"anyOf": [*table["anyOf"], over, function]}

    def _table(self, value: object, info: ValidationInfo) -> Any:
        if isinstance(value, FunctionRef | Profile):
            return value
        if isinstance(value, dict):
            return self._over_place(value, info)
        if isinstance(value, str) and is_reference(value):
            return reference(value)
        return super()._table(value, info)

    def _over_place(self, value: dict[str, object], info: ValidationInfo) -> Profile:
        """A table over one coordinate, { over = "x", table = [[place, value], ...] }."""
        symbol = (info.context or {}).get("units", {}).get(self.symbol, self.symbol)
        axis, rows = value.get("over"), value.get("table")
        known = axis in ("x", "y", "z") and value.keys() <= {"over", "table", "factor"}
        if not known or not isinstance(rows, list | tuple):
            raise _wrong("is not a table over a coordinate", f"{_profile(symbol)}")
        pairs = _rows(rows, symbol)
        places = tuple(read_quantity(row[0], "m", info) for row in pairs)
        for before, after in pairwise(places):
            if not before < after:
                why = f"places are out of order: {after:g} m follows {before:g} m"
                raise _wrong(why, "ascending places")
        values = tuple(read_quantity(row[1], symbol, info) for row in pairs)
        factor = TableOf("")._table(value.get("factor", 1.0), info)
        return Profile(("x", "y", "z").index(str(axis)), places, values, factor)


def _profile(symbol: str) -> str:
    """Example of a table over a coordinate."""
    example = EXAMPLES.get(symbol, f"1 {symbol}")
    rows = f"[['0 mm', '{example}'], ['10 mm', '{example}']]"
    return f"{{ over = 'x', table = {rows} }}"


def _rows(value: Sequence[object], symbol: str) -> list[Sequence[object]]:
    rows: list[Sequence[object]] = [
        row for row in value if isinstance(row, list | tuple) and len(row) == 2
    ]
    if len(rows) != len(value) or len(rows) < 2:
        example = EXAMPLES.get(symbol, f"1 {symbol}")
        raise _wrong(
            "is not a table",
            f"{allowed(symbol)}, or at least two rows [['0 s', '{example}'], ...]",
        )
    return rows


Length = Annotated[float, Quantity("m")]
Duration = Annotated[float, Quantity("s")]
Pressure = Annotated[float, Quantity("Pa")]
Temperature = Annotated[float, Quantity("K")]
TemperatureDifference = Annotated[float, Quantity("K", difference=True)]
ForcePerLength = Annotated[float, Quantity("N/m")]
Expansion = Annotated[float, Quantity("1/K")]
Density = Annotated[float, Quantity("kg/m^3")]
Conductivity = Annotated[float, Quantity("W/m/K")]
HeatCapacity = Annotated[float, Quantity("J/kg/K")]
Number = Annotated[float, AnyQuantity()]
Difference = Annotated[float, AnyQuantity(difference=True)]

LengthTable = Annotated[Table, TableOf("m")]
PressureTable = Annotated[Table, TableOf("Pa")]
TemperatureTable = Annotated[Table, TableOf("K")]
ForcePerVolume = Annotated[float, Quantity("N/m^3")]
VolumeForceTable = Annotated[Table, TableOf("N/m^3")]
LineForceTable = Annotated[Table, TableOf("N/m")]

Conductance = Annotated[float, Quantity("W/m^2/K")]
HeatFluxTable = Annotated[Table, TableOf("W/m^2")]
Given = Table | Profile | FunctionRef
TemperatureField = Annotated[Given, FieldOf("K")]
HeatFluxField = Annotated[Given, FieldOf("W/m^2")]
HeatSourceField = Annotated[Given, FieldOf("W/m^3")]
LengthField = Annotated[Given, FieldOf("m")]
PressureField = Annotated[Given, FieldOf("Pa")]
VolumeForceField = Annotated[Given, FieldOf("N/m^3")]
ConductanceField = Annotated[Given, FieldOf("W/m^2/K")]
