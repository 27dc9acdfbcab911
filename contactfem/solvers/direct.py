"""Direct solver: the whole tangent is factorised in every iteration."""

from collections.abc import Mapping, Sequence

from petsc4py import PETSc

from contactfem.common.timers import Timers
from contactfem.common.typing import Floats
from contactfem.mechanics.condensed import Condensed
from contactfem.solvers.interface import Iterate

MUMPS = {
    "ksp_type": "preonly",
    "pc_type": "lu",
    "pc_factor_mat_solver_type": "mumps",
    "mat_mumps_icntl_6": "0",  # the rows of nonmortar nodes are built with a good diagonal
    "mat_mumps_icntl_7": "2",  # AMF: a third faster than the default ordering in 2D
    "mat_mumps_icntl_14": "60",
}
# Rows of multipliers have zeros on the diagonal: pivots wait for others, which takes memory. A
# permutation by value (icntl_6 = 5) comes with scales of the first status, wrong for later ones.
PIVOTING = {"mat_mumps_icntl_14": "200"}


class Direct:
    """Residuals and linear systems of Newton's method for a system with contact.

    Args:
        equations: The system.
        options: PETSc options for the linear solver, over the defaults.
        timers: Where time is booked.

    Attributes:
        options: PETSc options that it needs.
        parts: Residuals of the bodies' local dofs at the last state [N/m].
        failure: Why the last linear system had no solution, in words; else empty.
    """

    def __init__(self, equations: Condensed, options: Mapping[str, str], timers: Timers) -> None:
        self.equations, self.system, self.timers = equations, equations.system, timers
        kept = len(self.system.numbering.multipliers) > 0
        self.options = MUMPS | (PIVOTING if kept else {}) | dict(options)
        self.parts: list[Floats] = []
        self.failure = ""

    def attach(self, snes: PETSc.SNES) -> PETSc.Mat:
        """Prepare the solver, after its options; returns a matrix to start with."""
        self._ksp = snes.ksp
        return self.system.create_matrix(self.system.pattern)

    def begin(self) -> None:
        """Begin a new solve."""
        self.failure = ""

    def residual(self, x: PETSc.Vec, out: PETSc.Vec, jumps: Sequence[Floats | None]) -> None:
        """Residual without contact at some unknowns, which the bodies take over; collective.

        Args:
            x: The unknowns.
            out: Receives the residual [N/m].
            jumps: Of `System.advance` in the first iteration, else all None.
        """
        self.system.spread(x)
        self.parts = self.system.residual(out, jumps)

    def reactions(self) -> list[float]:
        """Resultant of every prescribed motion on its body at the last state [N/m]; collective."""
        return self.system.reactions(self.parts)

    def supports(self) -> Floats:
        """What prescribed motions exert on each body [N/m], (bodies, axes); collective."""
        return self.system.supports(self.parts)

    def linearise(self, at: Iterate) -> PETSc.Mat:
        """Operator of the next linear system, the tangent over the damping; collective.

        It is factorised here, so that the time is booked.
        """
        with self.timers.book("contact.pattern"):
            self.equations.prepare(at.conditions)
        self.equations.fill(at.conditions, at.jumps)
        A = self.equations.tangent()
        if at.damping < 1.0:
            A.scale(1.0 / at.damping)
        self._ksp.setOperators(A, A)
        with self.timers.book("factorisation"):
            self._ksp.setUp()
        return A

    def finish(self, x: PETSc.Vec) -> None:
        """Complete the unknowns of a solution; collective."""
