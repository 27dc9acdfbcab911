"""Areas, edges, triangles and sizes of cells."""

from __future__ import annotations

import numpy as np

from contactfem.common.typing import Floats, Ints

DENSITY = {3: 4.0 / np.sqrt(3.0), 4: 1.0}  # cells of size h in an area h², by their vertices


def triangles(cells: Ints) -> Ints:
    """Split plane cells into triangles.

    Args:
        cells: vertices (m, 3), or (m, 4) in tensor order.

    Returns:
        Vertices of the triangles (k, 3).
    """
    if cells.shape[1] == 3:
        return cells
    return np.concatenate([cells[:, [0, 1, 3]], cells[:, [0, 3, 2]]])


def cell_areas(points: Floats, cells: Ints) -> Floats:
    """Areas of plane cells: half the cross product of the diagonals.

    Args:
        points: vertices (n, 2) [m].
        cells: vertices (m, 3), or (m, 4) in tensor order.

    Returns:
        Areas (m,) [m²].
    """
    ring = [0, 1, 2, 2] if cells.shape[1] == 3 else [0, 1, 3, 2]
    a, b, c, d = (points[cells[:, i]] for i in ring)
    p, q = c - a, d - b
    area: Floats = 0.5 * np.abs(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])
    return area


def cell_edges(cells: Ints) -> tuple[Ints, Ints]:
    """Edges of plane cells, and which of them are on the boundary.

    Args:
        cells: vertices (m, 3), or (m, 4) in tensor order.

    Returns:
        All edges once (e, 2), and those of one cell only (b, 2).
    """
    ring = [0, 1, 2] if cells.shape[1] == 3 else [0, 1, 3, 2]
    pairs = np.concatenate(
        [cells[:, [a, b]] for a, b in zip(ring, ring[1:] + ring[:1], strict=True)]
    )
    edges, counts = np.unique(np.sort(pairs, axis=1), axis=0, return_counts=True)
    return edges, edges[counts == 1]


def cell_sizes(points: Floats, cells: Ints) -> Floats:
    """Sizes of cells.

    Args:
        points: Vertices of the mesh [m], shape (n, 2).
        cells: Triangles or quadrilaterals (in dolfinx's order), shape (m, 3 or 4).

    Returns:
        h [m], shape (m,).
    """
    return np.asarray(np.sqrt(DENSITY[cells.shape[1]] * cell_areas(points, cells)))


def thicknesses(points: Floats, cells: Ints) -> Floats:
    """Sizes of flat cells: edges of equilateral triangles, or of squares, that are as thick.

    Args:
        points: Vertices of the mesh [m], shape (n, 2).
        cells: Triangles or quadrilaterals (in dolfinx's order), shape (m, 3 or 4).

    Returns:
        h [m], shape (m,).
    """
    ring = cells if cells.shape[1] == 3 else cells[:, [0, 1, 3, 2]]
    edges = points[np.roll(ring, -1, axis=1)] - points[ring]
    longest = np.linalg.norm(edges, axis=2).max(axis=1)
    return np.asarray(DENSITY[cells.shape[1]] * cell_areas(points, cells) / longest)
