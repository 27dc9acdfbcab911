"""Schur complement of the bulk, by substructuring over the ranks.

A rank eliminates what only its cells touch. What is left, the kept unknowns and those between the
ranks, is one dense matrix, the sum of the ranks' Schur complements, in which the latter go as well.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from mpi4py import MPI
from petsc4py import PETSc

from contactfem.common.typing import Floats, Ints
from contactfem.fem.dof_numbering import pairs
from contactfem.mechanics.bulk_system import System
from contactfem.solvers.dense_elimination import Condensed, Elimination, SchurComplement
from contactfem.solvers.schur_factor import SchurFactor


@dataclass(frozen=True)
class RightHandSide:
    """A right-hand side r.

    Attributes:
        kept: Condensed to the kept unknowns, (k,), the same on all ranks.
        border: S_ee⁻¹ r_e of those between ranks, that were eliminated after them, likewise.
        inner: r of what only this rank's cells touch, zero on its border.
        mine: What that comes to there.
    """

    kept: Floats
    border: Floats
    inner: Floats
    mine: Floats


class Substructure:
    """Factors of the bulk tangent K that give away its Schur complement on kept unknowns.

    Vectors over all unknowns are given and returned as this rank's owned part; those over kept ones
    are the same on all ranks. Kept numbers may go beyond those of the system.

    Args:
        system: The bodies.
        unknown: Numbers of every body's local dofs; negative ones are dropped.
        kept: Numbers that are kept, ascending, the same on all ranks.

    Attributes:
        border: Numbers of the dense matrix, ascending: the kept ones and those between ranks.
        n_inner: Unknowns that only this rank's cells touch.
    """

    def __init__(self, system: System, unknown: Sequence[Ints], kept: Ints) -> None:
        self._system, self._comm, self.kept = system, system.comm, kept
        cells = [
            numbers[body.cell_dofs()] for body, numbers in zip(system.bodies, unknown, strict=True)
        ]
        touched = np.unique(np.concatenate([dofs.ravel() for dofs in cells]))
        self._local = local = touched[touched >= 0]
        self.border = self._common(kept)
        own = np.isin(local, self.border)
        self.n_inner = int(np.sum(~own))
        self._place = np.searchsorted(self.border, local[own])
        self._kept = np.searchsorted(self.border, kept)
        size = max(system.numbering.n_global, 1 + int(kept.max(initial=-1)))
        number = np.full(size + 1, -1, np.int64)  # the last one stands for no unknown
        number[local] = np.arange(len(local))
        self._number = [number[numbers] for numbers in unknown]
        self._K = _matrix([number[dofs] for dofs in cells], len(local))
        self._factor = SchurFactor(self._K, np.flatnonzero(own), system.is_symmetric)
        self._rest: Elimination | None = None
        self._count = 0
        self._reach = self._scatter()

    def _common(self, kept: Ints) -> Ints:
        """Numbers that are kept, or that the cells of several ranks touch; collective."""
        if self._comm.size == 1:
            return kept
        n = self._system.numbering.n_global
        count = np.zeros(n, np.int32)
        count[self._local[self._local < n]] = 1
        self._comm.Allreduce(MPI.IN_PLACE, count)
        return np.union1d(kept, np.flatnonzero(count > 1))

    def _scatter(self) -> tuple[PETSc.Scatter, PETSc.Vec]:
        """From owned unknowns to those that this rank's cells touch."""
        numbers = self._local[self._local < self._system.numbering.n_global].astype(np.int32)
        here = PETSc.Vec().createSeq(len(self._local))
        places = np.arange(len(numbers), dtype=np.int32)
        index = [PETSc.IS().createGeneral(a, comm=PETSc.COMM_SELF) for a in (numbers, places)]
        return PETSc.Scatter().create(self._system.x, index[0], here, index[1]), here

    def assemble(self, jumps: Sequence[Floats | None]) -> None:
        """Take the bulk tangent at the present state.

        Args:
            jumps: Of `System.advance` in the first iteration, else all None.
        """
        self._K.zeroEntries()
        for body, jump, number in zip(self._system.bodies, jumps, self._number, strict=True):
            numbers = PETSc.LGMap().create(number.astype(np.int32), comm=PETSc.COMM_SELF)
            self._K.setLGMap(numbers, numbers)
            with body.without(jump):
                body.add_tangent(self._K)
        self._K.assemble()

    def factorise(self) -> SchurComplement:
        """Schur complement of what was assembled on the kept unknowns, (k, k); collective.

        The factor stays for `condense` and `expand`.

        Raises:
            PETSc.Error: It could not be, on all ranks.
        """
        error = 0
        try:
            self._factor.factorise()
        except PETSc.Error as raised:
            error = raised.ierr
        if error := self._comm.allreduce(error, MPI.MAX):
            raise PETSc.Error(error)
        if self._comm.size == 1:
            self._rest = None
            return self._numbered(self._factor.S)
        whole = np.zeros((len(self.border), len(self.border)))
        whole[np.ix_(self._place, self._place)] = self._factor.S
        self._comm.Allreduce(MPI.IN_PLACE, whole)
        self._rest = Elimination(self._numbered(whole), self._kept)
        return self._numbered(self._rest.S)

    def _numbered(self, values: Floats) -> SchurComplement:
        self._count += 1
        return SchurComplement(values, self._count)

    def condense(self, owned: Floats, beyond: Floats) -> RightHandSide:
        """Right-hand side of the kept unknowns, r_k - K_ki K_ii⁻¹ r_i; collective.

        Args:
            owned: Right-hand side r of the unknowns, this rank's.
            beyond: Of the kept numbers beyond them, the same on all ranks.

        Returns:
            It, and what `expand` needs.
        """
        inner = self._inner(owned)
        mine = self._factor.condense(inner)
        border = gathered(self._system, owned, self.border)
        border[len(border) - len(beyond) :] = beyond
        answer = np.zeros(len(border))
        answer[self._place] = mine
        self._comm.Allreduce(MPI.IN_PLACE, answer)
        border += answer
        if self._rest is None:
            return RightHandSide(border, np.empty(0), inner, mine)
        found = self._rest.condense(border, border)
        return RightHandSide(found.left, found.gone, inner, mine)

    def expand(self, right: RightHandSide, kept: Floats) -> Floats:
        """All unknowns from the kept ones: K_ii x_i = r_i - K_ik x_k; collective.

        Args:
            right: What `condense` made of r.
            kept: The kept unknowns x_k.

        Returns:
            x of the unknowns, this rank's.
        """
        border = kept
        if self._rest is not None:
            border = self._rest.expand(kept, Condensed(right.kept, right.border))
        x = self._factor.expand(right.inner, right.mine, border[self._place])
        result, free = self._system.x.duplicate(), self._local < self._system.numbering.n_global
        result.setValues(self._local[free].astype(np.int32), x[free])
        result.assemble()
        return np.array(result.array_r)

    def _inner(self, owned: Floats) -> Floats:
        """Values of what only this rank's cells touch, in its own numbering."""
        scatter, here = self._reach
        source = self._system.x.duplicate()
        source.array[:] = owned
        here.set(0.0)
        scatter.scatter(source, here)
        result = np.array(here.array_r)
        result[self._factor.kept] = 0.0
        return result


def gathered(system: System, owned: Floats, numbers: Ints) -> Floats:
    """Values of some unknowns on all ranks, zero for numbers beyond them; collective.

    Args:
        system: The bodies.
        owned: Values of this rank's unknowns.
        numbers: Numbers, the same on all ranks.
    """
    at = numbers - system.numbering.first
    mine = (at >= 0) & (at < system.numbering.n_local)
    result = np.zeros(len(numbers))
    result[mine] = owned[at[mine]]
    system.comm.Allreduce(MPI.IN_PLACE, result)
    return result


def _matrix(cells: Sequence[Ints], n: int) -> PETSc.Mat:
    """Zero matrix of this rank alone with the pattern of its cells' dofs."""
    diagonal = np.arange(n), np.arange(n)
    row, col = map(np.concatenate, zip(diagonal, *(pairs(dofs) for dofs in cells), strict=True))
    keep = (row >= 0) & (col >= 0)
    ones = np.ones(int(keep.sum()), np.int8)
    pattern = sp.coo_matrix((ones, (row[keep], col[keep])), (n, n)).tocsr()
    csr = pattern.indptr.astype(np.int32), pattern.indices.astype(np.int32), np.zeros(pattern.nnz)
    A = PETSc.Mat().createAIJ((n, n), csr=csr, comm=PETSc.COMM_SELF)
    A.setOption(PETSc.Mat.Option.KEEP_NONZERO_PATTERN, True)
    return A
