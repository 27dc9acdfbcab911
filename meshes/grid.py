"""Meshes of a rectangular array of points."""

from typing import Literal

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.meshes.data import MeshData, mesh_data

Cell2D = Literal["quadrilateral", "triangle"]
Pattern = Literal["left", "right", "alternating", "crossed"]


def graded(n: int, ratio: float) -> Floats:
    """Nodes (n + 1,) in [0, 1] whose n intervals grow geometrically; ratio = last/first."""
    sizes = np.geomspace(1.0, ratio, n)
    nodes: Floats = np.concatenate([[0.0], np.cumsum(sizes)]) / np.sum(sizes)
    nodes[-1] = 1.0
    return nodes


def grid(points: Floats, cell: Cell2D, pattern: Pattern) -> MeshData:
    """Quadrilaterals or triangles between points of a rectangular array.

    Args:
        points: (ny + 1, nx + 1, 2) [m], x to the right along the second axis, y up along the first.
        cell: name of the cells.
        pattern: how triangles split a quadrilateral: by the diagonal that rises to the left or to
            the right, by both in turn, or by all four half diagonals.

    Returns:
        Mesh with the groups left, right, bottom, top.
    """
    rows, columns = points.shape[:2]
    number = np.arange(rows * columns, dtype=np.int64).reshape(rows, columns)
    quads = np.stack(
        [number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]], axis=-1
    ).reshape(-1, 4)
    sides = {"left": number[:, 0], "right": number[:, -1], "bottom": number[0], "top": number[-1]}
    groups = {name: np.stack([line[:-1], line[1:]], axis=1) for name, line in sides.items()}
    flat = points.reshape(-1, 2)
    if cell == "quadrilateral":
        return mesh_data(flat, quads, "quadrilateral", groups)
    if pattern == "crossed":
        centres = len(flat) + np.arange(len(quads))
        flat = np.concatenate([flat, flat[quads].mean(axis=1)])
        around = quads[:, [0, 1, 3, 2, 0]]
        cells = np.concatenate(
            [np.stack([around[:, k], around[:, k + 1], centres], axis=1) for k in range(4)]
        )
        return mesh_data(flat, cells, "triangle", groups)
    return mesh_data(flat, _split(quads, columns - 1, pattern), "triangle", groups)


def _split(quads: Ints, columns: int, pattern: Pattern) -> Ints:
    """Two triangles per quadrilateral; `columns` quadrilaterals stand in a row."""
    right = quads[:, [[0, 1, 3], [0, 3, 2]]]
    left = quads[:, [[0, 1, 2], [1, 3, 2]]]
    k = np.arange(len(quads))
    choose = {
        "right": np.ones(len(quads), dtype=bool),
        "left": np.zeros(len(quads), dtype=bool),
        "alternating": (k // columns + k % columns) % 2 == 0,
    }[pattern]
    return np.where(choose[:, None, None], right, left).reshape(-1, 3)
