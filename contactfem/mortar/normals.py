"""Nodal normals of the nonmortar surface and their derivative (1)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from contactfem.common.block_csr import block_rows
from contactfem.common.typing import Floats, Ints
from contactfem.mortar.interface_mesh import InterfaceMesh, averaged_normals
from contactfem.mortar.spatial_normals import averaged_normals as spatial_normals


@dataclass(frozen=True)
class NormalField:
    """Nodal unit normals of the nonmortar surface and their derivative.

    Attributes:
        n: Unit normals, outward from nonmortar [-], shape (n_nonmortar, dim).
        around: Nodes that each depends on, (n_nonmortar, w): in the plane the previous node, the
            node itself and the next, itself at an end; in space the node itself and its neighbours.
            A node may stand there twice.
        blocks: Derivatives with respect to their positions [1/m], (n_nonmortar, dim, w, dim).
        n_nodes: Nodes of both surfaces.
    """

    n: Floats
    around: Ints
    blocks: Floats
    n_nodes: int

    @cached_property
    def derivative(self) -> sp.csr_matrix:
        """dn/dx [1/m], shape (dim n_nonmortar, dim n_nodes)."""
        dim, width = self.n.shape[1], self.around.shape[1]
        blocks = self.blocks.reshape(-1, dim, width * dim)
        return block_rows(blocks, self.around, dim * self.n_nodes)


def nodal_normals(mesh: InterfaceMesh, x: Floats) -> NormalField:
    """Averaged nodal normals, n_j = Σ n_f / |Σ n_f| over the facets at j, with derivative.

    Where the mortar side is rigid and gives the direction of contact, that one instead: the last
    facet of an end that lifts off leans, and with averaged normals the force on it would, too.

    A node that is held in one direction (a symmetry line) has its normal in the other one: the
    mirrored facet would average it so, and contact can only act there.

    Args:
        mesh: The interface.
        x: Current positions [m], shape (n_nodes, dim).

    Returns:
        The normal field.
    """
    if mesh.dim == 3:
        return _spatial_field(mesh, x)
    n, blocks = _averaged_field(mesh, x) if mesh.directions is None else _given_field(mesh, x)
    free = mesh.free[: mesh.n_nonmortar]
    held = mesh.has_multiplier & ~free.all(1)
    n[held] = np.where(free[held], np.sign(n[held]) + (n[held] == 0.0), 0.0)
    blocks[held] = 0.0
    around = np.repeat(np.arange(mesh.n_nonmortar)[:, None], 3, axis=1)
    around[mesh.nonmortar[:, 1], 0], around[mesh.nonmortar[:, 0], 2] = mesh.nonmortar.T
    return NormalField(n, around, blocks, mesh.n_nodes)


def _spatial_field(mesh: InterfaceMesh, x: Floats) -> NormalField:
    """As `nodal_normals` of a surface in space."""
    free, own = mesh.free[: mesh.n_nonmortar], np.arange(mesh.n_nonmortar)
    free = free | ~mesh.has_multiplier[:, None]
    n, blocks, _ = spatial_normals(mesh.nonmortar, x, free, mesh.neighbours)
    sides = np.where(mesh.neighbours < 0, own[:, None], mesh.neighbours)
    return NormalField(n, np.column_stack((own, sides)), blocks, mesh.n_nodes)


def _averaged_field(mesh: InterfaceMesh, x: Floats) -> tuple[Floats, Floats]:
    """Averaged normals (n, 2) and their derivative by previous, own and next node, (n, 2, 3, 2)."""
    n, length = averaged_normals(mesh, x)
    ends = mesh.nonmortar
    edge = x[ends[:, 1]] - x[ends[:, 0]]
    size = np.hypot(edge[:, 0], edge[:, 1])
    t = edge / size[:, None]
    nf = np.column_stack((t[:, 1], -t[:, 0]))
    # d n_f = -n_f-component of the edge's turn: (1/L) (t (n_f . d edge)) with the sign of (dy, -dx)
    turn = -np.einsum("fi,fj->fij", t, nf) / size[:, None, None]
    project = (np.eye(2) - np.einsum("ji,jk->jik", n, n)) / length[:, None, None]
    blocks = np.zeros((mesh.n_nonmortar, 2, 3, 2))
    for end, before, after in ((0, 1, 2), (1, 0, 1)):  # a has the facet after it, b before it
        block = project[ends[:, end]] @ turn
        blocks[ends[:, end], :, before] -= block
        blocks[ends[:, end], :, after] += block
    return n, blocks


def _given_field(mesh: InterfaceMesh, x: Floats) -> tuple[Floats, Floats]:
    """As `_averaged_field`, of normals that a rigid mortar side gives."""
    assert mesh.directions is not None
    n, by_own = mesh.directions(mesh, x)
    blocks = np.zeros((mesh.n_nonmortar, 2, 3, 2))
    blocks[:, :, 1] = by_own
    return n, blocks


def line_tangents(normals: Floats) -> Floats:
    """Unit tangents τ = (n_y, -n_x) of a surface in the plane, (n, 2).

    Traction and slip are vectors; tables of plane interfaces give them a sign along τ.

    Args:
        normals: Unit normals, (n, 2).
    """
    return np.column_stack((normals[:, 1], -normals[:, 0]))
