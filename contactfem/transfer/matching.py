"""Whether two meshes are the same or near each other."""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from mpi4py import MPI

from contactfem.common.typing import Floats, Ints
from contactfem.errors import MeshError
from contactfem.meshes.data import MeshData

FAR = 0.5  # of the larger one of the cells: how far outside of the source a vertex may lie


def check_near(name: str, points: Floats, distance: Floats, size: Floats) -> None:
    """Raise an error if points are too far outside of the source, naming the worst one."""
    far = distance > FAR * size
    if far.any():
        worst = np.argmax(np.where(far, distance, 0.0))
        raise MeshError(
            f"'{name}' differs between its meshes: {far.sum()} of {len(points)} points of one "
            f"are not on the other, the farthest at {points[worst]} m lies {distance[worst]:.3g} m "
            f"away, with cells of {size[worst]:.3g} m there; allowed is {FAR} of a cell"
        )


def everywhere(comm: MPI.Comm, data: MeshData | None) -> MeshData:
    """Points and cells of the first rank's mesh, on all ranks."""
    bare: MeshData = comm.bcast(None if data is None else replace(data, groups={}))
    return bare


def same_mesh(X: Floats, cells: Ints, other_X: Floats, other_cells: Ints) -> bool:
    """Whether two meshes have the same vertices and cells in the same order."""
    return np.array_equal(X, other_X) and np.array_equal(cells, other_cells)


def identity(n: int) -> sp.csr_matrix:
    """The matrix of a transfer between equal meshes."""
    return sp.identity(n, format="csr")
