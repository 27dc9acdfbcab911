"""Newton's matrix on the interface unknowns, dense."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from mpi4py import MPI

from contactfem.common.timers import Timers
from contactfem.common.typing import Bools, Floats, Ints
from contactfem.contact.state import ContactState
from contactfem.contact.tangent import linearise
from contactfem.mechanics.condensed import contact_rows, row_scales
from contactfem.mechanics.contact_equations import Interface
from contactfem.mortar.sparse import Sparse, Triplets, joined
from contactfem.solvers.dense_elimination import Elimination, SchurComplement, solve

MARGIN = 8  # nodes along a surface, beside those that contact touches, that it may touch next


def interface_unknowns(interfaces: Sequence[Interface]) -> Ints:
    """Unknowns of the nodes of some interfaces, ascending."""
    numbers = np.concatenate([i.nodes.unknown.ravel() for i in interfaces])
    return np.asarray(np.unique(numbers[numbers >= 0]))


@dataclass(frozen=True)
class _Transfer:
    """T: contact takes some rows of bulk forces away and moves shares of them to others.

    Attributes:
        taken: Rows that are taken away.
        rows: Rows that get shares.
        shares: Of all rows, (rows, left).
    """

    taken: Ints
    rows: Ints
    shares: sp.csr_matrix

    def __call__(self, forces: Floats) -> Floats:
        """T times rows of bulk forces, (left,) or (left, m)."""
        result = forces.copy()
        result[self.taken] = 0.0
        result[self.rows] += self.shares @ forces
        return result


@dataclass(frozen=True)
class InterfaceMatrix:
    """T S + C at one state of contact, on the unknowns that are not eliminated.

    Attributes:
        rest: Elimination of the others.
        transfer: T.
        values: The matrix, (left, left); `solve` factorises it in place.
    """

    rest: Elimination
    transfer: _Transfer
    values: Floats

    def solve(self, forces: Floats, right: Floats) -> Floats:
        """Solve (T S + C) x = T forces + right, once.

        Args:
            forces: Bulk forces, (n,).
            right: Residual with contact, (n,).

        Returns:
            x, (n,).

        Raises:
            LinAlgError: The matrix is singular.
        """
        inner = self.rest.condense(forces, forces + right)
        reduced = self.transfer(inner.left) + right[self.rest.left]
        return self.rest.expand(solve(self.values, reduced), inner)


class InterfaceSystem:
    """T S + C: the Schur complement of the bulk with the rows that contact moves and adds.

    Contact takes the rows of nonmortar nodes in contact away, T moves shares of them to others, and
    C is what positions do. Both are one and zero but for some unknowns, where contact is or was:
    the others are eliminated, once for many iterations.

    Args:
        interfaces: The interfaces.
        unknowns: Their unknowns, ascending.
        n_global: Number of all unknowns.
        timers: Where time is booked.
    """

    def __init__(
        self, interfaces: Sequence[Interface], unknowns: Ints, n_global: int, timers: Timers
    ) -> None:
        self._interfaces, self._timers, self._n = interfaces, timers, len(unknowns)
        self._comm = interfaces[0].nodes.comm
        place = np.full(n_global + 1, -1, np.int64)  # the last one stands for no unknown
        place[unknowns] = np.arange(self._n)
        self._place = place
        self._at = [place[i.nodes.unknown.ravel()] for i in interfaces]
        self._rest: Elimination | None = None

    def matrix(self, S: SchurComplement, states: Sequence[ContactState]) -> InterfaceMatrix:
        """The matrix at a state of contact; collective.

        Args:
            S: Schur complement on the unknowns.
            states: Of every interface.
        """
        with self._timers.book("contact.tangent"):
            tangents = [
                linearise(interface.contact, c, row_scales(interface, c))
                for interface, c in zip(self._interfaces, states, strict=True)
            ]
        with self._timers.book("contact.elimination"):
            taken, shares, added = [], [], []
            for k, interface in enumerate(self._interfaces):
                rows = contact_rows(interface, states[k], tangents[k])
                target, replaced = self._place[rows.targets], self._place[rows.replaced]
                taken.append(replaced)
                shares.append(_placed(rows.by_force, target, replaced))
                added.append(_placed(rows.by_position, target, self._at[k]))
            C = _of_all_ranks(self._comm, joined(added))
            return self._assembled(S, np.concatenate(taken), joined(shares), C)

    def _assembled(
        self, S: SchurComplement, taken: Ints, shares: Triplets, C: Triplets
    ) -> InterfaceMatrix:
        """The matrix on the unknowns that are left."""
        used = np.zeros(self._n, bool)
        for numbers in (taken, shares[0], C[0], C[1]):
            used[numbers] = True
        if self._rest is None or not self._rest.is_reusable(S, used):
            self._rest = Elimination(S, self._with_margin(used))
        number, left = self._rest.number, len(self._rest.left)
        row, column, value = shares
        rows, at = np.unique(number[row], return_inverse=True)
        moved = Sparse.of_triplets((at, number[column], value), (len(rows), left)).scipy()
        transfer = _Transfer(number[taken], np.asarray(rows), moved)
        matrix = transfer(self._rest.S)
        place = number[C[0]] * left + number[C[1]]
        matrix += np.bincount(place, C[2], left**2).reshape(left, left)
        return InterfaceMatrix(self._rest, transfer, matrix)

    def _with_margin(self, used: Bools) -> Ints:
        """Unknowns of the nodes that contact touches and of others beside them."""
        result = used.copy() if self._rest is None else used | (self._rest.number >= 0)
        for interface, at in zip(self._interfaces, self._at, strict=True):
            known = at >= 0
            touched = np.zeros(len(at), bool)
            touched[known] = result[at[known]]
            dim = interface.nodes.mesh.dim
            near: Bools = np.asarray(touched.reshape(-1, dim).any(axis=1))
            for facets in (interface.nodes.mesh.nonmortar, interface.nodes.mesh.mortar):
                for _ in range(MARGIN):
                    near[facets[near[facets].any(axis=1)]] = True
            result[at[known & np.repeat(near, dim)]] = True
        return np.flatnonzero(result)


def _placed(triplets: Triplets, rows: Ints, columns: Ints) -> Triplets:
    """Entries at some rows and columns; those with a negative one drop."""
    row, col = rows[triplets[0]], columns[triplets[1]]
    keep = (row >= 0) & (col >= 0)
    return row[keep], col[keep], triplets[2][keep]


def _of_all_ranks(comm: MPI.Comm, mine: Triplets) -> Triplets:
    """Entries of all ranks, one rank's after another's."""
    return mine if comm.size == 1 else joined(comm.allgather(mine))
