"""Closed-form pressures and tractions of plane contact, to hold computed interfaces against."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from contactfem.common.typing import Floats

Profile = Callable[[Floats], Floats]


@dataclass(frozen=True)
class ContactSolution:
    """Pressure and traction along the interface coordinate x.

    Attributes:
        pressure: p(x), compression > 0 [Pa].
        traction: t(x), with the sign of the tangential load [Pa].
        half_width: half the width of the contact zone, infinite where all is in contact [m].
        stick_half_width: half the width of the stick zone, 0 without friction [m].
        center: middle of the contact zone [m].
        period: distance after which the solution repeats, infinite where it does not [m].
    """

    pressure: Profile
    traction: Profile
    half_width: float
    stick_half_width: float = 0.0
    center: float = 0.0
    period: float = math.inf


def _nothing(x: Floats) -> Floats:
    return np.zeros_like(x)


def _ellipse(x: Floats, half_width: float) -> Floats:
    """Return sqrt(1 - x²/a²), and zero outside."""
    if half_width <= 0.0:
        return np.zeros_like(x)
    height: Floats = np.sqrt(np.maximum(0.0, 1.0 - (x / half_width) ** 2))
    return height


def effective_modulus(
    youngs_modulus_1: float,
    poisson_ratio_1: float,
    youngs_modulus_2: float = math.inf,
    poisson_ratio_2: float = 0.0,
) -> float:
    """Effective modulus of a pair, 1/E* = (1 - ν₁²)/E₁ + (1 - ν₂²)/E₂.

    Args:
        youngs_modulus_1: Young's modulus of the first body [Pa].
        poisson_ratio_1: its Poisson ratio [-].
        youngs_modulus_2: Young's modulus of the second body, infinite if rigid [Pa].
        poisson_ratio_2: its Poisson ratio [-].

    Returns:
        E* [Pa].
    """
    compliance = (1.0 - poisson_ratio_1**2) / youngs_modulus_1
    return 1.0 / (compliance + (1.0 - poisson_ratio_2**2) / youngs_modulus_2)


def hertz_line(
    load: float, radius: float, modulus: float, radius_2: float = math.inf, center: float = 0.0
) -> ContactSolution:
    """Hertz's line contact, p = p₀ sqrt(1 - x²/a²), a² = 4PR/(πE*), p₀ = 2P/(πa).

    Args:
        load: normal force per length P [N/m].
        radius: radius of the first cylinder [m].
        modulus: effective modulus E* [Pa].
        radius_2: radius of the second cylinder, infinite if flat, negative if hollow [m].
        center: middle of the contact [m].

    Returns:
        The solution, without friction.

    References:
        K. L. Johnson, Contact Mechanics, Cambridge 1985, section 4.2.
    """
    curvature = 1.0 / radius + 1.0 / radius_2
    half_width = math.sqrt(4.0 * load / (math.pi * modulus * curvature))
    peak = 2.0 * load / (math.pi * half_width)
    return ContactSolution(
        pressure=lambda x: peak * _ellipse(x - center, half_width),
        traction=_nothing,
        half_width=half_width,
        center=center,
    )


def cattaneo_mindlin(
    load: float,
    tangential_load: float,
    friction_coefficient: float,
    radius: float,
    modulus: float,
    radius_2: float = math.inf,
    center: float = 0.0,
) -> ContactSolution:
    """Partial slip of like cylinders, t = μp₀ [sqrt(1 - x²/a²) - (c/a) sqrt(1 - x²/c²)].

    The stick zone has the half-width c = a sqrt(1 - |Q|/(μP)).

    Args:
        load: normal force per length P [N/m].
        tangential_load: tangential force per length Q, |Q| <= μP [N/m].
        friction_coefficient: Coulomb's coefficient μ [-].
        radius: radius of the first cylinder [m].
        modulus: effective modulus E* [Pa].
        radius_2: radius of the second cylinder, infinite if flat [m].
        center: middle of the contact [m].

    Returns:
        The solution; the traction has the sign of `tangential_load`.

    Raises:
        ValueError: if the tangential load exceeds what friction can carry.

    References:
        K. L. Johnson, Contact Mechanics, Cambridge 1985, section 7.2.
    """
    share = abs(tangential_load) / (friction_coefficient * load)
    if not share <= 1.0:
        raise ValueError(f"tangential_load is {share:.6g} times friction_coefficient * load")
    hertz = hertz_line(load, radius, modulus, radius_2, center)
    a = hertz.half_width
    c = a * math.sqrt(1.0 - share)
    peak = math.copysign(friction_coefficient * 2.0 * load / (math.pi * a), tangential_load)
    return ContactSolution(
        pressure=hertz.pressure,
        traction=lambda x: peak * (_ellipse(x - center, a) - c / a * _ellipse(x - center, c)),
        half_width=a,
        stick_half_width=c,
        center=center,
    )


def westergaard(
    mean_pressure: float,
    wave_length: float,
    amplitude: float,
    modulus: float,
    center: float = 0.0,
) -> ContactSolution:
    """Frictionless contact of a wavy surface, initial gap A (1 - cos 2πx/λ), p* = πE*A/λ.

    Partial contact, p̄ < p*: sin²(πa/λ) = p̄/p* and, with ψ = πx/λ and ψ_a = πa/λ,
    p = 2p̄ cos ψ / sin²ψ_a · sqrt(sin²ψ_a - sin²ψ). Full contact: p = p̄ + p* cos 2ψ.

    Args:
        mean_pressure: p̄ [Pa].
        wave_length: λ [m].
        amplitude: A, half the height from valley to crest [m].
        modulus: effective modulus E* [Pa].
        center: position of a crest [m].

    Returns:
        The solution, periodic in λ.

    References:
        H. M. Westergaard, Bearing pressures and cracks, J. Appl. Mech. 6 (1939) A49-A53.
    """
    full = math.pi * modulus * amplitude / wave_length

    def phase(x: Floats) -> Floats:
        angle: Floats = np.multiply(math.pi / wave_length, x - center)
        return angle

    def whole(x: Floats) -> Floats:
        return np.add(mean_pressure, full * np.cos(2.0 * phase(x)))

    if mean_pressure >= full:
        return ContactSolution(
            whole, _nothing, 0.5 * wave_length, center=center, period=wave_length
        )
    share = mean_pressure / full

    def part(x: Floats) -> Floats:
        root = np.sqrt(np.maximum(0.0, share - np.sin(phase(x)) ** 2))
        shape: Floats = 2.0 * mean_pressure / share * np.abs(np.cos(phase(x))) * root
        return shape

    half_width = wave_length / math.pi * math.asin(math.sqrt(share))
    return ContactSolution(part, _nothing, half_width, center=center, period=wave_length)


def uniform(pressure: float, traction: float = 0.0) -> ContactSolution:
    """Constant pressure and traction, as in a patch test.

    Args:
        pressure: p [Pa].
        traction: t [Pa].

    Returns:
        The solution, in contact everywhere.
    """
    return ContactSolution(
        pressure=lambda x: np.full_like(x, pressure),
        traction=lambda x: np.full_like(x, traction),
        half_width=math.inf,
    )


@dataclass(frozen=True)
class ClosedFormSpec:
    """A closed form a case file can name.

    Attributes:
        units: SI unit of each parameter, "" without dimension.
        defaults: values of the parameters that may be left out.
        build: from all parameters to the solution.
    """

    units: Mapping[str, str]
    defaults: Mapping[str, float]
    build: Callable[[Mapping[str, float]], ContactSolution]


_MODULI = {
    "effective_modulus": "Pa",
    "youngs_modulus_1": "Pa",
    "poisson_ratio_1": "",
    "youngs_modulus_2": "Pa",
    "poisson_ratio_2": "",
}
_NO_MODULI = {name: math.nan for name in _MODULI} | {
    "youngs_modulus_2": math.inf,
    "poisson_ratio_2": 0.0,
}
_CYLINDERS = {"load": "N/m", "radius": "m", "radius_2": "m", "center": "m"} | _MODULI
_ONE_CYLINDER = {"radius_2": math.inf, "center": 0.0} | _NO_MODULI


def _modulus(q: Mapping[str, float]) -> float:
    """Return the effective modulus, from either way to give it."""
    given = not math.isnan(q["effective_modulus"])
    parts = (q["youngs_modulus_1"], q["poisson_ratio_1"])
    if given == (not any(math.isnan(part) for part in parts)):
        raise ValueError("give effective_modulus, or youngs_modulus_1 and poisson_ratio_1")
    if given:
        return q["effective_modulus"]
    return effective_modulus(*parts, q["youngs_modulus_2"], q["poisson_ratio_2"])


CLOSED_FORMS: Mapping[str, ClosedFormSpec] = {
    "hertz_line": ClosedFormSpec(
        units=_CYLINDERS,
        defaults=_ONE_CYLINDER,
        build=lambda q: hertz_line(q["load"], q["radius"], _modulus(q), q["radius_2"], q["center"]),
    ),
    "cattaneo_mindlin": ClosedFormSpec(
        units=_CYLINDERS | {"tangential_load": "N/m", "friction_coefficient": ""},
        defaults=_ONE_CYLINDER,
        build=lambda q: cattaneo_mindlin(
            q["load"],
            q["tangential_load"],
            q["friction_coefficient"],
            q["radius"],
            _modulus(q),
            q["radius_2"],
            q["center"],
        ),
    ),
    "westergaard": ClosedFormSpec(
        units={"mean_pressure": "Pa", "wave_length": "m", "amplitude": "m", "center": "m"}
        | _MODULI,
        defaults={"center": 0.0} | _NO_MODULI,
        build=lambda q: westergaard(
            q["mean_pressure"], q["wave_length"], q["amplitude"], _modulus(q), q["center"]
        ),
    ),
    "uniform": ClosedFormSpec(
        units={"pressure": "Pa", "traction": "Pa"},
        defaults={"traction": 0.0},
        build=lambda q: uniform(q["pressure"], q["traction"]),
    ),
}


def closed_form(name: str, parameters: Mapping[str, float]) -> ContactSolution:
    """Build a closed form from its name and its parameters, as a case file gives them.

    Args:
        name: key of `CLOSED_FORMS`.
        parameters: value of each parameter [SI].

    Returns:
        The solution.

    Raises:
        ValueError: if a parameter is unknown or missing, or if they do not fit together.
    """
    spec = CLOSED_FORMS[name]
    unknown = sorted(set(parameters) - set(spec.units))
    missing = sorted(set(spec.units) - set(spec.defaults) - set(parameters))
    if unknown or missing:
        what = f"unknown {unknown[0]!r}" if unknown else f"missing {missing[0]!r}"
        raise ValueError(f"{what}; {name} takes {', '.join(spec.units)}")
    try:
        return spec.build({**spec.defaults, **parameters})
    except ArithmeticError as error:
        raise ValueError(f"{name} has no solution for these values: {error}") from None
