"""Nodal values from one mesh of a body to another (29).

Values are replicated: each rank holds those of all vertices, in input numbering, and the same
matrices, so that to apply one takes no communication.
"""

import numpy as np
import scipy.sparse as sp

from mpi4py import MPI

from contactfem.common.block_csr import block_rows
from contactfem.common.typing import Floats
from contactfem.fem.body_mesh import BodyMesh
from contactfem.meshes.data import MeshData
from contactfem.transfer.linear_map import LinearMap
from contactfem.transfer.matching import check_near, everywhere, identity, same_mesh
from contactfem.transfer.point_location import Location, cell_sizes, surroundings


class VolumeTransfer(LinearMap):
    """Nodal interpolation of a field in a body, Φ_K = Σ N_I(X_K) Φ_I (29)-(31).

    Vertices outside of the source mesh, on curved boundaries, take the field of the nearest cell,
    continued by its gradient. Conserved are linear fields, to round-off; bounds, but at these
    vertices; not integrals, which change by the error of interpolation, of second order.

    Attributes:
        matrix: (n_target, n_source), with rows of the sum 1.
        farthest: Largest distance of a target vertex outside of the source mesh [m].
        is_identity: Whether the meshes are the same.
    """

    matrix: sp.csr_matrix
    farthest: float
    is_identity: bool = False

    def __init__(self, comm: MPI.Comm, source: BodyMesh, target: BodyMesh, name: str) -> None:
        """Build the matrix; collective, and the ranks share the search.

        A vertex on a slit of no width takes the value of its own lip. A slit that is curved has to
        be wide enough for the facets of both meshes.

        Args:
            comm: communicator.
            source: mesh that has the values.
            target: mesh of the same body that gets them.
            name: the body's name, for errors.

        Raises:
            MeshError: a vertex lies farther outside of the source mesh than half a cell, the
                larger of those around it and the nearest one of the source.
        """
        given, wanted = (everywhere(comm, body.data) for body in (source, target))
        if same_mesh(given.points, given.cells, wanted.points, wanted.cells):
            self.matrix, self.farthest = identity(len(given.points)), 0.0
            self.is_identity = True
            return
        inward, size = surroundings(wanted.points, wanted.cells)
        self.matrix, distance = located(comm, given, wanted.points, inward, size, name)
        self.farthest = float(distance.max())


def located(
    comm: MPI.Comm, given: MeshData, points: Floats, inward: Floats, size: Floats, name: str
) -> tuple[sp.csr_matrix, Floats]:
    """Interpolation of a mesh at points; collective, and the ranks share the search.

    Args:
        comm: communicator.
        given: the mesh, on all ranks.
        points: where its field is wanted [m], (n, dim).
        inward: points on their side of a slit [m], (n, dim).
        size: lengths of which half is the largest distance allowed [m], (n,).
        name: the body's name, for errors.

    Returns:
        The matrix (n, n_given), and how far the points lie outside [m], (n,).

    Raises:
        MeshError: a point lies too far outside.
    """
    first, last = (len(points) * (comm.rank + k) // comm.size for k in (0, 1))
    mine = Location(given).places(points[first:last], inward[first:last])
    parts = comm.allgather((mine.cells, mine.weights, mine.distance))
    cells, weights, distance = (np.concatenate(part) for part in zip(*parts, strict=True))
    larger = np.maximum(size, cell_sizes(given.points, given.cells)[cells])
    check_near(name, points, distance, larger)
    return block_rows(weights[:, None], given.cells[cells], len(given.points)), distance
