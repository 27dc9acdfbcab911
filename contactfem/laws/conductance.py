"""Conductance of an interface (15).

They know nothing of segments or meshes; every argument is an array over points.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from contactfem.common.typing import Floats

TINY = 1e-8  # share of the hardness below which a power law with exponent < 1 is made smooth


class Conductance(NamedTuple):
    """Conductance h [W/m²/K] with dh/dp [W/m²/K/Pa] and dh/dg [W/m³/K], each (n,)."""

    h: Floats
    dh_dp: Floats
    dh_dgap: Floats


# From pressure p (n,) [Pa], 0 where open, and gap g (n,), > 0 open [m]; a user's law is one, too.
ConductanceLaw = Callable[[Floats, Floats], Conductance]


@dataclass(frozen=True)
class PowerLaw:
    """Conductance of rough surfaces under pressure, h = h_c0 (p/H_v)^ε (15); 0 where open.

    For ε < 1 the slope at p = 0 would be infinite. Below the pressure p_t = 1e-8 H_v it is then
    h = h(p_t) x (1 + (1 - ε)(1 - x)), x = p/p_t: monotone, with the value and the slope of the
    power law at p_t, and with the slope (2 - ε) h(p_t)/p_t at p = 0.

    Attributes:
        coefficient: h_c0 [W/m²/K].
        hardness: Vickers hardness H_v [Pa].
        exponent: ε > 0 [-].
    """

    coefficient: float
    hardness: float
    exponent: float

    def __str__(self) -> str:
        return f"power law {self.coefficient:g} W/m²/K (p / {self.hardness:g} Pa)^{self.exponent:g}"

    def __call__(self, pressure: Floats, gap: Floats) -> Conductance:
        """Conductance at some points."""
        e = self.exponent
        closed = pressure > 0.0
        y = np.where(closed, pressure, self.hardness) / self.hardness
        if e < 1.0:
            x, y = np.minimum(y / TINY, 1.0), np.maximum(y, TINY)
            tiny, a = x < 1.0, 1.0 - e
            h = np.where(tiny, TINY**e * x * (1.0 + a * (1.0 - x)), y**e)
            slope = np.where(tiny, TINY**-a * (1.0 + a * (1.0 - 2.0 * x)), e * y**-a)
        else:
            h, slope = y**e, e * y ** (e - 1.0)
        return Conductance(
            np.where(closed, self.coefficient * h, 0.0),
            np.where(closed, self.coefficient / self.hardness * slope, 0.0),
            np.zeros_like(pressure),
        )


@dataclass(frozen=True)
class Constant:
    """Conductance that is the same wherever there is contact; 0 where open.

    Attributes:
        conductance: h [W/m²/K].
    """

    conductance: float

    def __str__(self) -> str:
        return f"constant {self.conductance:g} W/m²/K"

    def __call__(self, pressure: Floats, gap: Floats) -> Conductance:
        """Conductance at some points."""
        zero = np.zeros_like(pressure)
        return Conductance(np.where(pressure > 0.0, self.conductance, 0.0), zero, zero)


@dataclass(frozen=True)
class GasGap:
    """Conductance of a gas in the gap, h = k_gas / (g⁺ + g_0) with g⁺ = max(g, 0); also where open.

    Attributes:
        conductivity: k_gas [W/m/K].
        residual_gap: g_0 > 0, thickness of the gas between surfaces in contact [m].
    """

    conductivity: float
    residual_gap: float

    def __str__(self) -> str:
        return f"gas {self.conductivity:g} W/m/K over the gap and {self.residual_gap:g} m"

    def __call__(self, pressure: Floats, gap: Floats) -> Conductance:
        """Conductance at some points."""
        thickness = np.maximum(gap, 0.0) + self.residual_gap
        h = np.asarray(self.conductivity / thickness, np.float64)
        return Conductance(h, np.zeros_like(h), np.where(gap > 0.0, -h / thickness, 0.0))


@dataclass(frozen=True)
class Parallel:
    """Laws side by side, such as a gas beside the spots in contact: h = Σ h_i.

    Attributes:
        laws: whose conductances are added.
    """

    laws: tuple[ConductanceLaw, ...]

    def __str__(self) -> str:
        return " + ".join(str(law) for law in self.laws)

    def __call__(self, pressure: Floats, gap: Floats) -> Conductance:
        """Conductance at some points."""
        zero = np.zeros_like(pressure)
        h, dh_dp, dh_dgap = zero, zero, zero
        for law in self.laws:
            one = law(pressure, gap)
            h, dh_dp, dh_dgap = h + one.h, dh_dp + one.dh_dp, dh_dgap + one.dh_dgap
        return Conductance(h, dh_dp, dh_dgap)


def under_pressure(law: ConductanceLaw, pressure: float) -> tuple[float, float]:
    """Conductance of surfaces without a gap under one pressure [Pa]: h and dh/dp."""
    at = law(np.array([pressure]), np.zeros(1))
    return float(at.h[0]), float(at.dh_dp[0])
