"""Closed forms with conductance that depends on pressure.

Temperatures θ are over the stress-free state, pressures p > 0 in compression, gaps g > 0 open.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, root

from contactfem.common.typing import Floats
from contactfem.laws.conductance import ConductanceLaw, under_pressure
from contactfem.verification.heat_steady import Bar, two_bars
from contactfem.verification.homogeneous import NeoHooke

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(20)


@dataclass(frozen=True)
class Rod:
    """Rod with free sides between a rigid wall and the contact.

    Attributes:
        bar: length [m], conductivity [W/m/K] and temperature of the wall [K].
        youngs_modulus: E [Pa].
        expansion: linear thermal expansion α [1/K].
    """

    bar: Bar
    youngs_modulus: float
    expansion: float


@dataclass(frozen=True)
class RodContact:
    """Steady state of two bodies that touch between two walls.

    Attributes:
        pressure: p, 0 where they do not touch [Pa].
        flux: q [W/m²].
        nonmortar: surface temperature of nonmortar [K].
        mortar: the same of mortar [K].
        length: deformed length of nonmortar [m].
    """

    pressure: float
    flux: float
    nonmortar: float
    mortar: float
    length: float


def rods(nonmortar: Rod, mortar: Rod, gap: float, law: ConductanceLaw) -> RodContact:
    """Two rods between rigid walls that heat brings together, small strain.

    p Σ L/E = Σ α L (θ_wall + θ_surface)/2 - g, with the temperatures of `two_bars` at h(p).

    Args:
        nonmortar: rod on the nonmortar side.
        mortar: rod on the mortar side.
        gap: g of the unheated rods, < 0 if pressed together [m].
        law: conductance over pressure.

    Returns:
        The state; without contact h is taken as 0.
    """
    sides = (nonmortar, mortar)
    compliance = sum(rod.bar.length / rod.youngs_modulus for rod in sides)

    def free_stroke(surfaces: tuple[float, float]) -> float:
        """Return how far the rods would overlap without a pressure."""
        pairs = zip(sides, surfaces, strict=True)
        return -gap + sum(
            rod.expansion * rod.bar.length * 0.5 * (rod.bar.end + surface) for rod, surface in pairs
        )

    def surfaces(p: float) -> tuple[float, float]:
        state = two_bars(nonmortar.bar, mortar.bar, under_pressure(law, p)[0])
        return state.nonmortar, state.mortar

    def excess(p: float) -> float:
        return p * compliance - free_stroke(surfaces(p))

    ends = (nonmortar.bar.end, mortar.bar.end)
    p = 0.0
    if free_stroke(ends) > 0.0:
        hottest = max(free_stroke((a, b)) for a in ends for b in ends)
        p = brentq(excess, 0.0, 2.0 * hottest / compliance, xtol=1e-14 * hottest / compliance)
    h = under_pressure(law, p)[0] if p > 0.0 else 0.0
    state = two_bars(nonmortar.bar, mortar.bar, h)
    heated = nonmortar.expansion * 0.5 * (nonmortar.bar.end + state.nonmortar)
    stretch = 1.0 + heated - p / nonmortar.youngs_modulus
    return RodContact(p, state.out, state.nonmortar, state.mortar, nonmortar.bar.length * stretch)


@dataclass(frozen=True)
class ConfinedBlock:
    """Neo-Hooke block that cannot expand sideways, between a rigid wall and the contact.

    Attributes:
        solid: its material; the temperature in it is not used.
        bar: undeformed length [m], conductivity [W/m/K] and temperature of the wall [K].
    """

    solid: NeoHooke
    bar: Bar

    def volume_ratio(self, pressure: float, theta: Floats) -> Floats:
        """Volume ratio J under an axial pressure [Pa] at temperatures θ [K].

        K (ln J - 3αθ) + 2/3 μ (J^(4/3) - J^(-2/3)) + p J = 0, monotone in ln J.
        """
        K, shear = self.solid.bulk_modulus, 2.0 / 3.0 * self.solid.shear_modulus
        free = 3.0 * self.solid.expansion * theta
        log = np.zeros_like(free)
        for _ in range(60):
            a, b, c = np.exp(4.0 / 3.0 * log), np.exp(-2.0 / 3.0 * log), pressure * np.exp(log)
            residual = K * (log - free) + shear * (a - b) + c
            change = residual / (K + shear * (4.0 * a + 2.0 * b) / 3.0 + c)
            log = log - change
            if np.abs(change).max() < 1e-15:
                break
        return np.exp(log)

    def mean_contraction(self, pressure: float, surface: float) -> float:
        """Undeformed over deformed length, the mean of 1/J over the temperatures in the block."""
        wall = self.bar.end
        theta = 0.5 * (wall + surface) + 0.5 * (wall - surface) * _POINTS
        return float(0.5 * _WEIGHTS @ (1.0 / self.volume_ratio(pressure, theta)))


def confined_blocks(
    nonmortar: ConfinedBlock, mortar: ConfinedBlock, distance: float, law: ConductanceLaw
) -> RodContact:
    """Two laterally confined blocks between walls of different temperature, finite strain.

    The area is that of the undeformed blocks, so θ is linear over the deformed length l, and
    k Δθ = q l, L = l mean(1/J), l_nm + l_m = distance, q = h(p) (θ_nm - θ_m).

    Args:
        nonmortar: block on the nonmortar side.
        mortar: block on the mortar side.
        distance: of the walls; less than the length of the unheated blocks [m].
        law: conductance over pressure.

    Returns:
        The state.

    Raises:
        ValueError: if no state in contact was found.
    """
    bars = (nonmortar.bar, mortar.bar)
    undeformed = bars[0].length + bars[1].length
    scale = nonmortar.solid.bulk_modulus + 4.0 / 3.0 * nonmortar.solid.shear_modulus
    span = max(abs(bars[0].end - bars[1].end), 1.0)

    def lengths(p: float, surfaces: Floats) -> tuple[float, float]:
        first = nonmortar.mean_contraction(p, surfaces[0])
        return bars[0].length / first, bars[1].length / mortar.mean_contraction(p, surfaces[1])

    def residual(v: Floats) -> list[float]:
        p, surfaces = scale * v[0], v[1:]
        first, second = lengths(p, surfaces)
        q = under_pressure(law, p)[0] * (surfaces[0] - surfaces[1])
        return [
            (first + second) / distance - 1.0,
            ((bars[0].end - surfaces[0]) - q * first / bars[0].conductivity) / span,
            ((surfaces[1] - bars[1].end) - q * second / bars[1].conductivity) / span,
        ]

    p = scale * max(1.0 - distance / undeformed, 1e-3)
    guess = two_bars(*bars, under_pressure(law, p)[0])
    found = root(residual, [p / scale, guess.nonmortar, guess.mortar], tol=1e-13)
    p, surfaces = scale * found.x[0], found.x[1:]
    if not np.abs(residual(found.x)).max() < 1e-10 or p <= 0.0:
        raise ValueError(f"no state in contact found: {found.message}")
    q = under_pressure(law, p)[0] * float(surfaces[0] - surfaces[1])
    return RodContact(p, q, float(surfaces[0]), float(surfaces[1]), lengths(p, surfaces)[0])
