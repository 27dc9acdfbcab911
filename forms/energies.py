"""Free energies per reference volume; stress and tangent follow by differentiation.

A user's own law is a function with the signature of `neo_hooke`.
"""

from collections.abc import Mapping

import ufl
from ufl.core.expr import Expr

from contactfem.forms.kinematics import thermal_volume_ratio

Parameters = Mapping[str, Expr]


def neo_hooke(F: Expr, theta: Expr, parameters: Parameters) -> Expr:
    """Compressible thermoelastic Neo-Hooke solid, ψ = K/2 (ln J_e)² + μ/2 (J^(-2/3) tr FᵀF - 3).

    J = J_e J_θ; the Cauchy stress is σ = (K/J) ln J_e 1 + (μ/J) dev b̄ (14).

    Args:
        F: Deformation gradient [-], shape (3, 3).
        theta: Relative temperature [K].
        parameters: "bulk_modulus", "shear_modulus" [Pa], "expansion" [1/K].

    Returns:
        ψ [J/m³].
    """
    return parameters["bulk_modulus"] / 2 * _ln_Je(F, theta, parameters) ** 2 + _distortion(
        F, parameters
    )


def linear_elastic(F: Expr, theta: Expr, parameters: Parameters) -> Expr:
    """Small-strain limit of `neo_hooke`, ψ = K/2 (tr ε - 3αϑ)² + μ dev ε : dev ε.

    Args:
        F: Deformation gradient [-], shape (3, 3); ε is the symmetric part of F - 1.
        theta: Relative temperature [K].
        parameters: "bulk_modulus", "shear_modulus" [Pa], "expansion" [1/K].

    Returns:
        ψ [J/m³].
    """
    return parameters["bulk_modulus"] / 2 * _dilation(
        F, theta, parameters
    ) ** 2 + _small_distortion(F, parameters)


def neo_hooke_mixed(F: Expr, p: Expr, theta: Expr, parameters: Parameters) -> Expr:
    """`neo_hooke` with mean stress as a field, ψ = p ln J_e - p²/2K + μ/2 (J^(-2/3) tr FᵀF - 3).

    Stationary in p where p = K ln J_e; it is `neo_hooke` there. Bounded as K grows.

    Args:
        F: Deformation gradient [-], shape (3, 3).
        p: Mean Kirchhoff stress, positive in tension [Pa].
        theta: Relative temperature [K].
        parameters: "bulk_modulus", "shear_modulus" [Pa], "expansion" [1/K].

    Returns:
        ψ [J/m³].
    """
    ln_Je, K = _ln_Je(F, theta, parameters), parameters["bulk_modulus"]
    return p * ln_Je - p**2 / (2 * K) + _distortion(F, parameters)


def linear_elastic_mixed(F: Expr, p: Expr, theta: Expr, parameters: Parameters) -> Expr:
    """`linear_elastic` with the mean stress as a field, p (tr ε - 3αϑ) - p²/2K + μ dev ε : dev ε.

    Args:
        F: Deformation gradient [-], shape (3, 3); ε is the symmetric part of F - 1.
        p: Mean stress, positive in tension [Pa].
        theta: Relative temperature [K].
        parameters: "bulk_modulus", "shear_modulus" [Pa], "expansion" [1/K].

    Returns:
        ψ [J/m³].
    """
    dilation, K = _dilation(F, theta, parameters), parameters["bulk_modulus"]
    return p * dilation - p**2 / (2 * K) + _small_distortion(F, parameters)


def _ln_Je(F: Expr, theta: Expr, parameters: Parameters) -> Expr:
    """Logarithm of the elastic volume ratio, ln J - ln J_θ."""
    thermal = thermal_volume_ratio(theta, parameters["expansion"])
    return ufl.ln(ufl.det(F)) - ufl.ln(thermal)


def _distortion(F: Expr, parameters: Parameters) -> Expr:
    """Energy of the change of shape, μ/2 (J^(-2/3) tr FᵀF - 3)."""
    shape = ufl.det(F) ** (-2.0 / 3.0) * ufl.tr(F.T * F)
    return parameters["shear_modulus"] / 2 * (shape - 3)


def _dilation(F: Expr, theta: Expr, parameters: Parameters) -> Expr:
    """Elastic change of volume at small strain, tr ε - 3αϑ."""
    return ufl.tr(F - ufl.Identity(3)) - 3 * parameters["expansion"] * theta


def _small_distortion(F: Expr, parameters: Parameters) -> Expr:
    """Energy of the change of shape at small strain, μ dev ε : dev ε."""
    deviator = ufl.dev(ufl.sym(F - ufl.Identity(3)))
    return parameters["shear_modulus"] * ufl.inner(deviator, deviator)
