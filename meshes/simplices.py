"""Split cells of several kinds into triangles or tetrahedra."""

import numpy as np

from contactfem.common.typing import Bools, Floats, Ints
from contactfem.meshes.raw import Kinds

# faces of solid cells, their corners around them
FACES: dict[str, tuple[tuple[int, ...], ...]] = {
    "tetra": ((0, 1, 2), (0, 1, 3), (1, 2, 3), (2, 0, 3)),
    "pyramid": ((0, 1, 2, 3), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
    "wedge": ((0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    "hexahedron": (
        (0, 1, 2, 3),
        (4, 5, 6, 7),
        (0, 1, 5, 4),
        (1, 2, 6, 5),
        (2, 3, 7, 6),
        (3, 0, 4, 7),
    ),
}


def triangles(cells: Kinds, points: Floats) -> Ints:
    """Triangles (k, 3) that fill plane cells.

    Quadrilaterals are split by the diagonal that leaves triangles, and the better ones.

    Args:
        cells: corners (m, nv) of triangles and quadrilaterals, around the cell.
        points: coordinates (n, 2).
    """
    parts = [rows for kind, rows in cells.items() if kind == "triangle"]
    if (quads := cells.get("quad")) is not None:
        ways = [quads[:, [[0, 1, 2], [0, 2, 3]]], quads[:, [[1, 2, 3], [1, 3, 0]]]]
        sense = np.sign(_areas(points, ways[0]).sum(axis=1, keepdims=True))
        first, second = (
            np.min(_areas(points, way) * sense, axis=1) / _squared(points, quads[:, ends])
            for way, ends in zip(ways, ([0, 2], [1, 3]), strict=True)
        )
        rising = first >= (1.0 - 1e-9) * second
        parts.append(np.where(rising[:, None, None], ways[0], ways[1]).reshape(-1, 3))
    found: Ints = np.concatenate(parts)
    filled: Ints = found[whole(found)]
    return filled


def tetrahedra(cells: Kinds) -> Ints:
    """Tetrahedra (k, 4) that fill solid cells, and fit each other at the cells' faces.

    A quadrilateral face is split from its vertex of the smallest number, a cell into cones from
    its own (Dompierre et al., How to subdivide pyramids, prisms and hexahedra into tetrahedra,
    1999).

    Args:
        cells: corners (m, nv) by kind.
    """
    parts = []
    for kind, rows in cells.items():
        top = rows.min(axis=1)
        for face in FACES[kind]:
            corners = rows[:, list(face)]
            away = (corners != top[:, None]).all(axis=1)
            base = split_faces(corners[away])
            share = len(base) // max(1, int(away.sum()))
            parts.append(np.column_stack([np.repeat(top[away], share), base]))
    found: Ints = np.concatenate(parts)
    filled: Ints = found[whole(found)]
    return filled


def split_faces(faces: Ints) -> Ints:
    """Triangles (k, 3) of faces (m, 3) or (m, 4), one face after the other."""
    if faces.shape[1] == 3:
        return faces
    first = faces.argmin(axis=1)
    turned: Ints = np.take_along_axis(faces, (first[:, None] + np.arange(4)) % 4, axis=1)
    halves: Ints = turned[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    return halves


def collapsed(rows: Ints) -> bool:
    """Whether some cells (m, nv) have a vertex twice."""
    return not bool(whole(rows).all())


def whole(rows: Ints) -> Bools:
    """Whether all vertices of each row (..., nv) differ."""
    ordered = np.sort(rows, axis=-1)
    differ: Bools = (ordered[..., 1:] != ordered[..., :-1]).all(axis=-1)
    return differ


def _areas(points: Floats, triangles: Ints) -> Floats:
    """Areas of triangles (..., 3), negative where they run clockwise."""
    a, b = (points[triangles[..., k]] - points[triangles[..., 0]] for k in (1, 2))
    areas: Floats = 0.5 * (a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
    return areas


def _squared(points: Floats, edges: Ints) -> Floats:
    """Squares of the lengths of edges (m, 2), above zero."""
    squared: Floats = (np.diff(points[edges], axis=1) ** 2).sum(axis=(1, 2))
    return np.maximum(squared, np.finfo(np.float64).tiny)
