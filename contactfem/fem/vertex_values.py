"""Vertex values of a distributed mesh, equal on all ranks."""

import numpy as np
from dolfinx.fem import FunctionSpace

from mpi4py import MPI

from contactfem.common.typing import Floats
from contactfem.fem.body_mesh import BodyMesh, dofs_at_vertices


class VertexValues:
    """Where a space keeps its values at the vertices of a body's mesh."""

    def __init__(self, comm: MPI.Comm, body: BodyMesh, V: FunctionSpace) -> None:
        """Find the unknowns at the vertices, once for all later calls.

        Args:
            comm: the communicator of the mesh.
            body: the mesh.
            V: scalar or vector space with unknowns at the vertices, or a subspace; unknowns
                elsewhere, such as bubbles, are passed over.
        """
        self._comm = comm
        self._n_points = body.n_points
        self._dofs, self._vertices = dofs_at_vertices(body.mesh, V)
        n_owned = V.dofmap.index_map.size_local * V.dofmap.index_map_bs
        owned = self._dofs[:, 0] < n_owned
        self._owned, self._mine = self._dofs[owned], self._vertices[owned]

    def replicate(self, values: Floats) -> Floats:
        """Values at all vertices, on all ranks; collective.

        Args:
            values: local scalar values, at least the owned ones, flat.

        Returns:
            (n_points, components).
        """
        result = np.zeros((self._n_points, self._dofs.shape[1]))
        result[self._mine] = np.asarray(values)[self._owned]
        self._comm.Allreduce(MPI.IN_PLACE, result)
        return result

    def insert(self, values: Floats, into: Floats) -> None:
        """Write values at all vertices to this rank's ones.

        Args:
            values: (n_points, components), the same on all ranks.
            into: local scalar values, owned and ghost, flat; other unknowns are left alone.
        """
        into[self._dofs] = values[self._vertices]


def replicate(comm: MPI.Comm, body: BodyMesh, V: FunctionSpace, values: Floats) -> Floats:
    """`VertexValues.replicate` for once."""
    return VertexValues(comm, body, V).replicate(values)


def insert(body: BodyMesh, V: FunctionSpace, values: Floats, into: Floats) -> None:
    """`VertexValues.insert` for once."""
    VertexValues(body.mesh.comm, body, V).insert(values, into)
