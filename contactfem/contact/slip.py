"""Objective slip increment of a step (3)."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from contactfem.common.typing import Bools, Floats
from contactfem.mortar.sparse import Sparse, Triplets


@dataclass(frozen=True)
class Motion:
    """Motion of the nonmortar nodes against what they faced when the step began.

    Attributes:
        change: Entries of M - M⁰ [m].
        w: w_j = -[(D_jj - D⁰_jj) x_j - Σ_l (M_jl - M⁰_jl) x_l] [m²], (n, 2).
        seen: Where slip is defined: D⁰ > 0, (n,).
        slip: Objective slip increment s_j = τ_j·w_j / D⁰_jj [m], zero elsewhere, (n,).
    """

    change: Triplets
    w: Floats
    seen: Bools
    slip: Floats


def motion(
    x: Floats, tangent: Floats, M: sp.csr_matrix, before: tuple[Floats, sp.csr_matrix]
) -> Motion:
    """The motion to some positions.

    Computed with positions relative to x_j (Σ_l M_jl = D_jj), so that it does not see the origin.

    Args:
        x: Positions [m], (n_nodes, 2).
        tangent: Tangents τ of the nonmortar nodes there, (n, 2).
        M: M there [m], (n, n_nodes).
        before: D⁰, (n,), and M⁰ at the start of the step [m].
    """
    D0, M0 = before
    rows, columns, values = change = Sparse.of(M - M0).triplets()
    parts: Floats = (values[:, None] * (x[columns] - x[rows])).T
    w: Floats = np.column_stack([np.bincount(rows, part, len(D0)) for part in parts])
    along, seen = np.einsum("ji,ji->j", tangent, w), D0 > 0.0
    slip = np.divide(along, D0, out=np.zeros(len(along)), where=seen)
    return Motion(change, w, seen, slip)
