"""Homogeneous states of the thermoelastic Neo-Hooke solid.

The Cauchy stress is σ = [K (ln J - 3αϑ) 1 + μ dev b̄] / J with b̄ = J^(-2/3) F Fᵀ.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from contactfem.common.typing import Floats

EPSILON, TINY = float(np.finfo(float).eps), float(np.finfo(float).tiny)


def bulk_and_shear_modulus(youngs_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    """Bulk and shear modulus, K = E / 3(1 - 2ν) and μ = E / 2(1 + ν).

    Args:
        youngs_modulus: E [Pa].
        poisson_ratio: ν [-].

    Returns:
        K and μ [Pa].
    """
    bulk = youngs_modulus / (3.0 * (1.0 - 2.0 * poisson_ratio))
    return bulk, youngs_modulus / (2.0 * (1.0 + poisson_ratio))


def youngs_modulus_and_poisson_ratio(
    bulk_modulus: float, shear_modulus: float
) -> tuple[float, float]:
    """Young's modulus and Poisson ratio, E = 9Kμ/(3K + μ), ν = (3K - 2μ)/(6K + 2μ).

    Args:
        bulk_modulus: K [Pa].
        shear_modulus: μ [Pa].

    Returns:
        E [Pa] and ν [-].
    """
    both = 3.0 * bulk_modulus + shear_modulus
    poisson = (3.0 * bulk_modulus - 2.0 * shear_modulus) / (2.0 * both)
    return 9.0 * bulk_modulus * shear_modulus / both, poisson


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return a zero between two points of opposite sign, to the last digits."""
    from scipy.optimize import brentq

    return float(brentq(function, low, high, xtol=TINY, rtol=4.0 * EPSILON))


@dataclass(frozen=True)
class NeoHooke:
    """Neo-Hooke solid at a uniform temperature.

    Attributes:
        bulk_modulus: K [Pa].
        shear_modulus: μ [Pa].
        expansion: linear thermal expansion α [1/K].
        temperature: ϑ over the stress-free state [K].
    """

    bulk_modulus: float
    shear_modulus: float
    expansion: float = 0.0
    temperature: float = 0.0

    def cauchy_stress(self, deformation_gradient: npt.ArrayLike) -> Floats:
        """Cauchy stress at a deformation gradient.

        Args:
            deformation_gradient: F (3, 3) [-].

        Returns:
            σ (3, 3) [Pa].
        """
        F = np.asarray(deformation_gradient, dtype=np.float64)
        J = float(np.linalg.det(F))
        bbar = J ** (-2.0 / 3.0) * F @ F.T
        volumetric = self.bulk_modulus * (math.log(J) - 3.0 * self.expansion * self.temperature)
        deviator = bbar - np.trace(bbar) / 3.0 * np.eye(3)
        stress: Floats = (volumetric * np.eye(3) + self.shear_modulus * deviator) / J
        return stress

    def principal_stresses(self, *stretches: float) -> Floats:
        """Principal Cauchy stresses at three principal stretches.

        Args:
            stretches: λ₁, λ₂, λ₃ [-].

        Returns:
            σ₁, σ₂, σ₃ (3,) [Pa].
        """
        return np.diag(self.cauchy_stress(np.diag(stretches))).copy()

    def uniaxial_strain(self, stretch: float) -> tuple[float, float]:
        """Laterally confined bar, F = diag(λ, 1, 1).

        Args:
            stretch: λ [-].

        Returns:
            Axial and lateral Cauchy stress [Pa].
        """
        axial, lateral, _ = self.principal_stresses(stretch, 1.0, 1.0)
        return float(axial), float(lateral)

    def uniaxial_stress(self, stretch: float) -> tuple[float, float, float]:
        """Bar with free sides in three dimensions, F = diag(λ, λ_t, λ_t).

        Args:
            stretch: axial λ [-].

        Returns:
            λ_t [-], axial Cauchy stress σ and nominal stress σ λ_t² [Pa].
        """
        lateral = _root(lambda a: self.principal_stresses(stretch, a, a)[1], 0.05, 20.0)
        axial = float(self.principal_stresses(stretch, lateral, lateral)[0])
        return lateral, axial, axial * lateral**2

    def plane_strain_block(self, stretch: float) -> tuple[float, float, float]:
        """Block with free sides in plane strain, F = diag(λ, λ₂, 1).

        Args:
            stretch: axial λ [-].

        Returns:
            λ₂ [-], Cauchy stress σ along the axis and σ₃ out of the plane [Pa]; the
            nominal axial stress is σ λ₂.
        """
        lateral = _root(lambda a: self.principal_stresses(stretch, a, 1.0)[1], 0.05, 20.0)
        axial, _, out = self.principal_stresses(stretch, lateral, 1.0)
        return lateral, float(axial), float(out)

    def plane_strain_dead_load(self, nominal_stress: float) -> tuple[float, float, float]:
        """Block with free sides in plane strain under a nominal axial stress.

        Args:
            nominal_stress: axial force per undeformed area, tension > 0 [Pa].

        Returns:
            Axial and lateral stretch [-], axial Cauchy stress [Pa].
        """

        def excess(stretch: float) -> float:
            lateral, axial, _ = self.plane_strain_block(stretch)
            return axial * lateral - nominal_stress

        stretch = _root(excess, 0.1, 5.0)
        lateral, axial, _ = self.plane_strain_block(stretch)
        return stretch, lateral, axial

    def free_stretch(self) -> float:
        """Stretch of the unloaded body, exp(αϑ) [-]."""
        return math.exp(self.expansion * self.temperature)


@dataclass(frozen=True)
class ConfinedStack:
    """State of two stacked blocks between smooth walls.

    Attributes:
        pressure: contact pressure [Pa].
        stretch_lower: axial stretch of the lower block, its volume ratio [-].
        stretch_upper: the same of the upper block [-].
        lateral_lower: lateral Cauchy stress of the lower block [Pa].
        lateral_upper: the same of the upper block [Pa].
    """

    pressure: float
    stretch_lower: float
    stretch_upper: float
    lateral_lower: float
    lateral_upper: float


def confined_stack(
    lower: NeoHooke, upper: NeoHooke, height_lower: float, height_upper: float, top: float
) -> ConfinedStack:
    """Two laterally confined blocks, one on the other, whose top is moved.

    The stretches solve λ₁H₁ + λ₂H₂ = H₁ + H₂ + u and σ(λ₁) = σ(λ₂).

    Args:
        lower: solid of the lower block.
        upper: solid of the upper block.
        height_lower: H₁ [m].
        height_upper: H₂ [m].
        top: displacement u of the top, down < 0 [m].

    Returns:
        The homogeneous state of both blocks.

    Raises:
        ValueError: if no state in compression or moderate tension fits.
    """
    total = height_lower + height_upper + top

    def upper_stretch(stretch: float) -> float:
        return (total - stretch * height_lower) / height_upper

    def jump(stretch: float) -> float:
        other = upper.uniaxial_strain(upper_stretch(stretch))[0]
        return lower.uniaxial_strain(stretch)[0] - other

    low = max(0.02, (total - 2.0 * height_upper) / height_lower)
    high = min(2.0, (total - 0.02 * height_upper) / height_lower)
    stretch = _root(jump, low, high)
    stress, lateral = lower.uniaxial_strain(stretch)
    return ConfinedStack(
        pressure=-stress,
        stretch_lower=stretch,
        stretch_upper=upper_stretch(stretch),
        lateral_lower=lateral,
        lateral_upper=upper.uniaxial_strain(upper_stretch(stretch))[1],
    )
