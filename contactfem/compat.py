"""Differences between the supported dolfinx versions (0.9 to 0.11); no other module asks for them."""

import numpy as np
import numpy.typing as npt
import ufl
from dolfinx.mesh import GhostMode, Mesh, create_cell_partitioner
from dolfinx.mesh import create_mesh as _create_mesh
from mpi4py import MPI


def create_mesh(
    comm: MPI.Comm,
    cells: npt.NDArray[np.int64],
    points: npt.NDArray[np.float64],
    domain: ufl.Mesh,
) -> Mesh:
    """Mesh from every rank's share of cells and points; neighbours over shared facets are ghosts.

    Args:
        comm: communicator.
        cells: (m, nv) in dolfinx order, by global point number.
        points: (n, dim) [m].
        domain: coordinate element.

    Returns:
        The distributed mesh.
    """
    mode = GhostMode.shared_facet
    try:
        # Newer versions ask how many cells may meet in a facet: two, in a body.
        partitioner = create_cell_partitioner(mode, 2)
    except TypeError:
        partitioner = create_cell_partitioner(mode)
    # By name: the order of the arguments differs.
    return _create_mesh(comm, cells=cells, x=points, e=domain, partitioner=partitioner)
