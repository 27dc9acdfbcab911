"""The matrix of mechanics, with room for contact."""

from collections.abc import Sequence

from petsc4py import PETSc

from contactfem.common.typing import Floats
from contactfem.contact.state import ContactState
from contactfem.mechanics.bulk_system import System
from contactfem.mechanics.sparsity import Coupling


class SystemMatrix:
    """A matrix whose pattern grows where contact needs it.

    Args:
        system: The bodies.
        couplings: Patterns of the interfaces.
    """

    def __init__(self, system: System, couplings: Sequence[Coupling]) -> None:
        self._system, self._couplings = system, tuple(couplings)
        self._matrix: PETSc.Mat | None = None
        self._bulk: PETSc.Mat | None = None  # of a linear bulk, assembled once

    def with_room(self, states: Sequence[ContactState]) -> PETSc.Mat:
        """The matrix, made anew where the present contact does not fit in; collective.

        Args:
            states: Of every interface.
        """
        grown = False
        for coupling, c in zip(self._couplings, states, strict=True):
            grown |= coupling.include(c.operators.M + c.history.M, c.active)
        if self._matrix is not None and not grown:
            return self._matrix
        pattern = self._system.pattern
        for coupling in self._couplings:
            pattern = pattern + coupling.pattern()
        for old in (self._matrix, self._bulk):
            if old is not None:
                old.destroy()
        self._matrix, self._bulk = self._system.create_matrix(pattern), None
        return self._matrix

    def fill_bulk(self, matrix: PETSc.Mat, jumps: Sequence[Floats | None]) -> None:
        """Bulk tangent; where it does not depend on the state it is assembled once; collective.

        Args:
            matrix: From `with_room`.
            jumps: Jumps of prescribed motions that the bulk has not followed yet.
        """
        if not self._system.is_linear:
            self._system.assemble(matrix, jumps)
            return
        if self._bulk is None:
            self._bulk = matrix.duplicate()
            self._system.assemble(self._bulk, jumps)
        self._bulk.copy(matrix, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
