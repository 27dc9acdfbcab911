"""Smooth boundary curves through the nodes of a mesh."""

from itertools import pairwise

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.errors import MeshError
from contactfem.meshes.curves import Boundary, Curve, Loop, Parametric, enclosed, line
from contactfem.meshes.data import MeshData, boundary_facets, matches

CORNER = np.deg2rad(30.0)  # a boundary that turns by more at a node has a corner there
WRAP = 3  # nodes beyond its joint that shape a closed curve


def reconstructed(data: MeshData) -> Boundary:
    """Curves through the boundary nodes of a plane mesh.

    They end where groups change and where the boundary turns by more than 30 degrees; in between
    they are Akima's splines over arc length, straight wherever nodes are in line.

    Args:
        data: the mesh.

    Returns:
        The outer loop, then the holes.

    Raises:
        MeshError: the mesh is solid, in several pieces, or its boundary touches itself at a node.
    """
    if data.points.shape[1] != 2:
        raise MeshError("only plane meshes can be adapted, this one is solid")
    facets = boundary_facets(data.cells, data.cell_type)
    start, count = np.unique(facets[:, 0], return_counts=True)
    if np.any(count > 1):
        x, y = data.points[start[np.argmax(count)]]
        raise MeshError(f"cannot be adapted: its boundary touches itself at ({x:g}, {y:g}) m")
    names = _names(data, facets)
    walks = _walks(facets)
    outer = [enclosed(data.points[facets[walk, 0]]) > 0.0 for walk in walks]
    if sum(outer) != 1:
        raise MeshError(f"cannot be adapted: it is in {sum(outer)} pieces")
    walks.insert(0, walks.pop(outer.index(True)))
    return tuple(_loop(data.points[facets[walk, 0]], [names[k] for k in walk]) for walk in walks)


def _names(data: MeshData, facets: Ints) -> list[tuple[str, ...]]:
    """Groups that each facet belongs to."""
    names: list[list[str]] = [[] for _ in facets]
    for name, group in data.groups.items():
        for k in matches(group, facets) if len(group) else []:
            names[k].append(name)
    return [tuple(each) for each in names]


def _walks(facets: Ints) -> list[Ints]:
    """Closed chains of facets: their places in the order of a walk."""
    leaving = {int(a): k for k, a in enumerate(facets[:, 0])}
    walks, seen = [], np.zeros(len(facets), dtype=bool)
    for first in range(len(facets)):
        walk, k = [], first
        while not seen[k]:
            seen[k] = True
            walk.append(k)
            k = leaving[int(facets[k, 1])]
        if walk:
            walks.append(np.array(walk, dtype=np.int64))
    return walks


def _loop(x: Floats, names: list[tuple[str, ...]]) -> Loop:
    """Curves of a closed polygon (k, 2) whose facet k leads away from corner k."""
    (ax, ay), (bx, by) = (x - np.roll(x, 1, axis=0)).T, (np.roll(x, -1, axis=0) - x).T
    turn = np.abs(np.arctan2(ax * by - ay * bx, ax * bx + ay * by))
    changed = [names[k - 1] != names[k] for k in range(len(names))]
    ends = np.flatnonzero((turn > CORNER) | changed)
    if not len(ends):
        return (_closed(x, names[0]),)
    first = int(ends[0])
    x, names = np.roll(x, -first, axis=0), names[first:] + names[:first]
    x, ends = np.concatenate([x, x[:1]]), np.append(ends - first, len(x))
    return tuple(_open(x[a : b + 1], names[a]) for a, b in pairwise(ends))


def _open(x: Floats, names: tuple[str, ...]) -> Curve:
    """Curve through nodes (k, 2) from the first to the last."""
    if len(x) == 2:
        return line(x, names)
    return _spline(x, 0, names)


def _closed(x: Floats, names: tuple[str, ...]) -> Curve:
    """Closed curve through nodes (k, 2), as smooth at its joint as elsewhere."""
    wrap = np.arange(-WRAP, len(x) + 1 + WRAP) % len(x)
    return _spline(x[wrap], WRAP, names)


def _spline(x: Floats, beyond: int, names: tuple[str, ...]) -> Curve:
    """Akima's spline over arc length through nodes (k, 2), without `beyond` nodes at either end."""
    from scipy.interpolate import Akima1DInterpolator

    t = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(x, axis=0).T))])
    t = (t - t[beyond]) / (t[len(t) - 1 - beyond] - t[beyond])
    knots = t[beyond : len(t) - beyond]
    between = 0.5 * (knots[:-1] + knots[1:])
    return Parametric(Akima1DInterpolator(t, x), np.union1d(knots, between), names)
