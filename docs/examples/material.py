"""A material of one's own: the solid of Mooney and Rivlin, as one UFL function."""

from collections.abc import Mapping

import ufl
from ufl.core.expr import Expr


def mooney_rivlin(F: Expr, theta: Expr, parameters: Mapping[str, Expr]) -> Expr:
    """Free energy per reference volume, with heat expansion.

    ψ = c₁ (Ī₁ - 3) + c₂ (Ī₂ - 3) + K/2 (ln J - 3αϑ)², 2 (c₁ + c₂) = μ, c₂ = share (c₁ + c₂).

    Args:
        F: Deformation gradient [-], shape (3, 3), also in plane strain.
        theta: Relative temperature [K].
        parameters: "bulk_modulus", "shear_modulus" [Pa] and "expansion" [1/K] as the case gives
            them, and "share" [-] from its own parameters.

    Returns:
        ψ [J/m³].
    """
    K, mu = parameters["bulk_modulus"], parameters["shear_modulus"]
    J = ufl.det(F)
    C = J ** (-2 / 3) * F.T * F
    first, second = ufl.tr(C), (ufl.tr(C) ** 2 - ufl.tr(C * C)) / 2
    c2 = parameters["share"] * mu / 2
    c1 = mu / 2 - c2
    volume = ufl.ln(J) - 3 * parameters["expansion"] * theta
    return c1 * (first - 3) + c2 * (second - 3) + K / 2 * volume**2
