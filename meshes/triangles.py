"""Surfaces of triangles from STL and other mesh files."""

from pathlib import Path

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.errors import MeshError

SAME = 1e-9  # distance of points that are one, relative to the size of the surface


def read_triangles(path: Path) -> tuple[Floats, Ints]:
    """Read a surface of triangles; points at one place become one.

    Args:
        path: The file, in any format that meshio reads.

    Returns:
        Points (n, 3) in the file's unit, and triangles (k, 3), turned as the file has them.

    Raises:
        MeshError: Not a mesh, or no triangles in it.
    """
    import meshio

    try:
        mesh = meshio.read(path)
    except (Exception, SystemExit) as error:  # meshio ends the process where it cannot read
        raise MeshError(f"{path}: not a surface that meshio reads: {error}") from None
    found = [np.asarray(block.data) for block in mesh.cells if block.type == "triangle"]
    found += [
        np.asarray(block.data)[:, corners]
        for block in mesh.cells
        if block.type == "quad"
        for corners in ([0, 1, 2], [0, 2, 3])
    ]
    if not found or mesh.points.shape[1] != 3:
        raise MeshError(f"{path}: has no triangles in space")
    triangles = np.concatenate(found).astype(np.int64)
    points = np.asarray(mesh.points, np.float64)
    size = float(np.ptp(points, axis=0).max())
    if not np.isfinite(size) or size == 0.0:
        raise MeshError(f"{path}: its points are not finite, or all at one place")
    places = np.round((points - points.min(axis=0)) / (SAME * size)).astype(np.int64)
    _, first, number = np.unique(places, axis=0, return_index=True, return_inverse=True)
    triangles = number.ravel()[triangles]
    a, b, c = (points[first][triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    kept = triangles[area > SAME**2 * size**2]
    if not len(kept):
        raise MeshError(f"{path}: all of its triangles are flat")
    return points[first], kept
