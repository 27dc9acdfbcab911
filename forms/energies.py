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
    K, mu, alpha = (parameters[k] for k in ("bulk_modulus", "shear_modulus", "expansion"))
    J = ufl.det(F)
    ln_Je = ufl.ln(J) - ufl.ln(thermal_volume_ratio(theta, alpha))
    return K / 2 * ln_Je**2 + mu / 2 * (J ** (-2.0 / 3.0) * ufl.tr(F.T * F) - 3)


def linear_elastic(F: Expr, theta: Expr, parameters: Parameters) -> Expr:
    """Small-strain limit of `neo_hooke`, ψ = K/2 (tr ε - 3αϑ)² + μ dev ε : dev ε.

    Args:
        F: Deformation gradient [-], shape (3, 3); ε is the symmetric part of F - 1.
        theta: Relative temperature [K].
        parameters: "bulk_modulus", "shear_modulus" [Pa], "expansion" [1/K].

    Returns:
        ψ [J/m³].
    """
    K, mu, alpha = (parameters[k] for k in ("bulk_modulus", "shear_modulus", "expansion"))
    strain = ufl.sym(F - ufl.Identity(3))
    deviator = ufl.dev(strain)
    return K / 2 * (ufl.tr(strain) - 3 * alpha * theta) ** 2 + mu * ufl.inner(deviator, deviator)
