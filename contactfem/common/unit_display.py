"""Numbers as engineers read them: millimetres and megapascals instead of bare SI."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Scale:
    """A unit to show numbers in: shown = SI value / factor.

    Attributes:
        label: the unit as printed.
        factor: one of it in SI.
    """

    label: str
    factor: float


# per SI unit: from which magnitude on which unit is shown, ascending
_STEPS: dict[str, tuple[tuple[float, Scale], ...]] = {
    "m": (
        (0.0, Scale("nm", 1e-9)),
        (1e-7, Scale("µm", 1e-6)),
        (1e-4, Scale("mm", 1e-3)),
        (1.0, Scale("m", 1.0)),
    ),
    "Pa": (
        (0.0, Scale("Pa", 1.0)),
        (1e3, Scale("kPa", 1e3)),
        (1e5, Scale("MPa", 1e6)),
        (1e10, Scale("GPa", 1e9)),
    ),
    "N/m": ((0.0, Scale("N/m", 1.0)), (10.0, Scale("N/mm", 1e3)), (1e7, Scale("kN/mm", 1e6))),
    "N": ((0.0, Scale("N", 1.0)), (1e4, Scale("kN", 1e3)), (1e7, Scale("MN", 1e6))),
    "J": ((0.0, Scale("mJ", 1e-3)), (1.0, Scale("J", 1.0)), (1e4, Scale("kJ", 1e3))),
    "J/m": ((0.0, Scale("mJ/m", 1e-3)), (1.0, Scale("J/m", 1.0)), (1e4, Scale("kJ/m", 1e3))),
    "W": ((0.0, Scale("mW", 1e-3)), (1.0, Scale("W", 1.0)), (1e4, Scale("kW", 1e3))),
    "W/m": ((0.0, Scale("mW/m", 1e-3)), (1.0, Scale("W/m", 1.0)), (1e4, Scale("kW/m", 1e3))),
    "W/m^2": (
        (0.0, Scale("W/m²", 1.0)),
        (1e3, Scale("kW/m²", 1e3)),
        (1e6, Scale("MW/m²", 1e6)),
    ),
    "s": ((0.0, Scale("µs", 1e-6)), (1e-4, Scale("ms", 1e-3)), (0.1, Scale("s", 1.0))),
}


def scale_for(magnitude: float, unit: str) -> Scale:
    """Choose the unit in which a magnitude reads well.

    Args:
        magnitude: largest absolute value to be shown [unit].
        unit: SI unit of the values, "" without dimension.

    Returns:
        The scale; a zero, a NaN or an unknown unit is left in SI.
    """
    if unit not in _STEPS or not math.isfinite(magnitude) or magnitude == 0.0:
        return Scale(unit, 1.0)
    size = abs(magnitude)
    return [scale for start, scale in _STEPS[unit] if start <= size][-1]


def engineering(value: float, unit: str = "", digits: int = 5) -> str:
    """Write a value in the unit in which it reads well.

    Args:
        value: the value [unit].
        unit: SI unit, "" without dimension.
        digits: significant digits.

    Returns:
        For instance "3585.4 MPa".
    """
    scale = scale_for(value, unit)
    return f"{value / scale.factor:.{digits}g} {scale.label}".rstrip()
