"""Matrix entries that contact may fill."""

from functools import cached_property

import numpy as np
import scipy.sparse as sp

from contactfem.common.typing import Bools, Ints
from contactfem.mechanics.bulk_system import System
from contactfem.mechanics.interface_nodes import InterfaceNodes

# By dimension: how many nodes along the nonmortar side may come into contact, and along the mortar
# side a node may slide over, in the same pattern
AHEAD_NONMORTAR = {2: 4, 3: 1}
AHEAD_MORTAR = {2: 8, 3: 2}
NORMAL_REACH = 3  # nodes along the nonmortar side that a condition's normals depend on


class Coupling:
    """Sticky sparsity pattern of one interface.

    Args:
        system: The system.
        nodes: The interface's nodes.
    """

    def __init__(self, system: System, nodes: InterfaceNodes) -> None:
        self._system, self._nodes = system, nodes
        mesh = nodes.mesh
        self._nonmortar = _adjacency(mesh.nonmortar, mesh.n_nonmortar)
        self._mortar = _adjacency(mesh.mortar, mesh.n_nodes)
        self._keys = np.empty(0, np.int64)
        self.wide = sp.csr_matrix((mesh.n_nonmortar, mesh.n_nodes), dtype=np.int32)

    def include(self, touched: sp.csr_matrix, active: Bools) -> bool:
        """Make room for the pairs of nonmortar nodes in contact and nodes that they touch.

        Args:
            touched: Entries of M and M⁰, (n_nonmortar, n_nodes).
            active: Nodes in contact, (n_nonmortar,).

        Returns:
            Whether the pattern had to grow.
        """
        place = touched.tocoo()
        at = active[place.row]
        keys = place.row[at].astype(np.int64) * touched.shape[1] + place.col[at]
        if np.isin(keys, self._keys, assume_unique=False).all():
            return False
        ones = np.ones(len(keys), np.int32)
        needed = sp.coo_matrix((ones, (place.row[at], place.col[at])), touched.shape).tocsr()
        mortar, nonmortar = self._mortar, self._nonmortar
        for _ in range(AHEAD_MORTAR[self._nodes.mesh.dim]):
            needed = _pattern(needed @ mortar)
        for _ in range(AHEAD_NONMORTAR[self._nodes.mesh.dim]):
            needed = _pattern(nonmortar @ needed)
        self.wide = _pattern(self.wide + needed)
        wide = self.wide.tocoo()
        self._keys = wide.row.astype(np.int64) * touched.shape[1] + wide.col
        return True

    def pattern(self) -> sp.csr_matrix:
        """Entries that contact may fill in this rank's rows, (n_local, n_global)."""
        rows, columns = self.reach()
        to_unknown = self._to_unknown()
        across = columns @ to_unknown + self._nonmortar @ self._bulk_columns
        return block_pattern(self._system, rows @ to_unknown, across)

    def reach(self) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """Nodes that forces of a multiplier act on, and that its condition and they depend on.

        Returns:
            Two patterns (n_nonmortar, n_nodes).
        """
        mesh = self._nodes.mesh
        used = sp.diags((np.diff(self.wide.indptr) > 0).astype(np.float64))
        own = sp.eye(mesh.n_nonmortar, mesh.n_nodes, dtype=np.int32, format="csr")
        reach = own
        for _ in range(NORMAL_REACH):
            reach = self._nonmortar @ reach
        return used @ (own + self.wide), reach + self._nonmortar @ self.wide

    def _to_unknown(self) -> sp.csr_matrix:
        """Nodes to their unknowns, (n_nodes, n_global)."""
        unknown = self._nodes.unknown
        node, component = np.nonzero(unknown >= 0)
        shape = (len(unknown), self._system.numbering.n_global)
        ones = np.ones(len(node), np.int32)
        return sp.coo_matrix((ones, (node, unknown[node, component])), shape).tocsr()

    @cached_property
    def _bulk_columns(self) -> sp.csr_matrix:
        """Columns of the bulk rows of every nonmortar node, on all ranks; collective."""
        n, pattern = self._system.numbering, self._system.pattern
        unknown = self._nodes.unknown[: self._nodes.mesh.n_nonmortar]
        node, component = np.nonzero((unknown >= n.first) & (unknown < n.first + n.n_local))
        rows = pattern[unknown[node, component] - n.first].tocoo()
        parts = self._system.comm.allgather((node[rows.row], rows.col))
        row, col = (np.concatenate(p) for p in zip(*parts, strict=True))
        shape = (len(unknown), n.n_global)
        return _pattern(sp.coo_matrix((np.ones(len(row), np.int32), (row, col)), shape).tocsr())


def block_pattern(system: System, rows: sp.csr_matrix, columns: sp.csr_matrix) -> sp.csr_matrix:
    """Places of blocks: each block has some rows and some columns.

    Args:
        system: The system.
        rows: Rows of each block, (blocks, n_global).
        columns: Columns of each block, (blocks, n_global).

    Returns:
        Pattern of this rank's rows, (n_local, n_global).
    """
    n = system.numbering
    places = _pattern(_pattern(rows).T @ _pattern(columns))
    return places[n.first : n.first + n.n_local]


def _adjacency(facets: Ints, n: int) -> sp.csr_matrix:
    """Nodes that share a facet, and each itself."""
    facet = np.repeat(np.arange(len(facets)), facets.shape[1])
    ones = np.ones(facets.size, np.int32)
    corners = sp.coo_matrix((ones, (facets.ravel(), facet)), (n, len(facets))).tocsr()
    return _pattern(corners @ corners.T + sp.eye(n, dtype=np.int32, format="csr"))


def _pattern(matrix: sp.csr_matrix) -> sp.csr_matrix:
    """The matrix with every stored entry one."""
    result = matrix.tocsr().astype(np.int32, copy=True)
    result.sum_duplicates()
    result.data[:] = 1
    return result
