"""A body's whole mesh and cell values on every rank."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mpi4py import MPI

from contactfem.common.typing import Floats, Ints
from contactfem.fem.body_mesh import BodyMesh
from contactfem.geometry.cells import cell_sizes
from contactfem.meshes.data import MeshData, boundary_facets


@dataclass(frozen=True)
class MeshView:
    """The mesh on all ranks.

    Attributes:
        mesh: Its distributed form.
        data: The mesh in input numbering.
    """

    mesh: BodyMesh
    data: MeshData

    @classmethod
    def of(cls, comm: MPI.Comm, mesh: BodyMesh) -> "MeshView":
        """View of a mesh that the first rank read; collective.

        Args:
            comm: All ranks.
            mesh: The mesh.
        """
        return cls(mesh, comm.bcast(mesh.data))

    @cached_property
    def boundary(self) -> Ints:
        """Boundary facets (k, 2), the body on their left."""
        return boundary_facets(self.data.cells, self.data.cell_type)

    @cached_property
    def sizes(self) -> Floats:
        """Sizes of the cells [m], (m,)."""
        return cell_sizes(self.data.points, self.data.cells)

    @cached_property
    def _mine(self) -> Ints:
        """Input numbers of this rank's owned cells."""
        topology = self.mesh.mesh.topology
        owned = topology.index_map(topology.dim).size_local
        return np.asarray(topology.original_cell_index[:owned], dtype=np.int64)

    def cells(self, values: Floats) -> Floats:
        """Values of all cells; collective.

        Args:
            values: Of this rank's cells, owned ones first, (local, ...).

        Returns:
            (m, ...) on all ranks.
        """
        whole = np.zeros((len(self.data.cells), *values.shape[1:]))
        whole[self._mine] = values[: len(self._mine)]
        self.mesh.mesh.comm.Allreduce(MPI.IN_PLACE, whole)
        return whole
