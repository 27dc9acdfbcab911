"""Basis of the multiplier on the covered part of facets in space."""

from dataclasses import dataclass

import numpy as np

from contactfem.common.typing import Bools, Floats
from contactfem.mortar.interface_mesh import Basis

SMALLEST = (
    1e-4  # eigenvalue of a scaled mass below which its basis is regularised; a whole facet has 0.1
)


@dataclass(frozen=True)
class FacetBasis:
    """Basis functions of the multiplier on some facets, Φ = A N.

    Attributes:
        A: Coefficients [-], (f, 4, 4); A = diag(d) B⁻¹ of dual functions, the unit matrix else.
        inverse: B⁻¹ [1/m²], (f, 4, 4).
        delta: δ of B = (1 - δ) m + δ diag(d) [-], (f,).
    """

    A: Floats
    inverse: Floats
    delta: Floats


def facet_basis(mass: Floats, triangle: Bools, kind: Basis) -> FacetBasis:
    """Basis on the covered part of facets, with m = ∫ N Nᵀ and d = ∫ N over it: ΣΦ = 1, ∫Φ = d.

    Dual functions are biorthogonal, δ = 0, but where the smallest eigenvalue ρ of
    diag(d)^-½ m diag(d)^-½ is below ρ0: there what is covered is a sliver, or lies within one of a
    quadrilateral's triangles, where two of its functions coincide. δ = ρ0 (1 - ρ/ρ0)² then keeps
    the sum of the functions and their integrals as they are.

    Args:
        mass: m [m²], shape (f, 4, 4), of facets that are covered.
        triangle: Which facets are triangles, (f,).
        kind: Dual or standard functions.

    Returns:
        The basis.
    """
    count = len(mass)
    if kind == "standard":
        return FacetBasis(
            np.tile(np.eye(4), (count, 1, 1)), np.zeros((count, 4, 4)), np.zeros(count)
        )
    d = mass.sum(axis=2)
    root = np.sqrt(np.where(d > 0.0, d, 1.0))
    scale = root[:, :, None] * root[:, None, :]
    unit = mass / scale
    unit[triangle, 3, 3] = 1.0
    smallest = np.linalg.eigvalsh(unit)[:, 0]
    delta = SMALLEST * np.clip(1.0 - smallest / SMALLEST, 0.0, 1.0) ** 2
    B = (1.0 - delta)[:, None, None] * unit + delta[:, None, None] * np.eye(4)
    inverse = np.linalg.inv(B) / scale
    inverse[triangle, 3, :] = inverse[triangle, :, 3] = 0.0
    return FacetBasis(d[:, :, None] * inverse, inverse, delta)
