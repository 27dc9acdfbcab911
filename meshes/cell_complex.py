"""Check that the cells of a mesh fill a body once."""

from itertools import combinations

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.errors import MeshError
from contactfem.meshes.data import FACETS, CellName, MeshData, boundary_facets, numbered
from contactfem.meshes.raw import Kinds

MOST_NEAR = 200  # points at one place, on average, that are merged
SAME = 1e-7  # of the body's size: nodes this close are taken for one place
CLOSE = 1e-2  # and this of the shortest edge there


def distinct(cells: Kinds) -> tuple[Kinds, int]:
    """Cells by kind without those that are there already, and how many these were.

    Args:
        cells: corners (m, nv) by kind.
    """
    kept = {}
    for kind, rows in cells.items():
        first = np.unique(numbered(rows), return_index=True)[1]
        kept[kind] = rows[np.sort(first)]
    return kept, sum(map(len, cells.values())) - sum(map(len, kept.values()))


def merged(points: Floats, distance: float) -> Ints:
    """For every point the first of those that are one with it.

    Args:
        points: coordinates (n, dim) [m].
        distance: points this close are one, and so are those that chains of such join [m].

    Returns:
        Numbers of points (n,).

    Raises:
        MeshError: so many points are that close that it is the size of cells.
    """
    from scipy.spatial import KDTree

    tree = KDTree(points)
    if tree.count_neighbors(tree, distance) > MOST_NEAR * len(points):
        raise MeshError(f"merge = {distance:g} m is far larger than its cells")
    return _joined(len(points), tree.query_pairs(distance, output_type="ndarray"))


def _joined(count: int, pairs: Ints) -> Ints:
    """For every one of `count` points the first of those that pairs (k, 2) join with it (n,)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    edges = coo_array((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), (count, count))
    labels = connected_components(edges, directed=False)[1]
    first: Ints = np.unique(labels, return_index=True)[1][labels]
    return first


def check_complex(data: MeshData) -> tuple[str, ...]:
    """Make sure that cells lie side by side, and say what is doubtful about them.

    Args:
        data: the mesh.

    Returns:
        What is doubtful, a sentence each: nodes at one place, several pieces.

    Raises:
        MeshError: neighbours that overlap, or facets with more than two cells.
    """
    _check_facets(data)
    doubts = []
    places = coincident(data)
    if len(places):
        doubts.append(
            f"at {len(places)} places several nodes lie that are not one, the first at "
            f'{place(places[0])}: the body is open there; merge = "1e-6 mm" joins them'
        )
    if (count := pieces(data.points, data.cells)) > 1:
        doubts.append(f"in {count} pieces; 'body' takes one group of cells of a file")
    return tuple(doubts)


def coincident(data: MeshData) -> Floats:
    """Places (k, dim) [m] where boundary nodes lie on one another, beside the cells' edges."""
    from scipy.spatial import KDTree

    outer = np.unique(boundary_facets(data.cells, data.cell_type))
    tree = KDTree(data.points[outer])
    near = SAME * float(np.ptp(data.points, axis=0).max())
    distance, found = tree.query(
        data.points[outer], k=min(4, len(outer)), distance_upper_bound=near
    )
    own = np.broadcast_to(np.arange(len(outer))[:, None], found.shape)
    close = distance <= CLOSE * _shortest_edges(data)[outer, None]
    close &= found != own  # found is len(outer) where there is none so close
    pairs = np.stack([outer[own[close]], outer[found[close]]], axis=1)
    places: Floats = data.points[np.unique(_joined(len(data.points), pairs)[pairs[:, 0]])]
    return places


def _shortest_edges(data: MeshData) -> Floats:
    """Smallest distance [m] of every point to another one of its cells (n,)."""
    shortest = np.full(len(data.points), np.inf)
    for a, b in combinations(range(data.cells.shape[1]), 2):
        ends = data.cells[:, [a, b]]
        length = np.linalg.norm(np.diff(data.points[ends], axis=1)[:, 0], axis=1)
        for end in ends.T:
            np.minimum.at(shortest, end, length)
    return shortest


def pieces(points: Floats, cells: Ints) -> int:
    """Number of pieces of a mesh that share no node; nodes without cells do not count.

    Args:
        points: coordinates (n, dim) [m].
        cells: vertices (m, nv).
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    first, others = cells[:, :1], cells[:, 1:]
    ends = np.broadcast_to(first, others.shape).ravel(), others.ravel()
    count = len(points)
    edges = coo_array((np.ones(len(ends[0]), np.int8), ends), (count, count))
    labels = connected_components(edges, directed=False)[1]
    return len(np.unique(labels[cells]))


def place(x: Floats) -> str:
    """A point [m] in words."""
    return f"({', '.join(f'{value:.6g}' for value in x)}) m"


def _check_facets(data: MeshData) -> None:
    """Two cells on both sides of every inner facet, and not more.

    Raises:
        MeshError: there are more cells, or both on the same side.
    """
    facets = np.concatenate([data.cells[:, list(f)] for f in FACETS[data.cell_type]])
    number = numbered(facets)
    times = np.bincount(number)
    if (crowded := np.flatnonzero(times > 2)).size:
        first = facets[np.flatnonzero(number == crowded[0])[0]]
        raise MeshError(
            f"{len(crowded)} facets belong to more than two cells, the first near "
            f"{place(data.points[first].mean(axis=0))}"
        )
    sense = np.bincount(number, weights=_senses(facets, data.cell_type))
    overlaps = np.flatnonzero((times == 2) & (sense != 0.0))
    if len(overlaps):
        first = facets[np.flatnonzero(number == overlaps[0])[0]]
        raise MeshError(
            f"cells overlap near {place(data.points[first].mean(axis=0))}: at {len(overlaps)} "
            "facets both cells lie on the same side, as where a cell is folded over"
        )


def _senses(facets: Ints, cell_type: CellName) -> Floats:
    """1 or -1 (k,): in which of the two senses each facet runs around its vertices."""
    if facets.shape[1] == 2:
        return np.where(facets[:, 0] < facets[:, 1], 1.0, -1.0)
    around = facets[:, [0, 1, 3, 2]] if cell_type == "hexahedron" else facets
    count = around.shape[1]
    first = around.argmin(axis=1)
    after, before = (
        np.take_along_axis(around, ((first + step) % count)[:, None], axis=1)[:, 0]
        for step in (1, -1)
    )
    return np.where(after < before, 1.0, -1.0)
