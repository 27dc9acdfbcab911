"""Nearest point of a polyline or triangulated surface."""

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.geometry.bounding_boxes import BoxTree

SLACK = 1e-9  # relative, by which a sphere that must hold the nearest point is made larger
TINY = 1e-150  # [m], of which the square is not lost


class NearestFacets:
    """Facets of a surface, searched for the nearest one."""

    def __init__(self, X: Floats, facets: Ints) -> None:
        """Prepare the search.

        Args:
            X: coordinates [m], (n, dim).
            facets: segments or triangles by their vertices, (k, 2) or (k, 3), at least one.
        """
        from scipy.spatial import cKDTree  # slow to import, and rarely needed

        self.corners = X[facets]
        self._vertices = cKDTree(X[np.unique(facets)])
        self._tree = BoxTree(self.corners.min(axis=1), self.corners.max(axis=1))

    def closest(self, points: Floats) -> tuple[Ints, Floats, Floats]:
        """Facet nearest to each point, the weights of its vertices there, and the distance.

        Args:
            points: the points [m], (m, dim).

        Returns:
            Facets (m,), weights in [0, 1] with the sum 1 (m, nf), distances [m] (m,).
        """
        # no facet is farther than the nearest vertex
        radius = (1.0 + SLACK) * self._vertices.query(points)[0][:, None] + TINY
        point, facet = self._tree.meeting(points - radius, points + radius)
        weights = closest_weights(self.corners[facet], points[point])
        away = np.einsum("mv,mvd->md", weights, self.corners[facet]) - points[point]
        distance = np.linalg.norm(away, axis=1)
        best = cheapest(point, distance)
        return facet[best], weights[best], distance[best]


def closest_weights(corners: Floats, points: Floats) -> Floats:
    """Weights in [0, 1] of the corners of a simplex, at its point nearest to another.

    Args:
        corners: corners of the simplex of each point [m], (m, nf, dim).
        points: the points [m], (m, dim).

    Returns:
        Weights (m, nf) with the sum 1.
    """
    m, n, _ = corners.shape
    if n == 1:
        return np.ones((m, 1))
    edges = corners[:, 1:] - corners[:, :1]
    metric = np.einsum("mad,mbd->mab", edges, edges)
    along = np.einsum("mad,md->ma", edges, points - corners[:, 0])
    inner = np.linalg.solve(metric, along[..., None])[..., 0]
    weights = np.concatenate([1.0 - inner.sum(axis=1, keepdims=True), inner], axis=1)
    outside = np.flatnonzero((weights < 0.0).any(axis=1))
    best = np.full(len(outside), np.inf)
    for left_out in range(n if len(outside) else 0):
        rest = np.delete(np.arange(n), left_out)
        part = np.zeros((len(outside), n))
        part[:, rest] = closest_weights(corners[outside][:, rest], points[outside])
        away = np.einsum("mv,mvd->md", part, corners[outside]) - points[outside]
        distance = np.linalg.norm(away, axis=1)
        nearer = distance < best
        weights[outside[nearer]] = part[nearer]
        best = np.minimum(best, distance)
    return np.asarray(weights)


def cheapest(group: Ints, cost: Floats) -> Ints:
    """Place of the smallest cost in each group, the first one of equals.

    Args:
        group: number of the group of each entry, ascending, (k,).
        cost: (k,).

    Returns:
        One place per group, by ascending groups.
    """
    order = np.lexsort((cost, group))
    return np.asarray(order[np.flatnonzero(np.diff(group[order], prepend=-1))])
