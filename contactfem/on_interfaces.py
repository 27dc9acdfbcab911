"""What factors that serve on have in common: PETSc hands its linear systems over to them."""

import numpy as np

from petsc4py import PETSc

from contactfem.condensed import Condensed
from contactfem.direct import Direct
from contactfem.interface_matrix import InterfaceMatrix, interface_unknowns
from contactfem.surfaces import Floats
from contactfem.timers import Timers


class OnInterfaces(Direct):
    """Linear systems over the unknowns of the interfaces; on one rank.

    Args:
        equations: The system, condensed, with interfaces.
        timers: Where time is booked.
    """

    def __init__(self, equations: Condensed, timers: Timers) -> None:
        super().__init__(equations, {}, timers)
        self.options = {}
        n, comm = self.system.numbering.n_global, self.system.comm
        self.unknowns = interface_unknowns(equations.interfaces)
        self.matrix = InterfaceMatrix(equations.interfaces, self.unknowns, n, timers)
        self.damping = 1.0
        self.operator = PETSc.Mat().createPython(((n, n), (n, n)), self, comm=comm)
        self.operator.setUp()

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
        """Newton's step for a residual, undamped, (n,)."""
        raise NotImplementedError
