"""Bodies and obstacles by their points: what is inside, what is upright."""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from contactfem.common.typing import Bools, Floats, Ints
from contactfem.geometry.bounding_boxes import BoxTree
from contactfem.geometry.closest_point import NearestFacets
from contactfem.meshes.data import CellName, boundary_facets

FEW = 50_000  # pairs of a point and a facet that are looked at as they come
AT_END = 1e-12  # weight of the other end of a piece at which a point is at its end
SIMPLICES: dict[CellName, tuple[tuple[int, ...], ...]] = {
    "triangle": ((0, 1, 2),),
    "quadrilateral": ((0, 1, 3), (0, 3, 2)),
    "tetrahedron": ((0, 1, 2, 3),),
    "hexahedron": (
        (0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7),
    ),
}  # fmt: skip
CORNERS: dict[CellName, tuple[tuple[int, ...], ...]] = {  # simplices that a convex cell has upright
    "triangle": ((0, 1, 2),),
    "quadrilateral": ((0, 1, 2), (1, 3, 0), (2, 0, 3), (3, 2, 1)),
    "tetrahedron": ((0, 1, 2, 3),),
    "hexahedron": (
        (0, 1, 2, 4), (1, 3, 0, 5), (2, 0, 3, 6), (3, 2, 1, 7),
        (4, 6, 5, 0), (5, 4, 7, 1), (6, 7, 4, 2), (7, 5, 6, 3),
    ),
}  # fmt: skip


@dataclass(frozen=True)
class BodyShape:
    """A body's mesh at one state.

    Attributes:
        name: Name of the body.
        X: Reference positions [m], (n, dim).
        x: Current positions [m], (n, dim).
        cells: Vertices of the cells, dolfinx order, (m, nv).
        kind: Name of the cells.
    """

    name: str
    X: Floats
    x: Floats
    cells: Ints
    kind: CellName

    @cached_property
    def facets(self) -> Ints:
        """Boundary facets, outward, quadrilaterals halved, (k, dim)."""
        found = boundary_facets(self.cells, self.kind)
        if found.shape[1] == 4:
            found = np.concatenate((found[:, [0, 1, 3]], found[:, [0, 3, 2]]))
        return found

    @cached_property
    def nodes(self) -> Ints:
        """Vertices of the boundary."""
        return np.unique(self.facets)

    @cached_property
    def simplices(self) -> Ints:
        """Cells as triangles or tetrahedra, (k, dim + 1)."""
        return np.concatenate([self.cells[:, list(part)] for part in SIMPLICES[self.kind]])

    @cached_property
    def lengths(self) -> Floats:
        """Longest edge of every boundary facet, current [m], (k,)."""
        corners = self.x[self.facets]
        edges = [corners[:, a] - corners[:, a - 1] for a in range(corners.shape[1])]
        return np.asarray(np.max([np.linalg.norm(edge, axis=1) for edge in edges], axis=0))

    @property
    def finest(self) -> float:
        """Length of the shortest boundary facet [m]."""
        return float(self.lengths.min())

    def moved(self, x: Floats) -> "BodyShape":
        """The body elsewhere; what does not depend on positions is kept."""
        other = BodyShape(self.name, self.X, x, self.cells, self.kind)
        kept = {"facets": self.facets, "nodes": self.nodes, "simplices": self.simplices}
        other.__dict__.update(kept)
        return other

    def turned_over(self) -> Ints:
        """Cells that are inside out, or of which a corner is."""
        bad = np.zeros(len(self.cells), bool)
        now = self.x[self.cells]
        for corner in CORNERS[self.kind]:
            over = np.flatnonzero(_volumes(now, corner) <= 0.0)
            bad[over[_volumes(self.X[self.cells[over]], corner) > 0.0]] = True
        return np.flatnonzero(bad)

    def depth(self, points: Floats) -> Floats:
        """How deep points lie inside, by the nearest facet [m], zero outside, (m,).

        Args:
            points: Current positions [m], (m, dim).
        """
        depth = np.zeros(len(points))
        near = np.flatnonzero(((points > self.x.min(0)) & (points < self.x.max(0))).all(1))
        if len(near):
            inside = near[self._contains(points[near])]
            if len(inside):
                depth[inside] = self._distance(points[inside])
        return depth

    def _distance(self, points: Floats) -> Floats:
        """Distance to the nearest boundary facet [m], (m,)."""
        if points.shape[1] == 2 and len(points) * len(self.facets) < FEW:
            return _to_pieces(points, self.x[self.facets])
        return NearestFacets(self.x, self.facets).closest(points)[2]

    def around(self, vertex: int) -> tuple[float, float]:
        """Size of the boundary facets at a vertex [m], and the angle between them [rad]."""
        return self._of_facets((self.facets == vertex).any(1))

    def near(self, point: Floats) -> tuple[float, float]:
        """As `around`, at the nearer end of the facet that is nearest to a point [m]."""
        facet, weights, _ = NearestFacets(self.x, self.facets).closest(point[None])
        return self.around(int(self.facets[facet[0], np.argmax(weights[0])]))

    def _of_facets(self, which: Bools) -> tuple[float, float]:
        """Size of some facets [m], and how far their normals are apart [rad]."""
        corners = self.x[self.facets[which]]
        edges = corners[:, 1:] - corners[:, :1]
        if edges.shape[2] == 2:
            normals = np.column_stack((edges[:, 0, 1], -edges[:, 0, 0]))
        else:
            normals = np.cross(edges[:, 0], edges[:, 1])
        normals = normals / np.linalg.norm(normals, axis=1)[:, None]
        turn = float(np.arccos(np.clip(normals @ normals.T, -1.0, 1.0)).max())
        return float(self.lengths[which].max()), turn

    def _contains(self, points: Floats) -> Bools:
        """Which points lie inside."""
        if points.shape[1] == 2 and len(points) * len(self.facets) < FEW:
            return _odd_crossings(points, self.x[self.facets])
        found = np.zeros(len(points), bool)
        low, high = points.min(0), points.max(0)
        corners = self.x[self.simplices]
        corners = corners[((corners.min(1) <= high) & (corners.max(1) >= low)).all(1)]
        if not len(corners):
            return found
        point, cell = BoxTree(corners.min(1), corners.max(1)).meeting(points, points)
        edges = (corners[cell, 1:] - corners[cell, :1]).transpose(0, 2, 1)
        whole = np.linalg.det(edges) != 0.0
        point, cell, edges = point[whole], cell[whole], edges[whole]
        arm = points[point] - corners[cell, 0]
        weights = np.linalg.solve(edges, arm[:, :, None])[:, :, 0]
        found[point[(weights >= 0.0).all(1) & (weights.sum(1) <= 1.0)]] = True
        return found


@dataclass(frozen=True)
class ObstacleShape:
    """A rigid obstacle at one time.

    Attributes:
        name: Name of the obstacle.
        kind: Half-plane or half-space, disk or ball (or the hollow of one), cylinder, or a chain
            with its solid on the left.
        points: A point of the plane and its outward normal; the centre; a point and the direction
            of the axis; or the chain [m].
        radius: Of a disk, ball or cylinder [m].
        inside: Whether bodies are in its hollow.
        closed: Whether a chain is.
    """

    name: str
    kind: Literal["plane", "circle", "cylinder", "polyline"]
    points: Floats
    radius: float = 0.0
    inside: bool = False
    closed: bool = False

    def depth(self, points: Floats) -> Floats:
        """How deep points lie in its solid [m], zero outside, (m,)."""
        if self.kind == "plane":
            return np.maximum(-(points - self.points[0]) @ self.points[1], 0.0)
        if self.kind in ("circle", "cylinder"):
            away = points - self.points[0]
            if self.kind == "cylinder":
                away = away - np.outer(away @ self.points[1], self.points[1])
            r = np.linalg.norm(away, axis=1)
            return np.maximum(r - self.radius if self.inside else self.radius - r, 0.0)
        return self._behind_chain(points)

    def _behind_chain(self, points: Floats) -> Floats:
        """Depth behind the nearest piece of a chain; none beyond its ends."""
        n = len(self.points)
        ends = np.arange(n if self.closed else n - 1)
        facets = np.column_stack((ends, (ends + 1) % n))
        facet, weights, distance = NearestFacets(self.points, facets).closest(points)
        edge = self.points[facets[:, 1]] - self.points[facets[:, 0]]
        normal = np.column_stack((edge[:, 1], -edge[:, 0]))
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        at = np.where(
            weights[:, 1] > 1.0 - AT_END, 1, np.where(weights[:, 0] > 1.0 - AT_END, -1, 0)
        )
        other = (facet + at) % len(facets) if self.closed else facet + at
        beyond = (other < 0) | (other >= len(facets))
        both = normal[facet] + normal[np.clip(other, 0, len(facets) - 1)]
        foot = np.einsum("mv,mvd->md", weights, self.points[facets[facet]])
        behind = np.einsum("md,md->m", points - foot, both) < 0.0
        return np.where(behind & ~beyond, distance, 0.0)


def _volumes(corners: Floats, corner: tuple[int, ...]) -> Floats:
    """Signed volume of the simplex at a corner of cells, times a factor, (m,)."""
    edges = [corners[:, k] - corners[:, corner[0]] for k in corner[1:]]
    if len(edges) == 2:
        a, b = edges
        return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    return np.asarray(np.einsum("ni,ni->n", edges[0], np.cross(edges[1], edges[2])))


def _odd_crossings(points: Floats, facets: Floats) -> Bools:
    """Which points a ray to the right leaves a closed polygon an odd number of times from."""
    (x, y), a, b = points.T[:, :, None], facets[:, 0], facets[:, 1]
    spans = (a[:, 1] > y) != (b[:, 1] > y)
    rise = np.where(a[:, 1] == b[:, 1], 1.0, b[:, 1] - a[:, 1])
    at = a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / rise
    return np.asarray((spans & (x < at)).sum(1) % 2 == 1)


def _to_pieces(points: Floats, facets: Floats) -> Floats:
    """Distance of points to the nearest of some straight pieces [m], (m,)."""
    (x, y), a, edge = points.T[:, :, None], facets[:, 0], facets[:, 1] - facets[:, 0]
    dx, dy = x - a[:, 0], y - a[:, 1]
    along = dx * edge[:, 0] + dy * edge[:, 1]
    share = np.clip(along / np.einsum("ki,ki->k", edge, edge), 0.0, 1.0)
    dx, dy = dx - share * edge[:, 0], dy - share * edge[:, 1]
    return np.asarray(np.sqrt((dx**2 + dy**2).min(1)))
