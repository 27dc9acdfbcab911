"""Direct solver: the whole tangent is factorised in every iteration."""

from collections.abc import Mapping, Sequence

from petsc4py import PETSc

from contactfem.common.timers import Timers
from contactfem.common.typing import Floats
from contactfem.mechanics.contact_equations import ContactEquations
from contactfem.solvers.interface import Iterate, SupportForces

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
    """The whole tangent, factorised in every iteration.

    Args:
        equations: The equations.
        options: PETSc options for the linear solver, over the defaults.
        timers: Where time is booked.

    Attributes:
        options: PETSc options that it needs.
        reuses: Never.
        failure: Empty: PETSc raises its errors.
    """

    def __init__(
        self, equations: ContactEquations, options: Mapping[str, str], timers: Timers
    ) -> None:
        self._equations, self._system, self._timers = equations, equations.system, timers
        pivoting = {} if equations.eliminates_multipliers else PIVOTING
        self.options: Mapping[str, str] = MUMPS | pivoting | dict(options)
        self.reuses, self.failure = False, ""
        self._ksp: PETSc.KSP | None = None

    def attach(self, snes: PETSc.SNES) -> PETSc.Mat:
        """As said of every `LinearSolver`."""
        self._ksp = snes.ksp
        return self._system.create_matrix(self._system.pattern)

    def begin(self) -> None:
        """As said of every `LinearSolver`."""

    def residual(
        self, x: PETSc.Vec, out: PETSc.Vec, jumps: Sequence[Floats | None]
    ) -> SupportForces:
        """As said of every `LinearSolver`."""
        self._system.spread(x)
        parts = self._system.residual(out, jumps)
        return SupportForces(self._system.reactions(parts), self._system.supports(parts))

    def linearise(self, at: Iterate) -> PETSc.Mat:
        """As said of every `LinearSolver`."""
        A = self._equations.linearise(at.states, at.jumps)
        if at.damping < 1.0:
            A.scale(1.0 / at.damping)
        assert self._ksp is not None
        self._ksp.setOperators(A, A)
        with self._timers.book("factorisation"):
            self._ksp.setUp()
        return A

    def finish(self, x: PETSc.Vec) -> None:
        """The unknowns are complete."""
