"""Closed forms of thermoelastic stability: Barber's rod, isothermal split.

Temperatures θ are over the stress-free state, pressures p > 0 in compression, gaps g > 0 open.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from contactfem.laws.conductance import ConductanceLaw, under_pressure


def _characteristic(eigenvalue: float, biot: float, coupling: float) -> float:
    """Return cosh s + Bi sinh s / s - C (cosh s - 1) / s² with s² = λ of either sign."""
    s = math.sqrt(abs(eigenvalue))
    if s < 1e-4:  # the first terms of the series are exact to round-off
        return 1.0 + biot - 0.5 * coupling + eigenvalue * (0.5 + biot / 6.0 - coupling / 24.0)
    even, odd = (math.cosh, math.sinh) if eigenvalue > 0.0 else (math.cos, math.sin)
    half = odd(0.5 * s) / s  # cosh s - 1 = 2 sinh²(s/2)
    return even(s) + biot * odd(s) / s - 2.0 * coupling * half**2


def barber_growth(biot: float, coupling: float) -> float:
    """Leading eigenvalue of Barber's rod, φ'' = λφ, φ(0) = 0, φ'(1) + Bi φ(1) = C ∫φ.

    Unstable, λ > 0, if and only if C > 2 (1 + Bi).

    Args:
        biot: Bi = hL/k [-].
        coupling: C, how much the heat through the end grows with the mean temperature, >= 0 [-].

    Returns:
        λ in units of κ/L² [-].

    Raises:
        ValueError: if the coupling is negative.
    """
    if coupling < 0.0:
        raise ValueError(f"coupling is {coupling:g}, it must be >= 0")
    if _characteristic(0.0, biot, coupling) == 0.0:
        return 0.0
    low, high = -(math.pi**2), 0.0  # at low the characteristic is -1 - 2C/π²
    if coupling > 2.0 * (1.0 + biot):
        low, high = 0.0, 1.0
        while _characteristic(high, biot, coupling) < 0.0:
            high *= 2.0
    return float(brentq(_characteristic, low, high, args=(biot, coupling), xtol=1e-15, rtol=1e-14))


@dataclass(frozen=True)
class BarberState:
    """Steady state of Barber's rod.

    Attributes:
        pressure: p, 0 if the rod does not touch [Pa].
        surface: temperature of the end that touches [K].
        biot: Bi = hL/k [-].
        coupling: C = dh/dp (L/k) E α (θ_wall - θ_surface) [-].
        growth: of a small disturbance, > 0 if unstable [1/s].
    """

    pressure: float
    surface: float
    biot: float
    coupling: float
    growth: float


@dataclass(frozen=True)
class BarberRod:
    """Rod with free sides, held at θ = 0 at one end, whose other end touches a rigid warm wall.

    p = p_0 + E α mean(θ) and -k θ'(L) = h(p) (θ(L) - θ_wall), so its own heat presses it on.

    Attributes:
        length: L [m].
        youngs_modulus: E [Pa].
        expansion: α [1/K].
        conductivity: k [W/m/K].
        heat_capacity: ρc [J/m³/K].
        wall: θ_wall > 0 [K].
        start: p_0, pressure of the cold rod, -E g/L if there is a gap g [Pa].
        law: conductance over pressure.
    """

    length: float
    youngs_modulus: float
    expansion: float
    conductivity: float
    heat_capacity: float
    wall: float
    start: float
    law: ConductanceLaw

    @property
    def rate(self) -> float:
        """κ/L² [1/s]."""
        return self.conductivity / self.heat_capacity / self.length**2

    def state(self, pressure: float) -> BarberState:
        """State with a linear temperature that belongs to a pressure [Pa] in contact."""
        h, dh_dp = under_pressure(self.law, pressure)
        biot = h * self.length / self.conductivity
        surface = self.wall * biot / (1.0 + biot)
        stiffness = self.youngs_modulus * self.expansion * (self.wall - surface)
        coupling = dh_dp * self.length / self.conductivity * stiffness
        growth = barber_growth(biot, coupling) * self.rate
        return BarberState(pressure, surface, biot, coupling, growth)

    def steady_states(self) -> list[BarberState]:
        """All steady states, the one without contact (decay π²/4 κ/L²) first."""

        def excess(p: float) -> float:
            h = under_pressure(self.law, p)[0] * self.length / self.conductivity
            mean = 0.5 * self.wall * h / (1.0 + h)
            return self.start + self.youngs_modulus * self.expansion * mean - p

        highest = self.start + 0.5 * self.youngs_modulus * self.expansion * self.wall
        trial = highest * np.linspace(1e-9, 1.0, 2001)
        sign = np.sign([excess(p) for p in trial])
        changes = np.flatnonzero(sign[1:] != sign[:-1])
        closed = [brentq(excess, trial[i], trial[i + 1], xtol=1e-15 * highest) for i in changes]
        open_rod = BarberState(0.0, 0.0, 0.0, 0.0, -0.25 * math.pi**2 * self.rate)
        free = [open_rod] if self.start <= 0.0 else []
        return free + [self.state(float(p)) for p in closed]


@dataclass(frozen=True)
class IsothermalSplit:
    """Staggered steps with the thermoelastic heating term, one mode, backward Euler.

    Mechanics at the old temperature, then heat with the work of that step: the amplitude obeys
    (1 + D) z² - (1 - δ) z - δ = 0 from step to step.

    Attributes:
        coupling: δ = β² θ_0 / (ρc M), β = 3Kα, M = K + 4μ/3 [-].
        conduction: D = k κ² dt / (ρc), κ the wave number of the mode [-].
    """

    coupling: float
    conduction: float

    def amplification(self) -> float:
        """Largest |z|; the split is stable if it does not exceed 1."""
        roots = np.roots([1.0 + self.conduction, self.coupling - 1.0, -self.coupling])
        return float(np.abs(roots).max())

    def stable(self) -> bool:
        """Whether δ <= 1 + D/2, so that for δ > 1 it is the small steps that fail."""
        return self.coupling <= 1.0 + 0.5 * self.conduction
