"""Mortar operators D, M and gap at one configuration, in any dimension.

What contact and mechanics ask of an interface, whatever its facets are: `mortar_operators` finds
them, `MortarOperators.derivative` says how they change. Only what is below this module, kernels and
geometry of facets, differs between surfaces in the plane and in space.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from mpi4py import MPI

from contactfem.common.typing import Bools, Floats, Ints
from contactfem.mortar.chains import cut_at_corners, folded, folded_entries, folded_normals
from contactfem.mortar.interface_mesh import (
    InterfaceMesh,
    facet_lengths,
    full_lengths,
    half_lengths,
)
from contactfem.mortar.normals import NormalField, nodal_normals
from contactfem.mortar.operators import D_ENTRY, GAP_ENTRY, Mortar, assemble
from contactfem.mortar.search_range import SearchRange
from contactfem.mortar.segments import Segments, differentiated, find_segments
from contactfem.mortar.sparse import Sparse, Triplets, joined


@dataclass(frozen=True)
class Weights:
    """Which sums of the operators are differentiated: dim rows for every nonmortar node j.

    They are D_j D_jj + gap_j g_j + jump_j v_j with the weighted jump v_j = Σ_l M_jl (x_l - x_j),
    which moves with the positions as well. Nodes that are not active have no weights.

    Attributes:
        active: Nodes in contact, (n,).
        D: Factors of D_jj, (n, dim).
        gap: Factors of the mean gap g_j, (n, dim).
        jump: Factors of v_j, (n, dim, dim).
        multiplier: λ_j [Pa] of the forces on the nodes, (n, dim).
    """

    active: Bools
    D: Floats
    gap: Floats
    jump: Floats
    multiplier: Floats


@dataclass(frozen=True)
class MortarOperators(ABC):
    """Mortar operators at one configuration, the same on all ranks.

    Always Σ_l M_jl = D_jj: nonmortar nodes without multiplier stand in M, with the sign of a mortar
    node, for the multipliers of the nodes beside them. So nodal forces (D_jj λ_j, -Σ_j M_jl λ_j)
    and weighted jumps Σ_l M_jl (x_l - x_j) are those of nodes with a multiplier alone.

    Attributes:
        mesh: The two surfaces.
        x: Positions [m], (n_nodes, dim).
        normals: Normal field of the nonmortar side.
        D: D_jj [m^(dim-1)], (n,); around an axis and in space all areas are in [m²].
        M: M_jl, likewise, (n, n_nodes).
        gap: Mean gap g_j [m], (n,); infinite where nothing is covered.
        full: D_jj of wholly covered facets, (n,).
        size: Size of the facets at each node [m], (n,): half their length in the plane.
    """

    mesh: InterfaceMesh
    x: Floats
    normals: NormalField
    D: Floats
    M: sp.csr_matrix
    gap: Floats
    full: Floats
    size: Floats

    @property
    def coverage(self) -> Floats:
        """Covered share f of each node's facets [-], (n,)."""
        return self.D / self.full

    @property
    def depth(self) -> Floats:
        """Area over size at each node, (n,).

        1 in the plane, about the circumference around an axis, the size itself in space [m].
        """
        return self.full / self.size

    @property
    @abstractmethod
    def full_derivative(self) -> Sparse:
        """D full / dx, (n, dim n_nodes); the same on all ranks."""

    @abstractmethod
    def derivative(self, weights: Weights) -> Sparse:
        """Derivatives by the positions, columns dim per node; the ranks' parts add up.

        Args:
            weights: Which sums.

        Returns:
            First the forces -Σ_j M_jl λ_j at fixed λ, dim rows per node (n_nodes); then the sums,
            dim rows per nonmortar node (n); then D_jj, one row per nonmortar node, of active ones.
        """


def mortar_operators(
    comm: MPI.Comm, mesh: InterfaceMesh, x: Floats, facets: Ints, reach: SearchRange
) -> MortarOperators:
    """Search, cut and integrate; collective.

    Args:
        comm: Ranks that share the work.
        mesh: The two surfaces.
        x: Positions [m], (n_nodes, dim).
        facets: This rank's nonmortar facets, (k,).
        reach: How far the sides look for each other.

    Returns:
        The operators.
    """
    surface = cut_at_corners(mesh, x, reach)
    own_x = x if surface.fold is None else x[surface.fold]
    normals, n = nodal_normals(surface, own_x), mesh.n_nonmortar
    segments = find_segments(surface, own_x, normals.n, facets, reach)
    mine = folded_entries(surface, mesh, assemble(surface, own_x, segments, normals))
    row, col, value = (
        np.concatenate(comm.allgather(part)) if comm.size > 1 else part
        for part in (mine.row, mine.col, mine.value)
    )
    D: Floats = np.bincount(row[col == D_ENTRY], value[col == D_ENTRY], n).astype(np.float64)
    weighted = np.bincount(row[col == GAP_ENTRY], value[col == GAP_ENTRY], n)
    at = col >= 0
    return LineOperators(
        mesh=mesh,
        x=x,
        normals=folded_normals(surface, mesh, normals),
        D=D,
        M=sp.coo_matrix((value[at], (row[at], col[at])), (n, mesh.n_nodes)).tocsr(),
        gap=np.divide(weighted, D, out=np.full(n, np.inf), where=D > 0.0),
        full=full_lengths(surface, own_x)[:n],
        size=half_lengths(surface, own_x)[:n],
        segments=segments,
        surface=surface,
        own_normals=normals,
    )


@dataclass(frozen=True)
class LineOperators(MortarOperators):
    """Mortar operators of surfaces in the plane.

    Attributes:
        segments: This rank's segments.
        surface: The interface cut at corners; `mesh` itself where none is cut.
        own_normals: Its normal field, that the segments were cut with.
    """

    segments: Segments
    surface: InterfaceMesh
    own_normals: NormalField

    @property
    def own_x(self) -> Floats:
        """Positions of the nodes of `surface` [m]."""
        return self.x if self.surface.fold is None else self.x[self.surface.fold]

    @cached_property
    def full_derivative(self) -> Sparse:
        """As said of every `MortarOperators`."""
        by_own, mesh = facet_lengths(self.surface, self.own_x)[1], self.mesh
        fold = self.surface.fold
        return by_own if fold is None else folded(fold, by_own, mesh.n_nonmortar, mesh.n_nodes)

    def derivative(self, weights: Weights) -> Sparse:
        """As said of every `MortarOperators`."""
        mesh = self.mesh
        entries = self._differentiated(weights.active)
        assert entries.derivative is not None
        sums = mesh.dim * mesh.n_nodes
        first = sums + mesh.dim * mesh.n_nonmortar
        height, is_D = first + mesh.n_nonmortar, np.flatnonzero(entries.col == D_ENTRY)
        parts = [
            *self._through_entries(weights, entries, sums),
            (first + entries.row[is_D], is_D, np.ones(len(is_D))),
        ]
        by_entries = Sparse.of_triplets(joined(parts), (height, len(entries.row)))
        total = [(by_entries @ entries.derivative).triplets()]
        total += self._by_reach(weights.jump, entries, sums)
        return Sparse.of_triplets(joined(total), (height, mesh.dim * mesh.n_nodes))

    def _differentiated(self, active: Bools) -> Mortar:
        """Differentiated operators of this rank's facets with an active node."""
        needed = np.asarray(active[self.mesh.nonmortar].any(axis=1))
        chosen = needed[self.segments.facets[:, 0]]
        surface, x, normals = self.surface, self.own_x, self.own_normals
        segments = differentiated(surface, x, normals.n, self.segments, chosen)
        return folded_entries(surface, self.mesh, assemble(surface, x, segments, normals))

    def _through_entries(self, weights: Weights, entries: Mortar, sums: int) -> list[Triplets]:
        """Derivative of forces and sums with respect to the entries of D, M and g."""
        j, col, dim = entries.row, entries.col, self.mesh.dim
        D = np.where(self.D > 0.0, self.D, 1.0)[:, None]
        gap = np.where(weights.active, self.gap, 0.0)[:, None]
        by_gap = weights.gap / D
        by_D = weights.D - by_gap * gap
        active = weights.active[j]
        e_D, e_gap, e_M = (
            np.flatnonzero(active & kind) for kind in (col == D_ENTRY, col == GAP_ENTRY, col >= 0)
        )
        turned: Bools = np.asarray(weights.jump.any(axis=(1, 2)))
        e_jump = e_M[turned[j[e_M]]]
        reach = self.x[col[e_jump]] - self.x[j[e_jump]]
        jump = np.einsum("eki,ei->ek", weights.jump[j[e_jump]], reach)
        return [
            on_vectors(sums, dim, j[e_D], e_D, by_D[j[e_D]]),
            on_vectors(sums, dim, j[e_gap], e_gap, by_gap[j[e_gap]]),
            on_vectors(sums, dim, j[e_jump], e_jump, jump),
            on_vectors(0, dim, col[e_M], e_M, -weights.multiplier[j[e_M]]),
        ]

    def _by_reach(self, factors: Floats, entries: Mortar, sums: int) -> list[Triplets]:
        """Σ_l M_jl (dx_l - dx_j) at fixed M, times factors, in the rows of the sums."""
        used: Bools = np.asarray(factors.any(axis=(1, 2)))
        at = np.flatnonzero((entries.col >= 0) & used[entries.row])
        j, node = entries.row[at], entries.col[at]
        blocks = entries.value[at, None, None] * factors[j]
        dim = self.mesh.dim
        return [on_blocks(sums, dim, j, node, blocks), on_blocks(sums, dim, j, j, -blocks)]


def on_vectors(first: int, dim: int, rows: Ints, columns: Ints, vectors: Floats) -> Triplets:
    """Entries of rows dim per node, from one number on, in one column each.

    Args:
        first: Number of the first row of node 0.
        dim: Rows per node.
        rows: Nodes, (k,).
        columns: Columns, (k,).
        vectors: Values, (k, dim).
    """
    at = first + dim * rows[:, None] + np.arange(dim)
    return at.ravel(), np.repeat(columns, dim), vectors.ravel()


def on_blocks(first: int, dim: int, rows: Ints, columns: Ints, blocks: Floats) -> Triplets:
    """Entries of rows and columns dim per node, the rows from one number on.

    Args:
        first: Number of the first row of node 0.
        dim: Rows per node.
        rows: Nodes of the rows, (k,).
        columns: Nodes of the columns, (k,).
        blocks: Values, (k, dim, width) with width = dim.
    """
    row = first + dim * rows[:, None, None] + np.arange(dim)[:, None]
    column = dim * columns[:, None, None] + np.arange(dim)
    shape = blocks.shape
    return (
        np.broadcast_to(row, shape).ravel(),
        np.broadcast_to(column, shape).ravel(),
        blocks.ravel(),
    )
