"""Patch recovery under linear constraints, such as known tractions (36)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contactfem.adaptivity.recovery.patches import Patches
from contactfem.common.typing import Floats, Ints

PENALTY = 1e8  # weight of a condition over that of a sample


@dataclass(frozen=True)
class Expansion:
    """Polynomials, one for each of several places, seen from one point each.

    Attributes:
        coefficients: a of τ* = p a, shape (k, b, c).
        compliance: (PᵀP)⁻¹ of their fits over the weight of a sample [-], shape (k, b, b).
        basis: p at the points, shape (k, b).
    """

    coefficients: Floats
    compliance: Floats
    basis: Floats

    @property
    def values(self) -> Floats:
        """τ* at the points, shape (k, c)."""
        values: Floats = np.einsum("kb,kbc->kc", self.basis, self.coefficients)
        return values


def expansion(patches: Patches, coefficients: Floats, rows: Ints, x: Floats) -> Expansion:
    """Look at some of the polynomials of a mesh from one point each.

    Args:
        patches: The patches.
        coefficients: What they fitted, shape (k, b, c).
        rows: Indices into the patches' vertices, shape (j,).
        x: Points [m], shape (j, 2).

    Returns:
        The expansions.
    """
    return Expansion(coefficients[rows], patches.compliance[rows], patches.basis(rows, x))


def constrained(
    expansions: Sequence[Expansion],
    conditions: Sequence[Floats],
    targets: Floats,
    penalty: float = PENALTY,
) -> tuple[Expansion, ...]:
    """Fit polynomials together under conditions Σ_i A_i τ*_i(x) = b, enforced by a penalty, (36).

    Minimises Σ_i Σ (τ_h - p a_i)² + w |Σ_i A_i p(x) a_i - b|² over all a_i. About the separate fits
    a_i⁰ the first sum grows as |P_i (a_i - a_i⁰)|², so that, with the force μ of the conditions,

        (Σ_i v_i A_i A_iᵀ + 1/w) μ = Σ_i A_i τ_i⁰(x) - b,    a_i = a_i⁰ - (P_iᵀP_i)⁻¹ pᵀ (A_iᵀ μ)ᵀ

    where v_i = p (P_iᵀP_i)⁻¹ pᵀ. This does not lose digits to w as the normal equations do.

    Args:
        expansions: The separate fits of each side, k polynomials each.
        conditions: A_i of each side, shape (k, r, c); rows of zeros state nothing.
        targets: b, shape (k, r).
        penalty: w, relative to the weight of a sample.

    Returns:
        The polynomials of each side.
    """
    matrix = np.broadcast_to(np.eye(targets.shape[1]) / penalty, (*targets.shape, targets.shape[1]))
    defect, directions = -targets, []
    for side, A in zip(expansions, conditions, strict=True):
        directions.append(np.einsum("kab,kb->ka", side.compliance, side.basis))
        leverage = np.einsum("kb,kb->k", side.basis, directions[-1])
        matrix = matrix + leverage[:, None, None] * (A @ A.transpose(0, 2, 1))
        defect = defect + np.einsum("krc,kc->kr", A, side.values)
    force = np.linalg.solve(matrix, defect[:, :, None])[:, :, 0]
    return tuple(
        Expansion(
            side.coefficients - np.einsum("kb,krc,kr->kbc", direction, A, force),
            side.compliance,
            side.basis,
        )
        for side, A, direction in zip(expansions, conditions, directions, strict=True)
    )


@dataclass(frozen=True)
class ConstraintRows:
    """Known combinations a · τ*(x_I) = b at vertices, one by one; several at one are allowed.

    Attributes:
        vertices: The vertices I, shape (r,).
        rows: a, shape (r, c).
        targets: b, shape (r,).
    """

    vertices: Ints
    rows: Floats
    targets: Floats


def with_conditions(
    patches: Patches, coefficients: Floats, conditions: ConstraintRows, penalty: float = PENALTY
) -> Floats:
    """Recovered polynomials that obey what is known on the boundary (Wiberg et al. 1998).

    Args:
        patches: The patches; their vertices need not include all those of the conditions.
        coefficients: Their fits by (33), shape (k, b, c).
        conditions: Known heat flows q·n or components of the traction σn at vertices.
        penalty: Weight of a condition, relative to that of a sample.

    Returns:
        Coefficients, shape (k, b, c).
    """
    order = np.argsort(conditions.vertices, kind="stable")
    vertices, first, count = np.unique(
        conditions.vertices[order], return_index=True, return_counts=True
    )
    here = np.isin(vertices, patches.vertices)
    slot = np.arange(len(order)) - np.repeat(first, count)
    place = np.repeat(np.arange(len(vertices)), count)
    A = np.zeros((len(vertices), int(count.max(initial=0)), coefficients.shape[2]))
    b = np.zeros(A.shape[:2])
    A[place, slot], b[place, slot] = conditions.rows[order], conditions.targets[order]
    by_number = np.argsort(patches.vertices)
    rows = by_number[np.searchsorted(patches.vertices, vertices[here], sorter=by_number)]
    side = expansion(patches, coefficients, rows, patches.centres[rows])
    (fitted,) = constrained((side,), (A[here],), b[here], penalty)
    result = coefficients.copy()
    result[rows] = fitted.coefficients
    return result


def heat_flow_rows(normals: Floats) -> Floats:
    """Row a of q·n = a · (q_x, q_y).

    Args:
        normals: Unit normals, shape (k, 2).

    Returns:
        Rows, shape (k, 1, 2).
    """
    return normals[:, None, :]


def traction_rows(normals: Floats) -> Floats:
    """Rows of n·σn and τ·σn for σ = (xx, yy, zz, xy), with the tangent τ = (n_y, -n_x).

    Args:
        normals: Unit normals, shape (k, 2).

    Returns:
        Rows, shape (k, 2, 4): the normal and the tangential component of σn.
    """
    nx, ny = normals.T
    zero = np.zeros_like(nx)
    normal = np.column_stack((nx**2, ny**2, zero, 2.0 * nx * ny))
    tangential = np.column_stack((nx * ny, -nx * ny, zero, ny**2 - nx**2))
    return np.stack((normal, tangential), axis=1)
