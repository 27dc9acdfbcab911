"""Whose rows those of a residual are, and which bodies contact joins."""

from collections.abc import Sequence

import numpy as np

from mpi4py import MPI

from contactfem.common.typing import Floats, Ints
from contactfem.contact.state import ContactState
from contactfem.mechanics.bulk_system import System
from contactfem.mechanics.contact_equations import Interface


class BodyRows:
    """Rows of the system of equations, body by body.

    Args:
        system: The bodies.
        interfaces: The interfaces; rows of multipliers are those of the nonmortar body.

    Attributes:
        pairs: Nonmortar and mortar body of every interface; -1 of an obstacle.
    """

    def __init__(self, system: System, interfaces: Sequence[Interface]) -> None:
        self._comm, self._count = system.comm, len(system.bodies)
        self.pairs = [(int(i.nodes.body[0]), int(i.nodes.body[-1])) for i in interfaces]
        n = system.numbering
        self._body = np.zeros(n.n_local, np.int64)
        for b, unknown in enumerate(n.unknown):
            own = (unknown >= n.first) & (unknown < n.first + n.n_local)
            self._body[unknown[own] - n.first] = b
        if system.comm.rank == 0:
            for k, dofs in enumerate(system.tied):
                self._body[k] = dofs.body
            if len(n.multipliers):
                sizes = [i.nodes.mesh.n_nonmortar * system.dim for i in interfaces]
                self._body[n.multipliers] = np.repeat([a for a, _ in self.pairs], sizes)

    def squares(self, residual: Floats) -> Floats:
        """Sum of squares of a residual over the rows of each body, (bodies,); collective.

        Args:
            residual: This rank's part.
        """
        found = np.bincount(self._body, residual**2, self._count)
        self._comm.Allreduce(MPI.IN_PLACE, found)
        return found

    def joined(self, states: Sequence[ContactState]) -> Ints:
        """The same number for bodies that press on each other, directly or through others.

        Args:
            states: Contact of every interface.
        """
        label = np.arange(self._count)
        for (a, b), c in zip(self.pairs, states, strict=True):
            if b >= 0 and c.active.any():
                label[label == label[b]] = label[a]
        return label
