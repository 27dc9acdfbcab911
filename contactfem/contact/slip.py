"""Slip: objective relative motion of the two sides in a step (3)."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from contactfem.common.typing import Bools, Floats
from contactfem.mortar.sparse import Sparse

OPPOSITE = 1e-12  # sum of two unit normals below which no shortest turn leads from one to the other


@dataclass(frozen=True)
class Motion:
    """Motion of the nonmortar nodes against what they faced when the step began.

    Attributes:
        w: w_j = Σ_l (M_jl - M⁰_jl) (x_l - x_j), area times relative motion, (n, dim).
        known: Where slip is defined: D⁰ > 0, (n,).
        slip: Objective slip increment s_j = (1 - n_j n_jᵀ) w_j / D⁰_jj [m], zero where it is not
            defined, (n, dim).
    """

    w: Floats
    known: Bools
    slip: Floats


def relative_motion(
    x: Floats, normals: Floats, M: sp.csr_matrix, before: tuple[Floats, sp.csr_matrix]
) -> Motion:
    """The motion to some positions.

    Computed with positions relative to x_j (Σ_l M_jl = D_jj), so that it does not see the origin.

    Args:
        x: Positions [m], (n_nodes, dim).
        normals: Unit normals of the nonmortar nodes there, (n, dim).
        M: M there, (n, n_nodes).
        before: D⁰, (n,), and M⁰ at the start of the step.
    """
    D0, M0 = before
    rows, columns, values = Sparse.of(M - M0).triplets()
    parts: Floats = (values[:, None] * (x[columns] - x[rows])).T
    w: Floats = np.column_stack([np.bincount(rows, part, len(D0)) for part in parts])
    known = D0 > 0.0
    along = tangential(w, normals)
    slip = np.where(known[:, None], along, 0.0) / np.where(known, D0, 1.0)[:, None]
    return Motion(w, known, slip)


def tangential(vectors: Floats, normals: Floats) -> Floats:
    """Parts of vectors in the tangent planes, (1 - n nᵀ) a.

    Args:
        vectors: a, (n, dim).
        normals: Unit normals n, (n, dim).
    """
    across = np.einsum("ji,ji->j", vectors, normals)
    return np.asarray(vectors - across[:, None] * normals)


def transported(vectors: Floats, before: Floats, after: Floats) -> Floats:
    """Tangential vectors carried along by planes that turn the shortest way.

    a - (a·n₂) / (1 + n₁·n₂) (n₁ + n₂): the length of a vector and, in two dimensions, its sign
    along the surface stay what they are.

    Args:
        vectors: a, tangential to the planes before, (n, dim).
        before: Unit normals n₁, (n, dim).
        after: Unit normals n₂, (n, dim).
    """
    return np.asarray(np.einsum("jik,jk->ji", transports(before, after), vectors))


def transports(before: Floats, after: Floats) -> Floats:
    """The turns of `transported` as matrices that act on tangential vectors, (n, dim, dim)."""
    both = before + after
    cosine = 1.0 + np.einsum("ji,ji->j", before, after)
    share = np.divide(1.0, cosine, out=np.zeros_like(cosine), where=cosine > OPPOSITE)
    across = np.einsum("j,ji,jk->jik", share, both, after)
    return np.asarray(np.eye(before.shape[1]) - across)


def interpolated(matrix: sp.csr_matrix, vectors: Floats, before: Floats, after: Floats) -> Floats:
    """Tangential vectors interpolated from other nodes, each turned into the plane where it goes.

    Args:
        matrix: Interpolation, (m, n).
        vectors: At the other nodes, (n, dim).
        before: Unit normals there, (n, dim).
        after: Unit normals where they go, (m, dim).

    Returns:
        The vectors, (m, dim).
    """
    rows, columns, values = Sparse.of(sp.csr_matrix(matrix)).triplets()
    moved = values[:, None] * transported(vectors[columns], before[columns], after[rows])
    return np.column_stack([np.bincount(rows, part, matrix.shape[0]) for part in moved.T])
