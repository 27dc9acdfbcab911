"""Lumped L2 projection between two meshes of a body."""

from math import factorial

import numpy as np
import scipy.sparse as sp

from mpi4py import MPI

from contactfem.common.block_csr import block_rows
from contactfem.common.typing import Floats
from contactfem.fem.body_mesh import BodyMesh
from contactfem.meshes.data import MeshData, jacobians
from contactfem.transfer.linear_map import LinearMap
from contactfem.transfer.matching import everywhere
from contactfem.transfer.point_location import cell_sizes
from contactfem.transfer.shape_functions import is_simplex, shape_functions
from contactfem.transfer.volume import VolumeTransfer, located

REFERENCE = {  # corners of the reference cells
    "triangle": [(0, 0), (1, 0), (0, 1)],
    "quadrilateral": [(0, 0), (1, 0), (0, 1), (1, 1)],
    "tetrahedron": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
    "hexahedron": [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)],
}


class LumpedProjection(LinearMap):
    """Interpolation, corrected by what the field has between the target's vertices.

    A linear interpolant of a bent field lies on one side of it: where meshes are replaced at every
    step, a layer of heat would grow thicker by that alone, and a layer that is thin against the
    target's cells would act as if it were as thick as they are. The defect θ - θ_h of the
    interpolant θ_h, sampled in the source's cells, is given to the target's vertices,
    θ_J + ∫ N_J (θ - θ_h) dX / ∫ N_J dX, which is the first step of the L² projection.

    Conserved are linear fields, to round-off, and ∫ θ dX but for the samples; not bounds.

    Attributes:
        vertices: The interpolation (29)-(31).
        matrix: (n_target, n_source).

    Args:
        comm: communicator.
        source: mesh that has the values.
        target: mesh of the same body that gets them.
        name: the body's name, for errors.

    Raises:
        MeshError: the meshes are not of the same body.
    """

    def __init__(self, comm: MPI.Comm, source: BodyMesh, target: BodyMesh, name: str) -> None:
        self.vertices = VolumeTransfer(comm, source, target, name)
        self.matrix = self.vertices.matrix
        if self.vertices.is_identity:
            return
        given, wanted = (everywhere(comm, body.data) for body in (source, target))
        at_samples, weights = _samples(given)
        points = at_samples @ given.points
        inward = np.repeat(given.points[given.cells].mean(axis=1), given.cells.shape[1], axis=0)
        size = np.repeat(cell_sizes(given.points, given.cells), given.cells.shape[1])
        shapes, _ = located(comm, wanted, points, inward, size, name)
        load = (sp.diags_array(weights) @ shapes).T.tocsr()
        lumped = np.asarray(load.sum(axis=1)).ravel()
        share = np.divide(1.0, lumped, out=np.zeros_like(lumped), where=lumped > 0.0)
        defect = at_samples - shapes @ self.matrix
        self.matrix = self.matrix + sp.diags_array(share) @ load @ defect


def _samples(mesh: MeshData) -> tuple[sp.csr_matrix, Floats]:
    """Values at a sample between each corner of a cell and its middle, and the volumes there.

    On triangles they are the three points that integrate quadratic functions exactly.
    """
    corners = np.array(REFERENCE[mesh.cell_type], dtype=float)
    simplex, (nv, dim) = is_simplex(mesh.cell_type), corners.shape
    values, _ = shape_functions(mesh.cell_type, 0.5 * (corners + corners.mean(axis=0)))
    blocks = np.broadcast_to(values.reshape(1, nv, nv), (len(mesh.cells), nv, nv))
    volume = np.abs(jacobians(mesh.points, mesh.cells, mesh.cell_type))
    volume = volume / factorial(dim) if simplex else volume @ values.T
    weights = np.broadcast_to(volume / nv, (len(mesh.cells), nv))
    at = block_rows(blocks, mesh.cells, len(mesh.points))
    return at, weights.ravel()
