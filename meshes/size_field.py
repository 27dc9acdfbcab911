"""Cell sizes given at the nodes of an old mesh."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.errors import MeshError
from contactfem.geometry.bounding_boxes import BoxTree
from contactfem.meshes.data import MeshData, boundary_facets

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from contactfem.geometry.closest_point import NearestFacets

EQUILATERAL = np.sqrt(3.0) / 4.0  # area of a triangle of side 1
INSIDE = -1e-9  # barycentric coordinate above which a point counts as inside


@dataclass(frozen=True, eq=False)
class SizeField:
    """Cell size, linear on the triangles of a mesh, and outside that at the nearest point of it.

    `points` (n, 2) [m], `cells` (m, 3) with positive area, `sizes` (n,) [m].
    """

    points: Floats
    cells: Ints
    sizes: Floats

    def __post_init__(self) -> None:
        if self.points.shape[1:] != (2,) or self.cells.shape[1:] != (3,) or not len(self.cells):
            raise MeshError("sizes are given on the triangles of a plane mesh")
        if self.sizes.shape != self.points.shape[:1]:
            raise MeshError(f"{self.sizes.size} sizes are given for {len(self.points)} points")
        if not np.all(np.isfinite(self.sizes) & (self.sizes > 0.0)):
            raise MeshError("every size must be finite and positive")

    def at(self, x: Floats) -> Floats:
        """Sizes (k,) [m] at points (k, 2) [m]."""
        point, cell, share = self._inside(x)
        sizes = np.full(len(x), np.nan)
        sizes[point] = np.sum(share * self.sizes[self.cells[cell]], axis=1)
        outside = np.flatnonzero(np.isnan(sizes))
        if len(outside):
            edges, search = self._boundary
            edge, part, _ = search.closest(x[outside])
            sizes[outside] = np.sum(part * self.sizes[edges[edge]], axis=1)
        return sizes

    def covers(self, x: Floats) -> NDArray[np.bool_]:
        """Which points (k, 2) [m] lie in a triangle of the old mesh."""
        found = np.zeros(len(x), bool)
        found[self._inside(x)[0]] = True
        return found

    def number_of_cells(self) -> float:
        """Equilateral triangles that fill the old mesh at these sizes, ∫ 4 / (√3 h²) dA.

        With h linear the integral over a triangle of area A is exactly 2 A f[h1, h2, h3] with the
        divided difference of f = -ln h, whose second derivative is 1/h².
        """
        a, b, c = np.sort(self.sizes[self.cells], axis=1).T
        first, second = _slope(a, b), _slope(b, c)
        apart = c - a > 1e-4 * a
        bend = np.divide(second - first, c - a, out=0.5 / (a + b + c) ** 2 * 9.0, where=apart)
        return float(np.sum(2.0 * _areas(self.points, self.cells) * bend) / EQUILATERAL)

    def graded(self, growth: float) -> SizeField:
        """The same sizes, but none larger than another plus `growth` times the way along edges.

        Args:
            growth: largest increase of the size per distance [-].

        Returns:
            The largest such field that is nowhere larger than this one.
        """
        n = len(self.points)
        low, high = np.sort(self.cells[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1).T
        a, b = np.divmod(np.unique(low * n + high), n)
        rise = growth * np.hypot(*(self.points[a] - self.points[b]).T)
        sizes = self.sizes.copy()
        before: Floats = np.zeros(0)
        while not np.array_equal(sizes, before):
            before = sizes.copy()
            np.minimum.at(sizes, a, before[b] + rise)
            np.minimum.at(sizes, b, before[a] + rise)
        return replace(self, sizes=sizes)

    def limited(self, x: Floats, sizes: Floats, growth: float) -> SizeField:
        """Graded sizes that are also small around points.

        Args:
            x: points (k, 2) [m].
            sizes: sizes (k,) there [m].
            growth: largest increase of the size per distance [-].

        Returns:
            The largest graded field that obeys this at the old node next to every point.
        """
        limited = self.sizes.copy()
        for point, size in zip(x, sizes, strict=True):
            distance = np.hypot(*(self.points - point).T)
            node = int(np.argmin(distance))
            limited[node] = min(limited[node], size + growth * distance[node])
        return replace(self, sizes=limited).graded(growth)

    @cached_property
    def _boxes(self) -> BoxTree:
        """Boxes of the triangles, with some room."""
        corners = self.points[self.cells]
        slack = 1e-9 * np.ptp(self.points)
        return BoxTree(corners.min(axis=1) - slack, corners.max(axis=1) + slack)

    @cached_property
    def _boundary(self) -> tuple[Ints, NearestFacets]:
        """Facets (k, 2) on the boundary, searched for the nearest one."""
        from contactfem.geometry.closest_point import (
            NearestFacets,  # scipy, not before a mesh is adapted
        )

        edges = boundary_facets(self.cells, "triangle")
        return edges, NearestFacets(self.points, edges)

    def _inside(self, x: Floats) -> tuple[Ints, Ints, Floats]:
        """Points that lie in a triangle, which one, and their barycentric coordinates (k, 3)."""
        point, cell = self._boxes.meeting(x, x)
        a, b, c = self.points[self.cells[cell]].transpose(1, 2, 0)
        (ux, uy), (vx, vy), (wx, wy) = b - a, c - a, x[point].T - a
        det = ux * vy - uy * vx
        s, t = (wx * vy - wy * vx) / det, (ux * wy - uy * wx) / det
        share = np.stack([1.0 - s - t, s, t], axis=1)
        inside = share.min(axis=1) >= INSIDE
        point, once = np.unique(point[inside], return_index=True)
        return point, cell[inside][once], share[inside][once]


def flat_lengths(sizes: Floats, aspect: float | Floats, longest: float) -> Floats:
    """Lengths of flat cells, max(h, min(a h, l)).

    Args:
        sizes: their thicknesses h [m], (n,).
        aspect: largest length over thickness a [-], one or (n,).
        longest: length l that they do not exceed [m].

    Returns:
        The lengths [m], (n,).
    """
    return np.asarray(np.maximum(np.minimum(aspect * sizes, longest), sizes))


def size_field(data: MeshData, sizes: Floats) -> SizeField:
    """Size field on the triangles of a mesh, or on the halves of its quadrilaterals.

    Args:
        data: a plane mesh.
        sizes: wanted sizes (n,) at its points [m].

    Returns:
        The field.

    Raises:
        MeshError: the mesh is not plane, or the sizes do not fit it.
    """
    cells = data.cells
    if data.cell_type == "quadrilateral":
        cells = cells[:, [[0, 1, 3], [0, 3, 2]]].reshape(-1, 3)
    return SizeField(data.points, cells, sizes)


def _slope(a: Floats, b: Floats) -> Floats:
    """Divided difference -(ln b - ln a) / (b - a), accurate for all 0 < a <= b."""
    x = (b - a) / a
    slope: Floats = -np.divide(np.log1p(x), x, out=np.ones_like(x), where=x > 0.0) / a
    return slope


def _areas(points: Floats, cells: Ints) -> Floats:
    """Areas (m,) [m²] of triangles."""
    (ax, ay), (bx, by) = (points[cells[:, k]].T - points[cells[:, 0]].T for k in (1, 2))
    areas: Floats = 0.5 * np.abs(ax * by - ay * bx)
    return areas


def nearest_edge(x: Floats, a: Floats, b: Floats) -> tuple[Ints, Floats]:
    """For points (k, 2) the nearest of the edges a b (m, 2), and the part of its length there."""
    along = b - a
    part = np.einsum("kmi,mi->km", x[:, None] - a, along) / np.sum(along**2, axis=1)
    part = np.clip(part, 0.0, 1.0)
    gap = x[:, None] - a - part[..., None] * along
    edge = np.argmin(np.sum(gap**2, axis=2), axis=1)
    return edge, part[np.arange(len(x)), edge]
