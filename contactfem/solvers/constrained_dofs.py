"""Numbers of constrained dofs, whose reactions are rows too."""

from collections.abc import Sequence

import numpy as np

from mpi4py import MPI

from contactfem.common.typing import Bools, Floats, Ints
from contactfem.fem.dof_numbering import PRESCRIBED
from contactfem.mechanics.bulk_system import System


class ConstrainedDofs:
    """Numbers for the held dofs after all unknowns: one for those with the same motions.

    Args:
        system: The bodies.

    Attributes:
        numbers: Numbers of the groups of held dofs, (g,).
        unknown: Numbers of every body's local dofs.
        motions: Which groups each prescribed motion holds, (motions, g).
    """

    def __init__(self, system: System) -> None:
        self._system, self._n = system, system.numbering.n_global
        motions: list[Bools] = [np.empty((len(system.prescribed), 0), bool)]
        self.unknown: list[Ints] = []
        first = self._n
        for b, (body, unknown) in enumerate(
            zip(system.bodies, system.numbering.unknown, strict=True)
        ):
            member = np.zeros((len(system.prescribed), len(unknown)), bool)
            for k, p in enumerate(system.prescribed):
                if p.body == b:
                    member[k, body.dofs(p.vertices, p.component)] = True
            held = unknown == PRESCRIBED
            groups = _all_groups(system.comm, member[:, held])
            numbers = unknown.copy()
            numbers[held] = first + _places(groups, member[:, held])
            first += groups.shape[1]
            motions.append(groups)
            self.unknown.append(numbers)
        self.motions = np.hstack(motions).astype(float)
        self.numbers: Ints = np.arange(self._n, first)

    def residual(self, parts: Sequence[Floats]) -> Floats:
        """Residual of the groups of held dofs [N/m], the same on all ranks; collective.

        Args:
            parts: Of the bodies' local dofs, as `System.residual` returns them.
        """
        result = np.zeros(len(self.numbers))
        for unknown, part in zip(self.unknown, parts, strict=True):
            held = unknown >= self._n
            result += np.bincount(unknown[held] - self._n, part[held], len(result))
        self._system.comm.Allreduce(MPI.IN_PLACE, result)
        return result

    def supports(self, residual: Floats) -> Floats:
        """Sum of the groups' residuals by body and component [N/m], (bodies, axes).

        Args:
            residual: Of the groups [N/m], (g,).
        """
        system = self._system
        total = np.zeros((len(system.bodies), system.bodies[0].mesh.mesh.geometry.dim))
        motion = np.argmax(self.motions, axis=0) if self.motions.size else np.empty(0, np.int64)
        for value, k in zip(residual, motion, strict=True):
            p = system.prescribed[k]
            total[p.body, p.component] += value
        return total


def _all_groups(comm: MPI.Comm, columns: Bools) -> Bools:
    """Different columns of all ranks, (motions, g); collective."""
    found = np.hstack(comm.allgather(np.unique(columns, axis=1)))
    return np.asarray(np.unique(found, axis=1))


def _places(groups: Bools, columns: Bools) -> Ints:
    """Which of some different columns others are."""
    if not columns.shape[1]:
        return np.empty(0, dtype=np.int64)
    both = np.hstack((groups, columns))
    inverse = np.unique(both, axis=1, return_inverse=True)[1].ravel()
    return np.asarray(inverse[groups.shape[1] :], dtype=np.int64)
