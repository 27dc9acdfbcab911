"""Closed forms of steady heat conduction through contact.

Bodies are named as in an interface: nonmortar (nm) and mortar (m); the heat conducted through it is
h (θ_nm - θ_m), and the frictional power d enters nonmortar with the share f.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from contactfem.common.typing import Floats


@dataclass(frozen=True)
class Bar:
    """Bar between the interface and an end of given temperature.

    Attributes:
        length: L [m].
        conductivity: k [W/m/K].
        end: temperature of the far end [K].
    """

    length: float
    conductivity: float
    end: float

    @property
    def resistance(self) -> float:
        """L/k [m² K/W]."""
        return self.length / self.conductivity


@dataclass(frozen=True)
class TwoBars:
    """Steady state of two bars.

    Attributes:
        nonmortar: surface temperature of the nonmortar bar [K].
        mortar: the same of the mortar bar [K].
        out: heat that leaves nonmortar, q - f d [W/m²].
        into: heat that enters mortar, q + (1 - f) d [W/m²].
    """

    nonmortar: float
    mortar: float
    out: float
    into: float


def two_bars(
    nonmortar: Bar,
    mortar: Bar,
    conductance: float,
    dissipation: float = 0.0,
    partition: float = 0.5,
) -> TwoBars:
    """Two bars with a conductance and frictional heat between them, in the steady state.

    With R = L/k, q (R_nm + 1/h + R_m) = θ_nm,end - θ_m,end + f d R_nm - (1 - f) d R_m.

    Args:
        nonmortar: bar on the nonmortar side.
        mortar: bar on the mortar side.
        conductance: h [W/m²/K].
        dissipation: d [W/m²].
        partition: f [-].

    Returns:
        Surface temperatures and fluxes.
    """
    own, other = partition * dissipation, (1.0 - partition) * dissipation
    drive = nonmortar.end - mortar.end + own * nonmortar.resistance - other * mortar.resistance
    q = conductance * drive / (1.0 + conductance * (nonmortar.resistance + mortar.resistance))
    return TwoBars(
        nonmortar=nonmortar.end - (q - own) * nonmortar.resistance,
        mortar=mortar.end + (q + other) * mortar.resistance,
        out=q - own,
        into=q + other,
    )


def rise_by_sliding(work: float, *heat_capacities: float) -> float:
    """Temperature rise of insulated bodies when they have shared the work of friction, W / Σ ρcH.

    Args:
        work: of friction per area that goes into these bodies, for a block f μ p s [J/m²].
        heat_capacities: ρc H of each body per area [J/m²/K].

    Returns:
        The rise [K].
    """
    return work / sum(heat_capacities)


@dataclass(frozen=True)
class RodInRing:
    """Rod that a uniform source heats, in a ring whose outside is held at a temperature.

    Attributes:
        radius: a, of the rod [m].
        outer_radius: b, of the ring [m].
        conductivity_rod: [W/m/K].
        conductivity_ring: [W/m/K].
        power: P, of the source per length [W/m].
        conductance: h [W/m²/K].
        outside: θ at b [K].
    """

    radius: float
    outer_radius: float
    conductivity_rod: float
    conductivity_ring: float
    power: float
    conductance: float
    outside: float = 0.0

    def ring(self, r: npt.ArrayLike) -> Floats:
        """Temperature of the ring at radii [m], θ_b + P/(2πk) ln(b/r), in K."""
        scale = self.power / (2.0 * math.pi * self.conductivity_ring)
        return np.asarray(self.outside + scale * np.log(self.outer_radius / np.asarray(r)))

    def rod(self, r: npt.ArrayLike) -> Floats:
        """Temperature of the rod at radii [m], θ_ring(a) + P/(2πah) + P/(4πk) (1 - r²/a²), in K."""
        surface = self.ring(self.radius) + self.power / (
            2.0 * math.pi * self.radius * self.conductance
        )
        scale = self.power / (4.0 * math.pi * self.conductivity_rod)
        return np.asarray(surface + scale * (1.0 - (np.asarray(r) / self.radius) ** 2))
