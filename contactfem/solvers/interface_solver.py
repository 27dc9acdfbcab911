"""Linear systems solved on the interface unknowns, with a kept factor.

All ranks solve the same dense systems over the unknowns of the interfaces; vectors over all
unknowns are this rank's owned part.
"""

import numpy as np

from petsc4py import PETSc

from contactfem.common.timers import Timers
from contactfem.common.typing import Floats
from contactfem.mechanics.condensed import Condensed
from contactfem.solvers.direct import Direct
from contactfem.solvers.interface_system import InterfaceSystem, interface_unknowns
from contactfem.solvers.substructuring import gathered


class InterfaceSolver(Direct):
    """Linear systems over the unknowns of the interfaces.

    Args:
        equations: The system, condensed, with interfaces.
        timers: Where time is booked.
    """

    def __init__(self, equations: Condensed, timers: Timers) -> None:
        super().__init__(equations, {}, timers)
        self.options = {}
        numbering, comm = self.system.numbering, self.system.comm
        self.unknowns = interface_unknowns(equations.interfaces)
        self.matrix = InterfaceSystem(
            equations.interfaces, self.unknowns, numbering.n_global, timers
        )
        self.damping = 1.0
        size = (numbering.n_local, numbering.n_global)
        self.operator = PETSc.Mat().createPython((size, size), self, comm=comm)
        self.operator.setUp()
        at = self.unknowns - numbering.first
        self._mine = np.flatnonzero((at >= 0) & (at < numbering.n_local))
        self.owned = at[self._mine]

    def attach(self, snes: PETSc.SNES) -> PETSc.Mat:
        """Solve the linear systems here."""
        snes.ksp.setType(PETSc.KSP.Type.PREONLY)
        pc = snes.ksp.getPC()
        pc.setType(PETSc.PC.Type.PYTHON)
        pc.setPythonContext(self)
        return self.operator

    def apply(self, pc: PETSc.PC, b: PETSc.Vec, y: PETSc.Vec) -> None:
        """Newton's step y for a residual b; none where the system is singular."""
        y.set(0.0)
        if self.failure:
            return
        try:
            y.array[:] = self.damping * self.step(b.array_r)
        except np.linalg.LinAlgError:
            # an exception must not pass through PETSc, which would keep its vectors locked
            self.failure = "the system of the interfaces is singular"

    def step(self, residual: Floats) -> Floats:
        """Newton's step for a residual, undamped, (n_local,)."""
        raise NotImplementedError

    def gathered(self, owned: Floats) -> Floats:
        """Values at `unknowns`, the same on all ranks, from those of this rank's; collective."""
        return gathered(self.system, owned, self.unknowns)

    def put(self, owned: Floats, values: Floats) -> None:
        """Write values at `unknowns` into those of this rank's unknowns."""
        owned[self.owned] = values[self._mine]

    def solve(self, forces: Floats, right: Floats) -> Floats:
        """What `matrix.solve` finds, the same to the last digit on all ranks; collective.

        Raises:
            LinAlgError: The system is singular, on all ranks.
        """
        found: Floats | None = None
        if self.system.comm.rank == 0:
            try:
                found = self.matrix.solve(forces, right)
            except np.linalg.LinAlgError:
                found = None
        found = self.system.comm.bcast(found)
        if found is None:
            raise np.linalg.LinAlgError
        return np.asarray(found)
