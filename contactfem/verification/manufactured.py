"""Manufactured solutions of heat conduction and thermoelasticity, with the sources they need.

Points are arrays x (2 or 3, n) [m], as dolfinx hands them to functions; only x and y count.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from contactfem.common.typing import Floats

# Fields that are differentiated by a complex step are evaluated at complex points.
Numbers = npt.NDArray[Any]

STEP = 1e-100  # of complex differentiation, which has no round-off


@dataclass(frozen=True)
class FiniteStrain:
    """Thermoelastic solid on a square in plane strain, at finite strain.

    With X, Y over the side L: u = (a sin πX cos πY/2, b cos πX/2 sin πY) and
    θ = θ_0 sin πX sin πY exp(γt). The neo-Hooke law is P = J σ F^(-T),
    J σ = K (ln J - 3αθ) 1 + μ dev b̄, and Q = -k J F⁻¹F⁻ᵀ Grad θ; the sources are
    B_0 = -Div P and R_0 = ρ_0 c dθ/dt + Div Q.

    Attributes:
        bulk_modulus: K [Pa].
        shear_modulus: μ [Pa].
        expansion: linear thermal expansion α [1/K].
        conductivity: k [W/m/K].
        heat_capacity: ρ_0 c per undeformed volume [J/m³/K].
        amplitude: (a, b) [m].
        temperature: θ_0 [K].
        rate: γ [1/s]; 0 is a steady temperature.
        side: L [m].
    """

    bulk_modulus: float
    shear_modulus: float
    expansion: float
    conductivity: float
    heat_capacity: float
    amplitude: tuple[float, float]
    temperature: float
    rate: float = 0.0
    side: float = 1.0

    def _angles(self, x: Numbers) -> tuple[Numbers, Numbers]:
        return math.pi / self.side * x[0], math.pi / self.side * x[1]

    def _gradients(self, x: Numbers, t: float) -> tuple[Numbers, Numbers, Numbers]:
        """Return F (2, 2, n), θ (n,) and Grad θ (2, n)."""
        a, b = (math.pi / self.side * amplitude for amplitude in self.amplitude)
        X, Y = self._angles(x)
        F = np.array(
            [
                [
                    1.0 + a * np.cos(X) * np.cos(0.5 * Y),
                    -0.5 * a * np.sin(X) * np.sin(0.5 * Y),
                ],
                [
                    -0.5 * b * np.sin(0.5 * X) * np.sin(Y),
                    1.0 + b * np.cos(0.5 * X) * np.cos(Y),
                ],
            ]
        )
        hot = self.temperature * math.exp(self.rate * t)
        steep = hot * math.pi / self.side
        grad = steep * np.array([np.cos(X) * np.sin(Y), np.sin(X) * np.cos(Y)])
        return F, hot * np.sin(X) * np.sin(Y), grad

    def _fluxes(self, x: Numbers, t: float) -> tuple[Numbers, Numbers]:
        """Return P (2, 2, n) and Q (2, n)."""
        F, theta, grad = self._gradients(x, t)
        J = F[0, 0] * F[1, 1] - F[0, 1] * F[1, 0]
        inverse = np.array([[F[1, 1], -F[0, 1]], [-F[1, 0], F[0, 0]]]) / J
        bbar = J ** (-2.0 / 3.0) * np.einsum("ikn,jkn->ijn", F, F)
        mean = (bbar[0, 0] + bbar[1, 1] + J ** (-2.0 / 3.0)) / 3.0  # plane strain: F33 = 1
        volumetric = self.bulk_modulus * (np.log(J) - 3.0 * self.expansion * theta)
        spherical = (volumetric - self.shear_modulus * mean) * np.eye(2)[:, :, None]
        P = np.einsum("ikn,jkn->ijn", spherical + self.shear_modulus * bbar, inverse)
        pulled = np.einsum("ikn,jkn->ijn", inverse, inverse)
        return P, -self.conductivity * J * np.einsum("ijn,jn->in", pulled, grad)

    def _divergences(self, x: Floats, t: float) -> tuple[Floats, Floats]:
        """Return Div P (2, n) and Div Q (n,), exact to round-off by complex steps."""
        force, heat = np.zeros((2, x.shape[1])), np.zeros(x.shape[1])
        for j in range(2):
            moved = x[:2].astype(complex)
            moved[j] += 1j * STEP * self.side
            P, Q = self._fluxes(moved, t)
            force += P[:, j].imag / (STEP * self.side)
            heat += Q[j].imag / (STEP * self.side)
        return force, heat

    def displacement(self, x: Floats) -> Floats:
        """Displacement u (2, n) [m]."""
        a, b = self.amplitude
        X, Y = self._angles(x)
        return np.array([a * np.sin(X) * np.cos(0.5 * Y), b * np.cos(0.5 * X) * np.sin(Y)])

    def theta(self, x: Floats, t: float = 0.0) -> Floats:
        """Temperature θ (n,) at a time [s], in K."""
        return np.asarray(self._gradients(x, t)[1])

    def deformation_gradient(self, x: Floats) -> Floats:
        """Deformation gradient F (2, 2, n) in the plane [-]."""
        return np.asarray(self._gradients(x, 0.0)[0])

    def temperature_gradient(self, x: Floats, t: float = 0.0) -> Floats:
        """Material gradient Grad θ (2, n) at a time [s], in K/m."""
        return np.asarray(self._gradients(x, t)[2])

    def stress(self, x: Floats, t: float = 0.0) -> Floats:
        """First Piola-Kirchhoff stress P (2, 2, n) at a time [s], in Pa."""
        return np.asarray(self._fluxes(x, t)[0])

    def heat_flux(self, x: Floats, t: float = 0.0) -> Floats:
        """Heat flux Q (2, n) per undeformed area at a time [s], in W/m²."""
        return np.asarray(self._fluxes(x, t)[1])

    def body_force(self, x: Floats, t: float = 0.0) -> Floats:
        """Body force B_0 (2, n) per undeformed volume at a time [s], in N/m³."""
        return -self._divergences(x, t)[0]

    def heat_source(self, x: Floats, t: float = 0.0) -> Floats:
        """Heat source R_0 (n,) per undeformed volume at a time [s], in W/m³."""
        stored = self.heat_capacity * self.rate * self.theta(x, t)
        return np.asarray(stored + self._divergences(x, t)[1])


@dataclass(frozen=True)
class MovingGaussian:
    """Hot spot that goes round in a circle, θ = A exp(-|x - x_0(t)|²/w²).

    Attributes:
        conductivity: k [W/m/K].
        heat_capacity: ρc [J/m³/K].
        height: A [K].
        width: w [m].
        radius: of the circle [m].
        center: of the circle [m].
        speed: of rotation, from the x-axis at t = 0 [rad/s].
    """

    conductivity: float
    heat_capacity: float
    height: float = 100.0
    width: float = 0.1
    radius: float = 0.25
    center: tuple[float, float] = (0.5, 0.5)
    speed: float = 2.0 * math.pi

    def spot(self, t: float) -> Floats:
        """Middle of the spot x_0 (2,) at a time [s], in m."""
        angle = self.speed * t
        return np.array(self.center) + self.radius * np.array([math.cos(angle), math.sin(angle)])

    def _distance(self, x: Floats, t: float) -> Floats:
        return np.asarray((x[:2] - self.spot(t)[:, None]) / self.width)

    def theta(self, x: Floats, t: float) -> Floats:
        """Temperature θ (n,) [K]."""
        return np.asarray(self.height * np.exp(-np.sum(self._distance(x, t) ** 2, axis=0)))

    def gradient(self, x: Floats, t: float) -> Floats:
        """Gradient of θ (2, n) [K/m]."""
        return -2.0 / self.width * self._distance(x, t) * self.theta(x, t)

    def source(self, x: Floats, t: float) -> Floats:
        """Heat source ρc dθ/dt - k Δθ (n,) [W/m³]."""
        angle = self.speed * t
        velocity = self.speed * self.radius * np.array([-math.sin(angle), math.cos(angle)])
        rate = -velocity @ self.gradient(x, t)
        squared = np.sum(self._distance(x, t) ** 2, axis=0)
        laplacian = 4.0 / self.width**2 * (squared - 1.0) * self.theta(x, t)
        return np.asarray(self.heat_capacity * rate - self.conductivity * laplacian)


@dataclass(frozen=True)
class SuddenSwitch:
    """Temperature that changes its sign within a short time, θ = A sin πX sin πY tanh((t - t_0)/τ).

    X, Y over the side of the square.

    Attributes:
        conductivity: k [W/m/K].
        heat_capacity: ρc [J/m³/K].
        height: A [K].
        instant: t_0 [s].
        duration: τ [s].
        side: of the square [m].
    """

    conductivity: float
    heat_capacity: float
    height: float = 1.0
    instant: float = 0.5
    duration: float = 0.02
    side: float = 1.0

    def _shape(self, x: Floats) -> Floats:
        X, Y = math.pi / self.side * x[0], math.pi / self.side * x[1]
        return np.asarray(self.height * np.sin(X) * np.sin(Y))

    def _switch(self, t: float) -> float:
        return math.tanh((t - self.instant) / self.duration)

    def theta(self, x: Floats, t: float) -> Floats:
        """Temperature θ (n,) [K]."""
        return self._shape(x) * self._switch(t)

    def gradient(self, x: Floats, t: float) -> Floats:
        """Gradient of θ (2, n) [K/m]."""
        X, Y = math.pi / self.side * x[0], math.pi / self.side * x[1]
        steep = self.height * math.pi / self.side * self._switch(t)
        return steep * np.array([np.cos(X) * np.sin(Y), np.sin(X) * np.cos(Y)])

    def source(self, x: Floats, t: float) -> Floats:
        """Heat source ρc dθ/dt - k Δθ (n,) [W/m³]."""
        switch = self._switch(t)
        stored = self.heat_capacity * (1.0 - switch**2) / self.duration
        spread = self.conductivity * 2.0 * (math.pi / self.side) ** 2 * switch
        return self._shape(x) * (stored + spread)


@dataclass(frozen=True)
class HarmonicBody:
    """Body of `harmonic_bodies`, θ = A cos κx exp(-κ|y|).

    Attributes:
        conductivity: k [W/m/K].
        amplitude: A [K].
        wave_number: κ [1/m].
        below: whether it lies below the interface at y = 0.
    """

    conductivity: float
    amplitude: float
    wave_number: float
    below: bool

    @property
    def _decay(self) -> float:
        """∂(ln θ)/∂y."""
        return self.wave_number if self.below else -self.wave_number

    def theta(self, x: Floats) -> Floats:
        """Temperature θ (n,) [K]."""
        across = self.amplitude * np.cos(self.wave_number * x[0])
        return np.asarray(across * np.exp(self._decay * x[1]))

    def flux(self, x: Floats) -> Floats:
        """Heat flux q = -k grad θ (2, n) [W/m²]."""
        down = self.conductivity * self.amplitude * np.exp(self._decay * x[1])
        along = self.wave_number * np.sin(self.wave_number * x[0])
        return np.array([down * along, -down * self._decay * np.cos(self.wave_number * x[0])])


def harmonic_bodies(
    conductivities: tuple[float, float],
    conductance: float,
    dissipation: float,
    partition: float = 0.5,
    wave_number: float = math.pi,
) -> tuple[HarmonicBody, HarmonicBody]:
    """Steady temperatures of two bodies that meet at y = 0, where a source d_0 cos κx heats them.

    q_y = h (θ_1 - θ_2) - f d in the body below and h (θ_1 - θ_2) + (1 - f) d above; neither has a
    source inside. Δ = A_1 - A_2 obeys Δ (κ + h Σ 1/k) = d_0 (f/k_1 - (1 - f)/k_2).

    Args:
        conductivities: k_1 below and k_2 above [W/m/K].
        conductance: h [W/m²/K].
        dissipation: d_0 [W/m²].
        partition: f, share of the body below [-].
        wave_number: κ [1/m].

    Returns:
        The body below and the body above.
    """
    k1, k2 = conductivities
    own, other = partition * dissipation, (1.0 - partition) * dissipation
    jump = (own / k1 - other / k2) / (wave_number + conductance * (1.0 / k1 + 1.0 / k2))
    through = conductance * jump
    return (
        HarmonicBody(k1, (own - through) / (k1 * wave_number), wave_number, below=True),
        HarmonicBody(k2, (other + through) / (k2 * wave_number), wave_number, below=False),
    )
