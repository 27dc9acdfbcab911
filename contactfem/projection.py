"""Nodal values on the triangles of another mesh of a body, with their integrals kept locally."""

import numpy as np
import scipy.sparse as sp

from mpi4py import MPI

from contactfem.location import surroundings
from contactfem.meshes.data import Floats, Ints, MeshData, jacobians
from contactfem.meshing import BodyMesh
from contactfem.transfer import VolumeTransfer, everywhere, located


class Projection:
    """Interpolation, corrected by what the field has between the new vertices.

    A linear interpolant of a field that is bent lies on one side of it: where meshes are replaced
    at every step, a layer of heat would grow thicker by that alone. The defect d of the
    interpolant in the middles of the edges gives, by the rule that is exact for quadratic
    integrands, ∫ N_j (θ - θ_h) = Σ_K A_K/6 Σ_e d_e over the cells K and their edges e at j; with
    the lumped area Σ_K A_K/3 it is the first step of the L² projection.

    Attributes:
        vertices: The interpolation (29)-(31).

    Args:
        comm: communicator.
        source: mesh that has the values.
        target: mesh of the same body that gets them, of triangles.
        name: the body's name, for errors.

    Raises:
        MeshError: the meshes are not of the same body.
    """

    def __init__(self, comm: MPI.Comm, source: BodyMesh, target: BodyMesh, name: str) -> None:
        self.vertices = VolumeTransfer(comm, source, target, name)
        given, wanted = (everywhere(comm, body.data) for body in (source, target))
        self._edges, of_cell = _edges(wanted)
        inward, size = surroundings(wanted.points, wanted.cells)
        middle, inward, size = (
            0.5 * (part[self._edges[:, 0]] + part[self._edges[:, 1]])
            for part in (wanted.points, inward, size)
        )
        self._middles, _ = located(comm, given, middle, inward, size, name)
        self._spread = _spread(wanted, of_cell)

    def __call__(self, values: Floats) -> Floats:
        """Values at the target's vertices.

        Args:
            values: at the source's vertices, (n_source, c) or (n_source,).

        Returns:
            (n_target, c) or (n_target,).
        """
        found = self.vertices(values)
        defect = self._middles @ values - found[self._edges].mean(axis=1)
        return np.asarray(found + self._spread @ defect)


def _spread(mesh: MeshData, of_cell: Ints) -> sp.csr_matrix:
    """From defects in the middles of edges to corrections at vertices, by parts of areas."""
    area = 0.5 * np.abs(jacobians(mesh.points, mesh.cells, "triangle")[:, 0])
    lumped = np.bincount(mesh.cells.ravel(), np.repeat(area / 3.0, 3), len(mesh.points))
    ends = mesh.cells[:, [0, 1, 1, 2, 2, 0]]  # of edge k, from vertex k of a cell to the next one
    share = np.repeat(area / 6.0, 6) / lumped[ends.ravel()]
    places = (ends.ravel(), np.repeat(of_cell, 2, axis=1).ravel())
    return sp.coo_matrix((share, places), (len(mesh.points), of_cell.max() + 1)).tocsr()


def _edges(mesh: MeshData) -> tuple[Ints, Ints]:
    """Edges by their vertices (k, 2), and those of each triangle (m, 3)."""
    cells, n = mesh.cells, len(mesh.points)
    low, high = np.sort(cells[:, [[0, 1], [1, 2], [2, 0]]], axis=2).transpose(2, 0, 1)
    keys, number = np.unique(low.astype(np.int64) * n + high, return_inverse=True)
    return np.column_stack(np.divmod(keys, n)), number.reshape(cells.shape)
