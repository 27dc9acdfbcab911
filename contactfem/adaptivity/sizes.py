"""New cell sizes from element errors (41).

Sizes h are edges of equilateral triangles, or of squares, of the area of a cell.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import dijkstra

from contactfem.common.typing import Floats, Ints
from contactfem.geometry.cells import DENSITY, cell_areas
from contactfem.meshes.size_field import flat_lengths
from contactfem.results.relative_error import RelativeError

DIMENSION = 2
DIGITS = 2.0**20  # parts of a power of two that sizes are rounded to


@dataclass(frozen=True)
class SizeLimits:
    """Limits of the cells of one mesh.

    Attributes:
        smallest: Smallest size [m].
        largest: Largest size [m].
        growth: Increase of the size per distance [-], positive.
        cells: Most cells of the mesh; this limit holds even where others have to yield.
        coarsening: Largest size over the present one [-]: coarse cells are predicted badly.
        aspect: Largest length over size of flat cells, at all vertices or at each [-].
        longest: Length that flat cells do not exceed [m].
    """

    smallest: float
    largest: float
    growth: float
    cells: int
    coarsening: float = 4.0
    aspect: float | Floats = 1.0
    longest: float = np.inf

    def lengths(self, sizes: Floats) -> Floats:
        """Lengths of cells along surfaces [m] from sizes at the vertices [m], (n,)."""
        return flat_lengths(sizes, self.aspect, self.longest)


def goal(found: RelativeError, tolerance: float) -> float:
    """Square of the error with which η (40) is the tolerance: η_tol² (‖v‖² + ‖e‖²).

    Args:
        found: The error of the present mesh; the sum in brackets does not change with the mesh.
        tolerance: η_tol, a ratio of norms.

    Returns:
        The square.
    """
    return tolerance**2 * (found.norm_square + found.error_square)


def equal_error_sizes(sizes: Floats, errors: Floats, goal_square: float, order: int) -> Floats:
    """Sizes of the mesh that has the fewest cells of all with a given error.

    A cell of size h in the place of K has the error e = e_K (h/h_K)^(p+d/2) (p for the field, d/2
    for the cell's extent), and K is replaced by (h_K/h)^d cells. The minimum of their number for
    Σ e² = e_goal² has equal errors ē in all new cells:

        h = h_K (ē/e_K)^(1/(p+d/2)),    ē^(2p/(p+d/2)) = e_goal² / Σ_K e_K^(d/(p+d/2))

    (41) is printed with 1/p (`printed_sizes`). Both agree when all e_K are equal; on the way there
    (41) refines and coarsens too far, with more cells for the same error.

    Args:
        sizes: h_K, of all meshes that share the goal [m], shape (m,).
        errors: Squares of the errors, e_K², shape (m,).
        goal_square: Square of the error wanted, e_goal².
        order: p, the order of the elements.

    Returns:
        New sizes, infinite without any error [m], shape (m,).
    """
    total = order + 0.5 * DIMENSION
    share = errors ** (0.5 * DIMENSION / total)
    mean = (goal_square / max(share.sum(), np.finfo(float).tiny)) ** (0.5 * total / order)
    return _scaled(sizes, errors, mean, total)


def printed_sizes(sizes: Floats, errors: Floats, goal_square: float, order: int) -> Floats:
    """Sizes as (41) is printed, h = h_K (ē/e_K)^(1/p) with ē = e_goal/√m for m cells.

    The error of all that replaces a cell K is then ē: the goal is met, and equally by the *present*
    cells (Zienkiewicz & Zhu 1987).

    Args:
        sizes: h_K, of all meshes that share the goal [m], shape (m,).
        errors: Squares of the errors, e_K², shape (m,).
        goal_square: Square of the error wanted, e_goal².
        order: p, the order of the elements.

    Returns:
        New sizes, infinite without any error [m], shape (m,).
    """
    return _scaled(sizes, errors, np.sqrt(goal_square / max(len(sizes), 1)), float(order))


def size_field(
    points: Floats, cells: Ints, present: Floats, wanted: Floats, limits: SizeLimits
) -> Floats:
    """Nodal sizes within the limits.

    Args:
        points: Vertices of the present mesh [m], shape (n, 2).
        cells: Its cells, shape (m, 3 or 4).
        present: Their sizes [m], shape (m,).
        wanted: New sizes in their place [m], shape (m,).
        limits: The limits.

    Returns:
        Sizes at the vertices [m], shape (n,); linear in between.
    """
    allowed = np.minimum(wanted, limits.coarsening * present)
    allowed = np.clip(allowed, limits.smallest, limits.largest)
    field = graded(points, cells, _nodal(points, cells, allowed), limits.growth)
    excess = predicted_cells(points, cells, field, limits) / limits.cells
    while excess > 1.0:
        field = graded(points, cells, np.sqrt(excess) * 1.001 * field, limits.growth)
        excess = predicted_cells(points, cells, field, limits) / limits.cells
    return field


def rounded(sizes: Floats) -> Floats:
    """Sizes to about six digits: round-off, other on every number of ranks, makes no other mesh.

    Args:
        sizes: Sizes [m].
    """
    mantissa, exponent = np.frexp(sizes)
    return np.asarray(np.ldexp(np.round(mantissa * DIGITS) / DIGITS, exponent))


def graded(points: Floats, cells: Ints, sizes: Floats, growth: float) -> Floats:
    """Largest field below some sizes with |h_i - h_j| ≤ growth |x_i - x_j| along all edges.

    h_i = min_j (h_j + growth · distance of i and j along edges): shortest paths from a source that
    is h_j away from each vertex j.

    Args:
        points: Vertices of the mesh [m], shape (n, 2).
        cells: Its cells, shape (m, nv).
        sizes: Sizes at the vertices [m], shape (n,), positive.
        growth: Increase of the size per distance [-], positive.

    Returns:
        Sizes [m], shape (n,).
    """
    n, (m, k) = len(points), cells.shape
    incidence = sp.csr_matrix((np.ones(m * k), (np.repeat(np.arange(m), k), cells.ravel())), (m, n))
    i, j = (incidence.T @ incidence).nonzero()
    i, j = i[i != j], j[i != j]
    length = growth * np.hypot(*(points[i] - points[j]).T)
    rows, cols = np.concatenate((i, np.full(n, n))), np.concatenate((j, np.arange(n)))
    graph = sp.csr_matrix((np.concatenate((length, sizes)), (rows, cols)), (n + 1, n + 1))
    return np.asarray(dijkstra(graph, indices=n)[:n])


def predicted_cells(points: Floats, cells: Ints, sizes: Floats, limits: SizeLimits) -> float:
    """Cells of a mesh with nodal sizes h and lengths l: ∫ 1/(h l), times 4/√3 for triangles.

    Args:
        points: Vertices of the present mesh [m], shape (n, 2).
        cells: Its cells, shape (m, 3 or 4).
        sizes: Sizes at the vertices [m], shape (n,).
        limits: Has the lengths.

    Returns:
        The number.
    """
    density = np.mean(1.0 / (sizes * limits.lengths(sizes))[cells], axis=1)
    return float(DENSITY[cells.shape[1]] * cell_areas(points, cells) @ density)


def predicted_error(
    cells: Ints, present: Floats, sizes: Floats, errors: Floats, order: int
) -> float:
    """Square of the error of a mesh with new sizes: Σ e_K² (h/h_K)^(2p).

    Args:
        cells: Cells of the present mesh, shape (m, 3 or 4).
        present: Their sizes h_K [m], shape (m,).
        sizes: New sizes at its vertices [m], shape (n,).
        errors: Squares of its errors, shape (m,).
        order: p.

    Returns:
        The square.
    """
    ratio = sizes[cells].mean(axis=1) / present
    return float(errors @ ratio ** (2.0 * order))


def _scaled(sizes: Floats, errors: Floats, mean: float, exponent: float) -> Floats:
    with np.errstate(divide="ignore"):
        return np.asarray(sizes * (mean / np.sqrt(errors)) ** (1.0 / exponent))


def _nodal(points: Floats, cells: Ints, sizes: Floats) -> Floats:
    """Sizes at vertices from those of cells: means of 1/h², so that the number of cells stays."""
    area, k = cell_areas(points, cells), cells.shape[1]
    index, n = cells.ravel(), len(points)
    count = np.bincount(index, np.repeat(area / sizes**2, k), n)
    return np.asarray(np.sqrt(np.bincount(index, np.repeat(area, k), n) / count))
