"""Location of points in a mesh: cell and interpolation weights."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from contactfem.common.typing import Floats, Ints
from contactfem.geometry.bounding_boxes import BoxTree
from contactfem.geometry.closest_point import NearestFacets, cheapest
from contactfem.meshes.data import MeshData, boundary
from contactfem.transfer.shape_functions import linear_weights, margin, pull_back

INSIDE = 1e-8  # reference coordinate by which a point of a cell may lie outside of it
NUDGE = 1e-6  # of the way inward, which tells the two lips of a slit apart


@dataclass(frozen=True)
class Places:
    """Where points lie in a mesh.

    Attributes:
        cells: Cell of each point: one that holds it, or that of the nearest boundary facet, (n,).
        weights: Weights of the cell's vertices, (n, nv); they give linear fields exactly.
        distance: How far outside of the mesh the points lie [m], 0 inside, (n,).
    """

    cells: Ints
    weights: Floats
    distance: Floats


class Location:
    """A mesh in which points are located."""

    def __init__(self, data: MeshData) -> None:
        """Prepare the search.

        Args:
            data: the mesh.
        """
        self._data = data
        X = data.points[data.cells]
        low, high = X.min(axis=1), X.max(axis=1)
        slack = 2.0 * INSIDE * (high - low).max(axis=1, keepdims=True)
        self._tree = BoxTree(low - slack, high + slack)

    def places(self, points: Floats, inward: Floats) -> Places:
        """Locate points; what is said of one does not depend on the others.

        Args:
            points: the points [m], (n, dim).
            inward: for each a point that lies on the body's side of it [m], (n, dim). It decides
                between cells that both hold the point, such as those across a slit.

        Returns:
            Their places.
        """
        cells = np.full(len(points), -1, dtype=np.int64)
        xi = np.empty(points.shape)
        point, cell, at = self._holding(points)
        chosen = cheapest(point, self._reluctance(points, inward, point, cell))
        cells[point[chosen]], xi[point[chosen]] = cell[chosen], at[chosen]
        distance = np.zeros(len(points))
        outside = np.flatnonzero(cells < 0)
        if len(outside):
            cells[outside], xi[outside], distance[outside] = self._nearest(points[outside])
        kind, X = self._data.cell_type, self._data.points[self._data.cells[cells]]
        return Places(cells, linear_weights(kind, X, points, xi), distance)

    def _holding(self, points: Floats) -> tuple[Ints, Ints, Floats]:
        """Pairs of a point and a cell that holds it, ascending, and where in the cell."""
        point, cell = self._tree.meeting(points, points)
        xi = self._pull_back(cell, points[point])
        held = margin(self._data.cell_type, xi) >= -INSIDE
        return point[held], cell[held], xi[held]

    def _reluctance(self, points: Floats, inward: Floats, point: Ints, cell: Ints) -> Floats:
        """How far outside of a cell a point gets a little inward of one that several cells hold."""
        reluctance = np.zeros(len(point))
        several = np.flatnonzero(np.bincount(point)[point] > 1)
        nudged = (1.0 - NUDGE) * points + NUDGE * inward
        xi = self._pull_back(cell[several], nudged[point[several]])
        reluctance[several] = -margin(self._data.cell_type, xi)
        return reluctance

    def _nearest(self, points: Floats) -> tuple[Ints, Floats, Floats]:
        """Cell of the nearest boundary facet, where in the cell, and the distance."""
        facets, owner = self._boundary
        facet, weights, distance = facets.closest(points)
        on_facet = np.einsum("mv,mvd->md", weights, facets.corners[facet])
        cells = owner[facet]
        return cells, self._pull_back(cells, on_facet), distance

    def _pull_back(self, cell: Ints, points: Floats) -> Floats:
        X = self._data.points[self._data.cells[cell]]
        return pull_back(self._data.cell_type, X, points)

    @cached_property
    def _boundary(self) -> tuple[NearestFacets, Ints]:
        """Boundary facets as simplices, and the cell of each."""
        facets, owner = boundary(self._data.cells, self._data.cell_type)
        split = simplices(facets)
        return NearestFacets(self._data.points, split), np.tile(owner, len(split) // len(facets))


def simplices(facets: Ints) -> Ints:
    """Facets (k, nf) as segments or triangles: all first halves of quadrilaterals, then the others.

    Args:
        facets: segments, triangles, or quadrilaterals in tensor order.

    Returns:
        (k, 2), (k, 3) or (2 k, 3).
    """
    if facets.shape[1] != 4:
        return facets
    return np.concatenate([facets[:, [0, 1, 3]], facets[:, [0, 3, 2]]])


def cell_sizes(points: Floats, cells: Ints) -> Floats:
    """Diagonals of the bounding boxes of cells or facets [m], (m,)."""
    X = points[cells]
    return np.asarray(np.linalg.norm(np.ptp(X, axis=1), axis=1))


def surroundings(points: Floats, cells: Ints) -> tuple[Floats, Floats]:
    """Middle of the cells, or facets, around each point, and the size of the largest one.

    Args:
        points: coordinates [m], (n, dim).
        cells: by their points, each of which is used, (m, nv).

    Returns:
        Middles [m], (n, dim), and sizes [m], (n,).
    """
    m, nv = cells.shape
    starts = np.arange(0, m * nv + 1, nv)
    around = sp.csc_array((np.ones(m * nv), cells.ravel(), starts), shape=(len(points), m))
    middle = around @ points[cells].mean(axis=1) / around.sum(axis=1)[:, None]
    size = np.zeros(len(points))
    np.maximum.at(size, cells, cell_sizes(points, cells)[:, None])
    return middle, size
