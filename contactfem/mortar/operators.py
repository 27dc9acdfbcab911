"""Mortar operators D, M and weighted gap (2), (7)-(11)."""

from dataclasses import dataclass

import numpy as np

from contactfem.common.typing import Bools, Floats, Ints
from contactfem.mortar.interface_mesh import Basis, InterfaceMesh
from contactfem.mortar.normals import NormalField
from contactfem.mortar.segments import Segments, entries
from contactfem.mortar.sparse import Sparse

TINY_COVER = 1e-14  # covered share of a facet below which it counts as uncovered (round-off)
FULL = (1.0 / 3.0, 1.0 / 6.0, 1.0 / 3.0)  # ∫ N N of a whole facet, stands in for an uncovered one
D_ENTRY, GAP_ENTRY = -1, -2  # as in the kernel


@dataclass(frozen=True)
class Mortar:
    """Operators of one interface as a list of entries; repeated entries add up.

    D_jj = ∫ Φ_j N_j, M_jl = ∫ Φ_j (N_l∘P), g_j = ∫ w_j g. In M also stand, with the sign of a
    mortar entry, the nonmortar nodes without multiplier (modified basis): always Σ_l M_jl = D_jj.

    The gap is weighted with w_j = (Φ_j + N_j) / 2, ∫ w_j = D_jj. A gap g + κ s²/2 around a node is
    seen as g + κ/2 times the second moment of the weight, which is -h²/6 for Φ_j, h²/6 for N_j and
    zero for their mean: with Φ_j alone, negative on the far third of a facet, a gap that opens
    convexly (a corner, a round body above coarse facets) counts as penetration. Beside a node
    without multiplier w_j = N_j.

    Standard multipliers have Φ_j = N_j and a mass matrix ∫ Φ_j N_k that is not diagonal. D_jj is
    then its row sum ∫ Φ_j, and what remains, D_jj δ_jk - ∫ Φ_j N_k, stands in M: the nodal forces
    D_jj λ_j - Σ_l M_jl λ_j and the slip w_j are the unlumped ones. D_jj only makes a mean gap and
    a mean slip of the weighted ones, which the conditions p_j g_j = 0 and t_j s_j >= 0 at nodes
    belong to: they are the exact ones of multipliers with p_j >= 0 and |t_j| <= μ p_j.

    Attributes:
        row: Nonmortar node j of every entry, shape (e,).
        col: Node l of the entries of M, D_ENTRY for those of D, GAP_ENTRY for those of g, (e,).
        value: Entries [m] (of g: [m²]), shape (e,).
        derivative: Of the entries with respect to the positions of all nodes, (e, 2 n_nodes); None
            where not asked for.
    """

    row: Ints
    col: Ints
    value: Floats
    derivative: Sparse | None


def assemble(mesh: InterfaceMesh, x: Floats, segments: Segments, normals: NormalField) -> Mortar:
    """Mortar operators (2), (7)-(11), with the multiplier's basis on the covered part of facets.

    On a facet Φ = A N, A = diag(d) m⁻¹ with m = ∫ N Nᵀ and d = ∫ N over its covered part for dual
    multipliers, A = 1 for standard ones; where the other node of the facet carries no multiplier
    Φ_k = 1 instead.

    Args:
        mesh: The interface.
        x: Current positions [m], shape (n_nodes, 2).
        segments: All segments of some nonmortar facets.
        normals: Normal field that the segments were cut with.

    Returns:
        The operators' entries, with derivatives where the segments have them.
    """
    facets, e = np.unique(segments.facets[:, 0], return_inverse=True)
    m = np.column_stack([np.bincount(e, part, len(facets)) for part in segments.integrals[:, :3].T])
    ends = mesh.nonmortar[facets]
    edge = x[ends[:, 1]] - x[ends[:, 0]]
    whole = np.hypot(edge[:, 0], edge[:, 1])
    if mesh.axisymmetric:
        whole = whole * np.pi * x[ends, 0].sum(1)
    covered = m @ (1.0, 2.0, 1.0) > TINY_COVER * whole
    A, dA = basis(np.where(covered[:, None], m, FULL), mesh.has_multiplier[ends], mesh.basis)
    return Mortar(*entries(mesh, segments, normals, (e, covered, A, dA)))


def basis(m: Floats, has_multiplier: Bools, kind: Basis) -> tuple[Floats, Floats | None]:
    """Basis of the multiplier on facets, Φ = A N.

    Args:
        m: ∫ N1N1, N1N2, N2N2 over the covered part of each facet [m], shape (f, 3).
        has_multiplier: Whether the two nodes of each facet carry a multiplier, shape (f, 2).
        kind: Dual or standard functions.

    Returns:
        A [-], shape (f, 2, 2), and its derivative by m [1/m], shape (f, 2, 2, 3); None where A does
        not depend on m.
    """
    if kind == "dual":
        return _dual_basis(m, has_multiplier)
    A = np.tile(np.eye(2), (len(m), 1, 1))
    A[~has_multiplier[:, ::-1]] = 1.0
    return A, None


def _dual_basis(m: Floats, has_multiplier: Bools) -> tuple[Floats, Floats]:
    """A = diag(d) m⁻¹ (f, 2, 2) and its derivative by (m11, m12, m22), (f, 2, 2, 3)."""
    m11, m12, m22 = m.T
    d1, d2, zero = m11 + m12, m12 + m22, np.zeros(len(m))
    det = m11 * m22 - m12**2
    A = _stack(((d1 * m22, -d1 * m12), (-d2 * m12, d2 * m11))) / det[:, None, None]
    d_numerator = _stack(
        (
            ((m22, m22, d1), (-m12, -m12 - d1, zero)),
            ((zero, -m12 - d2, -m12), (d2, m11, m11)),
        )
    )
    d_det = np.stack((m22, -2 * m12, m11), 1)
    dA = (d_numerator - A[..., None] * d_det[:, None, None, :]) / det[:, None, None, None]
    alone = ~has_multiplier[:, ::-1]  # the other node of the facet has no multiplier
    A[alone] = 1.0
    dA[alone] = 0.0
    return A, dA


def _stack(rows: tuple[object, ...]) -> Floats:
    """Nested tuples of (f,) arrays as one array with f first."""
    return np.moveaxis(np.array(rows), -1, 0)
