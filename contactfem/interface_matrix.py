"""Newton's matrix on the unknowns of the interfaces alone, dense; on one rank."""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from contactfem.condensed import Interface, contact_rows
from contactfem.contact import Conditions
from contactfem.surfaces import Floats, Ints
from contactfem.tangent import linearise
from contactfem.timers import Timers


def interface_unknowns(interfaces: Sequence[Interface]) -> Ints:
    """Unknowns of the nodes of some interfaces, ascending."""
    numbers = np.concatenate([i.nodes.unknown.ravel() for i in interfaces])
    return np.asarray(np.unique(numbers[numbers >= 0]))


class InterfaceMatrix:
    """T S + C: the Schur complement of the bulk with the rows that contact moves and adds.

    Contact takes the rows of nonmortar nodes in contact away, T moves shares of them to others, and
    C is what positions do. T works on any rows of bulk forces.

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
        place = np.full(n_global + 1, -1, np.int64)  # the last one stands for no unknown
        place[unknowns] = np.arange(self._n)
        self._place = place
        self._at = [place[i.nodes.unknown.ravel()] for i in interfaces]

    def fill(self, S: Floats, conditions: Sequence[Conditions]) -> None:
        """Take the contact of a state.

        Args:
            S: Schur complement on the unknowns, (n, n).
            conditions: Of every interface.
        """
        with self._timers.book("contact.tangent"):
            tangents = [
                linearise(interface.contact, c)
                for interface, c in zip(self._interfaces, conditions, strict=True)
            ]
        with self._timers.book("contact.elimination"):
            taken, shares, added = [], [], []
            for k, interface in enumerate(self._interfaces):
                rows = contact_rows(interface, conditions[k], tangents[k])
                target, replaced = self._place[rows.targets], self._place[rows.replaced]
                shares.append(self._placed(rows.by_force, target, replaced))
                added.append(self._placed(rows.by_position, target, self._at[k]))
                taken.append(replaced)
            self._taken = np.concatenate(taken)
            self._shares = sum(shares[1:], shares[0])
            self.matrix = self.moved(S)
            entries = sum(added[1:], added[0]).tocoo()
            self.matrix[entries.row, entries.col] += entries.data

    def solve(self, forces: Floats, right: Floats) -> Floats:
        """Solve (T S + C) x = T forces + right.

        Args:
            forces: Bulk forces, (n,).
            right: Residual with contact, (n,).

        Returns:
            x, (n,).
        """
        return np.asarray(np.linalg.solve(self.matrix, self.moved(forces) + right), np.float64)

    def moved(self, forces: Floats) -> Floats:
        """T times rows of bulk forces, (n,) or (n, m)."""
        result = self._shares @ forces
        rest = np.ones(self._n, bool)
        rest[self._taken] = False
        result[rest] += forces[rest]
        return np.asarray(result)

    def _placed(self, matrix: sp.csr_matrix, rows: Ints, columns: Ints) -> sp.csr_matrix:
        """A matrix with its entries at some rows and columns; those with a negative one drop."""
        entries = matrix.tocoo()
        row, col = rows[entries.row], columns[entries.col]
        keep = (row >= 0) & (col >= 0)
        place = (row[keep], col[keep])
        return sp.coo_matrix((entries.data[keep], place), (self._n, self._n)).tocsr()
