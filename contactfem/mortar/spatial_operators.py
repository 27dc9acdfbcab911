"""Mortar operators of an interface in space, with gap and jumps (2)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from mpi4py import MPI

from contactfem.common.typing import Bools, Floats, Ints
from contactfem.mortar.facet_areas import full_areas, full_areas_derivative
from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.mortar_operators import MortarOperators, Weights, on_blocks, on_vectors
from contactfem.mortar.normals import nodal_normals
from contactfem.mortar.polygon_operators import (
    assemble_polygons,
    covered,
    differentiate_polygons,
)
from contactfem.mortar.polygons import Polygons, find_facet_pairs, intersect
from contactfem.mortar.sparse import Sparse, Triplets, joined


def spatial_operators(
    comm: MPI.Comm, mesh: InterfaceMesh, x: Floats, facets: Ints, radius: float
) -> MortarOperators:
    """Search, intersect and integrate; collective.

    Args:
        comm: Ranks that share the work.
        mesh: The two surfaces.
        x: Positions [m], (n_nodes, 3).
        facets: This rank's nonmortar facets, (k,).
        radius: Search radius [m].

    Returns:
        The operators.
    """
    n, x = mesh.n_nonmortar, np.ascontiguousarray(x)
    polygons = covered(mesh, x, intersect(mesh, x, find_facet_pairs(mesh, x, facets, radius)))
    mine = assemble_polygons(mesh, polygons)
    node, area, row, column, value = (
        np.concatenate(comm.allgather(part)) if comm.size > 1 else part
        for part in (*mine.D, *mine.M)
    )
    D = np.bincount(node, area, n).astype(np.float64)
    M = sp.coo_matrix((value, (row, column)), (n, mesh.n_nodes)).tocsr()
    D, M = without_multiplier(mesh, D, M)
    normals, full = nodal_normals(mesh, x), full_areas(mesh, x)
    v = jumps(x, M)
    across = np.einsum("ji,ji->j", normals.n, v)
    return SpatialOperators(
        mesh=mesh,
        x=x,
        normals=normals,
        D=D,
        M=M,
        gap=np.divide(across, D, out=np.full(n, np.inf), where=D > 0.0),
        full=full,
        size=np.sqrt(full),
        polygons=polygons,
        jump=v,
        mine=np.arange(n) % comm.size == comm.rank,
    )


def without_multiplier(
    mesh: InterfaceMesh, D: Floats, M: sp.csr_matrix
) -> tuple[Floats, sp.csr_matrix]:
    """D and M of the nodes that have a multiplier, with the others' multipliers from these.

    λ_o = Σ_k E_ok λ_k acts on the mortar side through M_ol, and on o itself with D_oo, which stands
    in M with the sign of a mortar entry: Eᵀ M - E_ok D_oo. So Σ_l M_kl = D_kk as before.

    Args:
        mesh: The interface.
        D: Of all nonmortar nodes [m²], (n,).
        M: Likewise, (n, n_nodes).
    """
    if mesh.has_multiplier.all():
        return D, M
    E = mesh.extension.tocoo()
    other = E.row != E.col
    o, k = E.row[other], E.col[other]
    own = sp.coo_matrix((-E.data[other] * D[o], (k, o)), M.shape)
    total = sp.csr_matrix(mesh.extension.T @ M + own)
    total.eliminate_zeros()
    return np.where(mesh.has_multiplier, D, 0.0), total


def jumps(x: Floats, M: sp.csr_matrix) -> Floats:
    """Weighted jumps v_j = Σ_l M_jl (x_l - x_j), which do not see the origin [m³], (n, 3)."""
    rows, columns, values = Sparse.of(M).triplets()
    parts: Floats = (values[:, None] * (x[columns] - x[rows])).T
    return np.column_stack([np.bincount(rows, part, M.shape[0]) for part in parts])


@dataclass(frozen=True)
class SpatialOperators(MortarOperators):
    """Mortar operators of surfaces in space.

    Attributes:
        polygons: This rank's polygons.
        jump: v_j = Σ_l M_jl (x_l - x_j) [m³], (n, 3).
        mine: Nonmortar nodes whose normals this rank differentiates, (n,).
    """

    polygons: Polygons
    jump: Floats
    mine: Bools

    @cached_property
    def full_derivative(self) -> Sparse:
        """As said of every `MortarOperators`."""
        return full_areas_derivative(self.mesh, self.x)

    def derivative(self, weights: Weights) -> Sparse:
        """As said of every `MortarOperators`."""
        mesh, E = self.mesh, self.mesh.extension
        n, n_nodes = mesh.n_nonmortar, mesh.n_nodes
        sums, height = 3 * n_nodes, 3 * n_nodes + 4 * n
        multiplier = np.ascontiguousarray(E @ weights.multiplier)
        found = differentiate_polygons(mesh, self.x, self._chosen(weights.active), multiplier)
        D = np.where(self.D > 0.0, self.D, 1.0)[:, None]
        by_gap = np.where(weights.active[:, None], weights.gap, 0.0) / D
        gap = np.where(weights.active, self.gap, 0.0)[:, None]
        by_jump = weights.jump + np.einsum("ji,jk->jik", by_gap, self.normals.n)
        j = np.flatnonzero(weights.active)
        parts = [
            on_vectors(sums, 3, j, j, (weights.D - by_gap * gap)[j]),
            (sums + 3 * n + j, j, np.ones(len(j))),
            *self._by_jump(by_jump * weights.active[:, None, None], sums),
            *self._by_force(multiplier),
        ]
        by = Sparse.of_triplets(joined(parts), (height, found.rows.height))
        total = [(by @ found.rows).triplets(), self._by_normals(by_gap, sums)]
        return Sparse.of_triplets(joined(total), (height, 3 * n_nodes))

    def _chosen(self, active: Bools) -> Polygons:
        """Polygons of facets whose operators make any difference to active nodes."""
        needed = active | (self.mesh.extension @ active.astype(float) > 0.0)
        facets = np.asarray(needed[self.mesh.nonmortar].any(axis=1))
        return self.polygons.part(facets[self.polygons.facets[:, 0]])

    def _by_jump(self, factors: Floats, sums: int) -> list[Triplets]:
        """Derivative of the sums by the jumps of all nodes: those of k are Σ_j E_jk v_j."""
        E = self.mesh.extension.tocoo()
        at = np.asarray(factors.any(axis=(1, 2)))[E.col]
        j, k = E.row[at].astype(np.int64), E.col[at].astype(np.int64)
        rows, columns, values = on_blocks(sums, 3, k, j, E.data[at, None, None] * factors[k])
        return [(rows, self.mesh.n_nonmortar + columns, values)]

    def _by_force(self, multiplier: Floats) -> list[Triplets]:
        """Derivative of the forces: of the mortar part, and of D_oo λ_o without a multiplier."""
        n, each = self.mesh.n_nonmortar, np.arange(3 * self.mesh.n_nodes)
        o = np.flatnonzero(~self.mesh.has_multiplier & multiplier.any(axis=1))
        return [
            (each, 4 * n + each, -np.ones(len(each))),
            on_vectors(0, 3, o, o, multiplier[o]),
        ]

    def _by_normals(self, by_gap: Floats, sums: int) -> Triplets:
        """Derivative of the sums through the normals of gaps, dg_j = v_j·dn_j / D_jj."""
        normals = self.normals
        j = np.flatnonzero(self.mine & by_gap.any(axis=1))
        width = normals.around.shape[1]
        turned = np.einsum("ji,jiwc->jwc", self.jump[j], normals.blocks[j])
        values = by_gap[j][:, :, None, None] * turned[:, None]
        rows = sums + 3 * j[:, None, None, None] + np.arange(3)[:, None, None]
        columns = 3 * normals.around[j][:, None, :, None] + np.arange(3)
        shape = (len(j), 3, width, 3)
        return (
            np.broadcast_to(rows, shape).ravel(),
            np.broadcast_to(columns, shape).ravel(),
            values.ravel(),
        )
