"""Layers of anisotropic cells along surfaces."""

from dataclasses import dataclass, replace

import numpy as np

from contactfem.common.typing import Bools, Floats, Ints
from contactfem.meshes.boundary_nodes import Division
from contactfem.meshes.curves import Boundary, Curve
from contactfem.meshes.size_field import SizeField, flat_lengths

GROWTH = 0.25  # largest increase of facets along a surface per distance, as of isotropic cells
RATIO = 1.25  # largest thickness of a row over that of the row before
SHARE = 0.2  # of the columns in which a row may be thicker than wanted
TURN = np.deg2rad(20.0)  # a corner that ends a layer
MAX_ROWS = 80
ROOM, AWAY = 2.5, 0.3  # so many heights above a surface the next one is this part of that away
SHORT = 1e-4  # part of a curve that shows its direction


@dataclass(frozen=True)
class Layers:
    """Surfaces at which cells may be longer than thick.

    Attributes:
        groups: Groups of these surfaces.
        aspect: Largest length over thickness [-], at least 1.
        longest: Length of facets that flat cells do not exceed [m].
        rows: Least number of rows, also where cells are not flat.
    """

    groups: frozenset[str]
    aspect: float
    longest: float
    rows: int = 0

    def facets(self, sizes: Floats) -> Floats:
        """Lengths of facets [m] where cells are as thick as `sizes` [m]."""
        return flat_lengths(sizes, self.aspect, self.longest)

    def mean(self, sizes: Floats) -> Floats:
        """Sizes of equilateral triangles with the areas of flat cells [m]."""
        return np.asarray(np.sqrt(sizes * self.facets(sizes)))


@dataclass(frozen=True)
class Rows:
    """A boundary with rows of triangles on it, and the smaller region that is left.

    Attributes:
        nodes: Those of the boundary, then those of the rows, (n, 2) [m].
        loops: Loops around the region that is left, by these nodes.
        cells: Triangles of the rows, (m, 3).
    """

    nodes: Floats
    loops: tuple[Ints, ...]
    cells: Ints


def facet_lengths(boundary: Boundary, field: SizeField, layers: Layers) -> SizeField:
    """Lengths of facets on the surfaces, as long as cells are thick where these end.

    Args:
        boundary: Closed loops of curves.
        field: Wanted thicknesses.
        layers: The surfaces.
    """
    ends = []
    for loop in boundary:
        for before, after in zip((loop[-1], *loop[:-1]), loop, strict=True):
            flat = [layers.groups.isdisjoint(curve.groups) for curve in (before, after)]
            if not all(flat) and (any(flat) or _turn(before, after) > TURN):
                ends.append(after.at(np.zeros(1))[0])
    x = np.array(ends).reshape(-1, 2)
    lengths = replace(field, sizes=layers.facets(field.sizes)).graded(GROWTH)
    return lengths.limited(x, field.at(x), GROWTH)


def _turn(before: Curve, after: Curve) -> float:
    """Angle between two curves that follow each other."""
    (a, b), (c, d) = before.at(np.array([1.0 - SHORT, 1.0])), after.at(np.array([0.0, SHORT]))
    (ax, ay), (bx, by) = b - a, d - c
    return abs(float(np.arctan2(ax * by - ay * bx, ax * bx + ay * by)))


def with_rows(division: Division, field: SizeField, layers: Layers | None) -> Rows:
    """Grow rows from the facets of some groups.

    Thicknesses follow the field into the body, with ratios that are the same in all columns; rows
    end where cells are as thick as long, one by one towards the ends of a surface, so that facets
    of the region that is left are about as long as the cells that fill it.

    Args:
        division: The boundary, its facets as long as `Layers.facets` says.
        field: Wanted thicknesses.
        layers: Where; None for no rows.

    Returns:
        The rows; fewer where the body is thin.
    """
    nodes, loops = [division.nodes], list[Ints]()
    cells: list[Ints] = [np.empty((0, 3), dtype=np.int64)]
    first = len(division.nodes)
    chosen = _chosen(division, layers)
    for loop in division.loops:
        if layers is None or not np.any(chosen[loop]):
            loops.append(loop)
            continue
        columns = _columns(division, loop, chosen, field, layers)
        inner, own, top = _triangles(columns, loop, first)
        nodes.append(inner)
        cells.append(own)
        loops.append(top)
        first += len(inner)
    return Rows(np.concatenate(nodes), tuple(loops), np.concatenate(cells))


@dataclass(frozen=True)
class _Columns:
    """Columns of nodes above those of a loop.

    `normals` (n, 2) into the body, `heights` (n, rows + 1) [m] of which each uses the first
    `counts` (n,) beside 0.
    """

    points: Floats
    normals: Floats
    heights: Floats
    counts: Ints


def _chosen(division: Division, layers: Layers | None) -> Bools:
    """Nodes whose facets on both sides are in the groups."""
    touched = np.zeros(len(division.nodes), dtype=np.int64)
    if layers is not None:
        facets = [division.groups[g] for g in sorted(layers.groups) if g in division.groups]
        if facets:
            np.add.at(touched, np.unique(np.concatenate(facets), axis=0), 1)
    return np.asarray(touched >= 2)


def _columns(
    division: Division, loop: Ints, chosen: Bools, field: SizeField, layers: Layers
) -> _Columns:
    points = division.nodes[loop]
    before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
    lengths = np.hypot(*before.T), np.hypot(*after.T)
    turn = np.arctan2(
        before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], np.sum(before * after, axis=1)
    )
    along = before / lengths[0][:, None] + after / lengths[1][:, None]
    normals = np.stack([-along[:, 1], along[:, 0]], axis=1)
    normals /= np.hypot(*normals.T)[:, None]
    open_ = chosen[loop] & (np.abs(turn) < TURN)
    facet = 0.5 * (lengths[0] + lengths[1])
    thick = _smooth(np.minimum(field.at(points), facet), open_)
    aspect = np.where(open_, facet / thick, 0.0)
    ratios = _ratios(points, normals, thick, aspect, field)
    counts = np.searchsorted(ratios, aspect / RATIO**0.5)
    counts = np.where(open_, np.maximum(counts, layers.rows), 0)
    ratios = np.concatenate([ratios, np.ones(max(0, layers.rows - len(ratios)))])
    heights = thick[:, None] * np.concatenate([[0.0], np.cumsum(ratios)])
    found = _Columns(points, normals, heights, _stairs(counts))
    return replace(found, counts=_with_room(found, division, field))


def _with_room(columns: _Columns, division: Division, field: SizeField) -> Ints:
    """Numbers of rows above which there is room for as many again, and more."""
    from contactfem.geometry.closest_point import (
        NearestFacets,  # scipy, not before a mesh is adapted
    )

    facets = np.concatenate([np.column_stack([k, np.roll(k, -1)]) for k in division.loops])
    boundary, counts = NearestFacets(division.nodes, facets), columns.counts
    while True:
        height = ROOM * columns.heights[np.arange(len(counts)), counts]
        above = columns.points + height[:, None] * columns.normals
        narrow = (counts > 0) & ~field.covers(above) | (boundary.closest(above)[2] < AWAY * height)
        if not np.any(narrow):
            return counts
        counts = _stairs(np.where(narrow, counts * 3 // 4, counts))


def _smooth(thick: Floats, open_: Bools) -> Floats:
    """Largest thicknesses below some that change by at most RATIO from a column to the next."""
    found, before = thick.copy(), thick[:0]
    while not np.array_equal(found, before):
        before = found.copy()
        for shift in (1, -1):
            found = np.minimum(found, RATIO * np.roll(found, shift))
    return np.where(open_, found, thick)


def _stairs(counts: Ints) -> Ints:
    """Largest numbers below some that differ by at most one from a column to the next."""
    found, before = counts.copy(), counts[:0]
    while not np.array_equal(found, before):
        before = found.copy()
        for shift in (1, -1):
            found = np.minimum(found, np.roll(found, shift) + 1)
    return found


def _ratios(
    points: Floats, normals: Floats, thick: Floats, aspect: Floats, field: SizeField
) -> Floats:
    """Thickness of every row over that of the first, ascending, the same in all columns."""
    ratios, height = [1.0], 1.0
    while ratios[-1] < aspect.max() and len(ratios) < MAX_ROWS:
        flat = aspect > ratios[-1]
        sizes = field.at(points[flat] + (height * thick[flat])[:, None] * normals[flat])
        wanted = float(np.quantile(sizes / thick[flat], SHARE))
        ratios.append(min(max(wanted, ratios[-1]), RATIO * ratios[-1]))
        height += ratios[-1]
    return np.array(ratios)


def _triangles(columns: _Columns, loop: Ints, first: int) -> tuple[Floats, Ints, Ints]:
    """Nodes of the rows, their triangles, and the loop above them.

    Args:
        columns: The columns.
        loop: Nodes below them.
        first: Number of the first new node.
    """
    counts, n = columns.counts, len(loop)
    start = first + np.concatenate([[0], np.cumsum(counts)[:-1]])

    def number(column: Ints, row: Ints) -> Ints:
        return np.where(row == 0, loop[column], start[column] + row - 1)

    column = np.repeat(np.arange(n), counts)
    row = np.arange(len(column)) - np.repeat(start - first, counts) + 1
    nodes = columns.points[column] + columns.heights[column, row][:, None] * columns.normals[column]
    after = (np.arange(n) + 1) % n
    both = np.minimum(counts, counts[after])
    a = np.repeat(np.arange(n), both)
    low = np.arange(len(a)) - np.repeat(np.cumsum(both) - both, both)
    b = after[a]
    lower = np.stack([number(a, low), number(b, low), number(b, low + 1)], axis=1)
    upper = np.stack([number(a, low), number(b, low + 1), number(a, low + 1)], axis=1)
    up, down = np.flatnonzero(counts[after] > counts), np.flatnonzero(counts[after] < counts)
    rising = [
        number(up, counts[up]),
        number(after[up], counts[up]),
        number(after[up], counts[up] + 1),
    ]
    low = counts[after[down]]
    falling = [number(down, low), number(after[down], low), number(down, low + 1)]
    cells = np.concatenate([lower, upper, np.stack(rising, axis=1), np.stack(falling, axis=1)])
    return nodes, cells, number(np.arange(n), counts)
