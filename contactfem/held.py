"""The bulk with prescribed motions as unknowns: reactions are rows of it; on one rank."""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from petsc4py import PETSc

from contactfem.numbering import PRESCRIBED, Floats, Ints
from contactfem.surfaces import Bools
from contactfem.system import System


class Held:
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
            numbers = unknown.copy()
            if held.any():
                groups, inverse = np.unique(member[:, held], axis=1, return_inverse=True)
                numbers[held] = first + inverse.ravel()
                first += groups.shape[1]
                motions.append(groups)
            self.unknown.append(numbers)
        self.motions = np.hstack(motions).astype(float)
        self.numbers: Ints = np.arange(self._n, first)

    def residual(self, free: Floats, parts: Sequence[Floats]) -> Floats:
        """Residual of the unknowns and, after it, of the held dofs [N/m].

        Args:
            free: That of the unknowns, (n,).
            parts: Of the bodies' local dofs, as `System.residual` returns them.
        """
        size = self._n + len(self.numbers)
        result = np.zeros(size)
        for unknown, part in zip(self.unknown, parts, strict=True):
            result += np.bincount(unknown, part, size)
        result[: self._n] = free
        return result

    def matrix(self) -> PETSc.Mat:
        """Bulk tangent with rows and columns of the held dofs."""
        pattern = self._pattern()
        csr = (pattern.indptr, pattern.indices, np.zeros(pattern.nnz))
        A = PETSc.Mat().createAIJ(pattern.shape, csr=csr, comm=self._system.comm)
        for body, unknown in zip(self._system.bodies, self.unknown, strict=True):
            numbers = PETSc.LGMap().create(unknown.astype(np.int32), comm=self._system.comm)
            A.setLGMap(numbers, numbers)
            body.add_tangent(A)
        A.assemble()
        return A

    def _pattern(self) -> sp.csr_matrix:
        """Entries of the unknowns, and of the cells that have a held dof."""
        size = self._n + len(self.numbers)
        free = self._system.pattern.copy()
        free.resize((size, size))
        rows, cols = [self.numbers], [self.numbers]
        for body, unknown in zip(self._system.bodies, self.unknown, strict=True):
            dofs = unknown[body.cell_dofs()]
            dofs = dofs[(dofs >= self._n).any(axis=1)]
            rows.append(np.repeat(dofs, dofs.shape[1], axis=1).ravel())
            cols.append(np.tile(dofs, (1, dofs.shape[1])).ravel())
        row, col = np.concatenate(rows), np.concatenate(cols)
        ones = np.ones(len(row), np.int8)
        return (free + sp.coo_matrix((ones, (row, col)), (size, size)).tocsr()).tocsr()
