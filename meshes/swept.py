"""Cells swept from a plane mesh along a path of layers."""

from itertools import pairwise

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.geometry.cells import triangles
from contactfem.meshes.data import CellName, MeshData, mesh_data


def swept(
    plane: MeshData, layers: Floats, node: Ints, cell: CellName, ends: tuple[str, str] | None
) -> MeshData:
    """Solid mesh of a plane mesh that is swept through layers.

    Args:
        plane: The plane mesh, n points.
        layers: Points of every layer [m], (k + 1, n, 3).
        node: Number of the node at every point of every layer, (k + 1, n). Points that fall
            together (on an axis, or where the last layer is the first) have the same number.
        cell: Hexahedra, of quadrilaterals none of which touches an axis, or tetrahedra.
        ends: Names of the groups of the first and the last layer; None where it is closed.

    Returns:
        The mesh. Groups of the plane mesh become the surfaces that they sweep.
    """
    points = np.empty((int(node.max()) + 1, 3))
    points[node.ravel()] = layers.reshape(-1, 3)
    groups = {
        name: _facets(np.sort(facets, axis=1), node, cell) for name, facets in plane.groups.items()
    }
    if cell == "hexahedron":
        cells = np.concatenate(
            [np.hstack((a[plane.cells], b[plane.cells])) for a, b in _pairs(node)]
        )
        ring = plane.cells
    else:
        ring = np.sort(triangles(plane.cells), axis=1)
        cells = np.concatenate([_tetrahedra(ring, a, b) for a, b in _pairs(node)])
        cells = cells[_distinct(cells)]
    if ends is not None:
        groups |= {ends[0]: node[0][ring], ends[1]: node[-1][ring]}
    used = {name: facets for name, facets in groups.items() if len(facets)}
    return mesh_data(points, cells, cell, used)


def _pairs(node: Ints) -> list[tuple[Ints, Ints]]:
    return list(pairwise(node))


def _tetrahedra(ring: Ints, a: Ints, b: Ints) -> Ints:
    """Three tetrahedra per prism; diagonals start at the smaller plane vertex, so they match."""
    v0, v1, v2 = ring.T
    return np.concatenate(
        [
            np.column_stack((a[v0], a[v1], a[v2], b[v2])),
            np.column_stack((a[v0], a[v1], b[v1], b[v2])),
            np.column_stack((a[v0], b[v0], b[v1], b[v2])),
        ]
    )


def _facets(edges: Ints, node: Ints, cell: CellName) -> Ints:
    """Facets that plane facets (k, 2), the smaller vertex first, sweep."""
    v0, v1 = edges.T
    if cell == "hexahedron":
        return np.concatenate(
            [np.column_stack((a[v0], a[v1], b[v0], b[v1])) for a, b in _pairs(node)]
        )
    parts = []
    for a, b in _pairs(node):
        parts.append(np.column_stack((a[v0], a[v1], b[v1])))
        parts.append(np.column_stack((a[v0], b[v0], b[v1])))
    facets = np.concatenate(parts)
    return facets[_distinct(facets)]


def _distinct(rows: Ints) -> Ints:
    """Rows all of whose numbers differ: others have no volume or area."""
    ordered = np.sort(rows, axis=1)
    return np.flatnonzero((np.diff(ordered, axis=1) != 0).all(axis=1))
