"""Linear systems solved on the interface unknowns, with a kept factor.

All ranks solve the same dense systems over the unknowns of the interfaces; vectors over all
unknowns are this rank's owned part.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping

import numpy as np

from petsc4py import PETSc

from contactfem.common.timers import Timers
from contactfem.common.typing import Floats
from contactfem.mechanics.contact_equations import ContactEquations
from contactfem.solvers.interface_system import (
    InterfaceMatrix,
    InterfaceSystem,
    interface_unknowns,
)
from contactfem.solvers.substructuring import gathered


class InterfaceSolver(ABC):
    """Linear systems over the unknowns of the interfaces.

    Args:
        equations: The equations, with multipliers eliminated and with interfaces.
        timers: Where time is booked.

    Attributes:
        options: None are needed.
        reuses: Always.
        failure: Why the last linear system had no solution, in words; else empty.
        unknowns: Of the interfaces, ascending.
        owned: Those of them that this rank owns, among its unknowns.
    """

    def __init__(self, equations: ContactEquations, timers: Timers) -> None:
        self.options: Mapping[str, str] = {}
        self.reuses, self.failure = True, ""
        self._system, self._timers = equations.system, timers
        numbering, comm = self._system.numbering, self._system.comm
        self.unknowns = interface_unknowns(equations.interfaces)
        self._interfaces = InterfaceSystem(
            equations.interfaces, self.unknowns, numbering.n_global, timers
        )
        self._matrix: InterfaceMatrix | None = None
        self._damping = 1.0
        size = (numbering.n_local, numbering.n_global)
        self._operator = PETSc.Mat().createPython((size, size), self, comm=comm)
        self._operator.setUp()
        at = self.unknowns - numbering.first
        self._mine = np.flatnonzero((at >= 0) & (at < numbering.n_local))
        self.owned = at[self._mine]

    def attach(self, snes: PETSc.SNES) -> PETSc.Mat:
        """Solve the linear systems here."""
        snes.ksp.setType(PETSc.KSP.Type.PREONLY)
        pc = snes.ksp.getPC()
        pc.setType(PETSc.PC.Type.PYTHON)
        pc.setPythonContext(self)
        return self._operator

    def apply(self, pc: PETSc.PC, b: PETSc.Vec, y: PETSc.Vec) -> None:
        """Newton's step y for a residual b; none where the system is singular."""
        y.set(0.0)
        if self.failure:
            return
        try:
            y.array[:] = self._damping * self.step(b.array_r)
        except np.linalg.LinAlgError:
            # an exception must not pass through PETSc, which would keep its vectors locked
            self.failure = "the system of the interfaces is singular"

    @abstractmethod
    def step(self, residual: Floats) -> Floats:
        """Newton's step for a residual, undamped, (n_local,)."""

    def gathered(self, owned: Floats) -> Floats:
        """Values at `unknowns`, the same on all ranks, from those of this rank's; collective."""
        return gathered(self._system, owned, self.unknowns)

    def put(self, owned: Floats, values: Floats) -> None:
        """Write values at `unknowns` into those of this rank's unknowns."""
        owned[self.owned] = values[self._mine]

    def _take(self, matrix: InterfaceMatrix, damping: float) -> PETSc.Mat:
        """Solve with a matrix from now on; returns the operator that PETSc sees."""
        self._matrix, self._damping = matrix, damping
        return self._operator

    def solve(self, forces: Floats, right: Floats) -> Floats:
        """What `InterfaceMatrix.solve` finds, to the last digit the same on all ranks; collective.

        Raises:
            LinAlgError: The system is singular, on all ranks.
        """
        found: Floats | None = None
        if self._system.comm.rank == 0:
            assert self._matrix is not None
            try:
                found = self._matrix.solve(forces, right)
            except np.linalg.LinAlgError:
                found = None
        found = self._system.comm.bcast(found)
        if found is None:
            raise np.linalg.LinAlgError
        return np.asarray(found)
