"""Linear shape functions, and reference coordinates of points.

basix tabulates the same functions, but takes 4 to 10 times as long for 20 000 points, and at a
vertex it gives 1 and 0 to round-off only, where transfers rely on exact ones.
"""

from functools import reduce
from itertools import product

import numpy as np

from contactfem.common.typing import Floats
from contactfem.meshes.data import CellName

ITERATIONS = 50  # of Newton's method: usually 2 to 6
CONVERGED = 1e-9  # change of a reference coordinate, which the step after it squares


def is_simplex(cell_type: CellName) -> bool:
    """Whether cells are triangles or tetrahedra, mapped affinely."""
    return cell_type in ("triangle", "tetrahedron")


def shape_functions(cell_type: CellName, xi: Floats) -> tuple[Floats, Floats]:
    """Values N_I(ξ) and derivatives dN_I/dξ of the shape functions.

    Args:
        cell_type: name of the cells.
        xi: reference coordinates (m, dim).

    Returns:
        Values (m, nv) and derivatives (m, nv, dim), vertices in dolfinx order.
    """
    m, dim = xi.shape
    if is_simplex(cell_type):
        slope = np.concatenate([-np.ones((1, dim)), np.eye(dim)])
        values = np.concatenate([1.0 - xi.sum(axis=1, keepdims=True), xi], axis=1)
        return values, np.broadcast_to(slope, (m, dim + 1, dim))
    # vertex k of a tensor cell has the coordinates that are the bits of k, the first one lowest
    bits = [tuple(reversed(b)) for b in product((0, 1), repeat=dim)]
    ends = np.stack([1.0 - xi, xi])
    values = np.empty((m, len(bits)))
    slopes = np.empty((m, len(bits), dim))
    for vertex, corner in enumerate(bits):
        factors = [ends[bit, :, axis] for axis, bit in enumerate(corner)]
        values[:, vertex] = reduce(np.multiply, factors)
        for axis, bit in enumerate(corner):
            others = factors[:axis] + factors[axis + 1 :]
            slopes[:, vertex, axis] = (2 * bit - 1) * reduce(np.multiply, others)
    return values, slopes


def margin(cell_type: CellName, xi: Floats) -> Floats:
    """How far inside of the reference cell points lie (m,): negative outside."""
    inner = xi.min(axis=1)
    rest = 1.0 - (xi.sum(axis=1) if is_simplex(cell_type) else xi.max(axis=1))
    return np.asarray(np.minimum(inner, rest))


def pull_back(cell_type: CellName, X: Floats, points: Floats) -> Floats:
    """Reference coordinates ξ with Σ N_I(ξ) X_I = x, for points in a cell or not far from it.

    Exact for simplices. Else Newton's method within the cell, where the Jacobian is positive, and
    one step that may leave it: outside of a cell ξ says that, but not exactly how far.

    Args:
        cell_type: name of the cells.
        X: vertices of the cell of each point [m], (m, nv, dim).
        points: the points [m], (m, dim).

    Returns:
        ξ (m, dim).
    """
    xi = np.full(points.shape, 1.0 / (points.shape[1] + 1.0) if is_simplex(cell_type) else 0.5)
    if not is_simplex(cell_type):
        moving = np.arange(len(points))
        for _ in range(ITERATIONS):
            old = xi[moving]
            step = _step(cell_type, X[moving], points[moving], old)
            xi[moving] = np.clip(old + step, 0.0, 1.0)
            moving = moving[np.abs(xi[moving] - old).max(axis=1) > CONVERGED]
            if not len(moving):
                break
    return xi + _step(cell_type, X, points, xi)


def linear_weights(cell_type: CellName, X: Floats, points: Floats, xi: Floats) -> Floats:
    """Weights of the vertices that give a linear field exactly at a point.

    w_I = N_I(ξ) + Grad N_I(ξ) · (x - Σ N_K(ξ) X_K): with ξ near to the point, inside or out, the
    field's value at ξ and from there its gradient.

    Args:
        cell_type: name of the cells.
        X: vertices of the cell of each point [m], (m, nv, dim).
        points: the points x [m], (m, dim).
        xi: reference coordinates near to the points (m, dim).

    Returns:
        Weights (m, nv) with the sum 1.
    """
    values, slopes = shape_functions(cell_type, xi)
    step = _step(cell_type, X, points, xi)
    return np.asarray(values + (slopes * step[:, None, :]).sum(axis=2))


def _step(cell_type: CellName, X: Floats, points: Floats, xi: Floats) -> Floats:
    """J⁻¹ (x - Σ N_I(ξ) X_I) with J = Σ X_I dN_I/dξ, (m, dim)."""
    values, slopes = shape_functions(cell_type, xi)
    rest = points - np.einsum("mv,mvd->md", values, X)
    J = X.transpose(0, 2, 1) @ slopes
    step: Floats = np.linalg.solve(J, rest[..., None])[..., 0]
    return step
