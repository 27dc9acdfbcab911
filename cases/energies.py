"""Free energies of the literature that cases use in place of the built-in ones."""

from collections.abc import Mapping

import ufl
from ufl.core.expr import Expr


def simo(F: Expr, theta: Expr, parameters: Mapping[str, Expr]) -> Expr:
    """Compressible neo-Hooke solid, ψ = μ/2 (tr FᵀF - 3 - 2 ln J) + λ/2 (ln J)², λ = K - 2μ/3.

    The volume changes the deviatoric part too; under strong compression it is softer than the
    split into volume and shape. Without thermal expansion.

    Args:
        F: Deformation gradient [-], shape (3, 3).
        theta: Relative temperature [K], without effect.
        parameters: "bulk_modulus", "shear_modulus" [Pa].

    Returns:
        ψ [J/m³].

    References:
        J. C. Simo, K. S. Pister, Comput. Methods Appl. Mech. Engrg. 46 (1984) 201-215.
    """
    K, mu = parameters["bulk_modulus"], parameters["shear_modulus"]
    ln_J = ufl.ln(ufl.det(F))
    return mu / 2 * (ufl.tr(F.T * F) - 3 - 2 * ln_J) + (K / 2 - mu / 3) * ln_J**2
