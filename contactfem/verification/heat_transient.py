"""Closed forms of transient heat conduction and friction.

Bodies are named as in an interface: nonmortar (nm) and mortar (m); the heat conducted through it is
h (θ_nm - θ_m), and the frictional power d enters nonmortar with the share f.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from contactfem.common.typing import Floats


@dataclass(frozen=True)
class EqualSlabs:
    """Two equal slabs with insulated ends that are joined at t = 0, at ±Δ/2 until then.

    By antisymmetry one slab loses 2h θ at its surface: θ = Δ/2 Σ C_m cos(β_m x/L) exp(-β_m² κt/L²),
    β tan β = 2hL/k, C = 4 sin β / (2β + sin 2β).

    Attributes:
        length: L of each slab [m].
        conductivity: k [W/m/K].
        heat_capacity: ρc [J/m³/K].
        conductance: h [W/m²/K].
        difference: Δ [K].
        terms: of the series; with fewer than L/sqrt(κt) it has not converged.
    """

    length: float
    conductivity: float
    heat_capacity: float
    conductance: float
    difference: float
    terms: int = 100

    def _series(self, t: float) -> tuple[Floats, Floats]:
        """Return β_m and the amplitudes Δ/2 C_m exp(-β_m² κt/L²)."""
        biot = 2.0 * self.conductance * self.length / self.conductivity

        def characteristic(beta: float) -> float:
            return beta * math.sin(beta) - biot * math.cos(beta)

        low = math.pi * np.arange(self.terms)
        beta = np.array([brentq(characteristic, a, a + 0.5 * math.pi, xtol=1e-14) for a in low])
        fourier = self.conductivity / self.heat_capacity * t / self.length**2
        amplitude = 4.0 * np.sin(beta) / (2.0 * beta + np.sin(2.0 * beta))
        return beta, 0.5 * self.difference * amplitude * np.exp(-(beta**2) * fourier)

    def theta(self, x: npt.ArrayLike, t: float) -> Floats:
        """Temperature of the warm slab; the cold one has its negative.

        Args:
            x: distance from the insulated end (n,), the interface is at L [m].
            t: time > 0 [s].

        Returns:
            θ (n,) [K].
        """
        beta, amplitude = self._series(t)
        x = np.atleast_1d(np.asarray(x, np.float64))
        found: Floats = np.cos(np.outer(x / self.length, beta)) @ amplitude
        return found

    def jump(self, t: float) -> float:
        """Difference of the surface temperatures at a time [s] in K."""
        return 2.0 * float(self.theta(self.length, t)[0])

    def mean(self, t: float) -> float:
        """Mean temperature of the warm slab at a time [s] in K."""
        beta, amplitude = self._series(t)
        return float(amplitude @ (np.sin(beta) / beta))


@dataclass(frozen=True)
class HalfSpace:
    """Half space, at a uniform temperature until t = 0.

    Attributes:
        conductivity: k [W/m/K].
        heat_capacity: ρc [J/m³/K].
        start: initial temperature [K].
    """

    conductivity: float
    heat_capacity: float
    start: float = 0.0

    @property
    def effusivity(self) -> float:
        """Thermal effusivity sqrt(k ρc) [W s^½/m²/K]."""
        return math.sqrt(self.conductivity * self.heat_capacity)

    def slowness(self, depth: npt.ArrayLike) -> Floats:
        """Return a = x / sqrt(κ) of points at a depth [m], in s^½."""
        return np.asarray(depth, np.float64) * math.sqrt(self.heat_capacity / self.conductivity)

    def heated(self, flux: float, depth: npt.ArrayLike, t: float) -> Floats:
        """Temperature under a constant flux into the surface.

        θ = θ_0 + q/e [2 sqrt(t/π) exp(-a²/4t) - a erfc(a/2√t)]; 2q/e sqrt(t/π) at the surface.

        Args:
            flux: q [W/m²].
            depth: below the surface (n,) [m].
            t: time > 0 [s].

        Returns:
            θ (n,) [K].
        """
        return self.start + flux / self.effusivity * _ramp(self.slowness(depth), t)


def _ramp(a: Floats, t: float) -> Floats:
    """Return the inverse Laplace transform of exp(-a√s) / s^(3/2)."""
    from scipy.special import erfc

    root = math.sqrt(t)
    decay = 2.0 * root / math.sqrt(math.pi) * np.exp(-(a**2) / (4.0 * t))
    found: Floats = decay - a * erfc(a / (2.0 * root))
    return found


def _relaxing(a: Floats, t: float, rate: float) -> Floats:
    """Return the inverse Laplace transform of exp(-a√s) / (s (√s + H)), H > 0."""
    from scipy.special import erfc, erfcx

    y = a / (2.0 * math.sqrt(t))
    found: Floats = (erfc(y) - np.exp(-(y**2)) * erfcx(y + rate * math.sqrt(t))) / rate
    return found


@dataclass(frozen=True)
class HalfSpaces:
    """Two half spaces that touch and rub from t = 0 on.

    With e = sqrt(k ρc), H = h (1/e_nm + 1/e_m), A = d (f/e_nm - (1 - f)/e_m) and
    w = exp(H²t) erfc(H√t) the jump is θ_nm - θ_m = Δ w + A/H (1 - w), Δ the initial one; the fluxes
    f d - h [θ] and (1 - f) d + h [θ] enter the bodies. For long times the source is shared in
    proportion to e.

    Attributes:
        nonmortar: body on the nonmortar side.
        mortar: body on the mortar side.
        conductance: h > 0 [W/m²/K].
        dissipation: d [W/m²].
        partition: f [-].
    """

    nonmortar: HalfSpace
    mortar: HalfSpace
    conductance: float
    dissipation: float = 0.0
    partition: float = 0.5

    @property
    def _shares(self) -> tuple[float, float]:
        return self.partition * self.dissipation, (1.0 - self.partition) * self.dissipation

    @property
    def _rate(self) -> float:
        """H [1/s^½]."""
        return self.conductance * (1.0 / self.nonmortar.effusivity + 1.0 / self.mortar.effusivity)

    @property
    def _drive(self) -> float:
        """A [K/s^½]."""
        own, other = self._shares
        return own / self.nonmortar.effusivity - other / self.mortar.effusivity

    def jump(self, t: float) -> float:
        """Difference of the surface temperatures at a time > 0 [s] in K."""
        from scipy.special import erfcx

        w = float(erfcx(self._rate * math.sqrt(t)))
        start = self.nonmortar.start - self.mortar.start
        return start * w + self._drive / self._rate * (1.0 - w)

    def fluxes(self, t: float) -> tuple[float, float]:
        """Heat that enters nonmortar and mortar at a time > 0 [s] in W/m²."""
        own, other = self._shares
        through = self.conductance * self.jump(t)
        return own - through, other + through

    def _conducted(self, body: HalfSpace, depth: npt.ArrayLike, t: float) -> Floats:
        """Return e θ due to the heat h [θ] conducted into a body."""
        a, H = body.slowness(depth), self._rate
        relaxing = _relaxing(a, t, H)
        start = self.nonmortar.start - self.mortar.start
        driven = self._drive * (_ramp(a, t) - relaxing) / H
        return np.asarray(self.conductance * (start * relaxing + driven), np.float64)

    def theta_nonmortar(self, depth: npt.ArrayLike, t: float) -> Floats:
        """Temperature of nonmortar at a depth (n,) [m] and a time > 0 [s] in K."""
        body = self.nonmortar
        lost = self._conducted(body, depth, t) / body.effusivity
        return np.asarray(body.heated(self._shares[0], depth, t) - lost)

    def theta_mortar(self, depth: npt.ArrayLike, t: float) -> Floats:
        """Temperature of mortar at a depth (n,) [m] and a time > 0 [s] in K."""
        body = self.mortar
        won = self._conducted(body, depth, t) / body.effusivity
        return np.asarray(body.heated(self._shares[1], depth, t) + won)


@dataclass(frozen=True)
class HeatedSlab:
    """Slab at 0, insulated at x = 0, with a constant flux into x = L from t = 0 on.

    θ = qt/(ρcL) + qL/k [(3x² - L²)/(6L²) - 2/π² Σ (-1)^m/m² exp(-m²π²κt/L²) cos(mπx/L)].

    Attributes:
        flux: q [W/m²].
        conductivity: k [W/m/K].
        heat_capacity: ρc [J/m³/K].
        length: L [m].
        terms: of the series; with fewer than L/sqrt(κt) it has not converged.
    """

    flux: float
    conductivity: float
    heat_capacity: float
    length: float
    terms: int = 400

    def theta(self, x: npt.ArrayLike, t: float) -> Floats:
        """Temperature at positions (n,) [m] and a time > 0 [s] in K."""
        y = np.atleast_1d(np.asarray(x, np.float64)) / self.length
        m = np.arange(1, self.terms + 1)
        fourier = self.conductivity / self.heat_capacity * t / self.length**2
        series = (-1.0) ** m / m**2 * np.exp(-((m * math.pi) ** 2) * fourier)
        shape = (3.0 * y**2 - 1.0) / 6.0 - 2.0 / math.pi**2 * np.cos(
            np.outer(y, m * math.pi)
        ) @ series
        found: Floats = self.flux * self.length / self.conductivity * (fourier + shape)
        return found
