"""Lagged bulk factor: refactorise when the residuals say so.

The bulk tangent changes little between iterations, contact all at once. So a factor of an earlier
bulk tangent serves on through its Schur complement on the unknowns of the interfaces, where the
rows of contact are those of the present state. Residuals are exact, so is what they lead to.
"""

import math
from collections.abc import Sequence

import numpy as np

from petsc4py import PETSc

from contactfem.common.timers import Timers
from contactfem.common.typing import Floats
from contactfem.mechanics.contact_equations import ContactEquations
from contactfem.solvers.dense_elimination import SchurComplement
from contactfem.solvers.interface import Iterate, SupportForces
from contactfem.solvers.interface_solver import InterfaceSolver
from contactfem.solvers.substructuring import Substructure


class LaggedBulk(InterfaceSolver):
    """Linear systems with the bulk of an earlier iteration.

    Args:
        equations: The equations, with multipliers eliminated and with interfaces.
        timers: Where time is booked.

    Attributes:
        bulk: The bulk, condensed.
    """

    def __init__(self, equations: ContactEquations, timers: Timers) -> None:
        super().__init__(equations, timers)
        unknown = self._system.numbering.unknown
        self.bulk = Substructure(self._system, unknown, self.unknowns)
        self._S: SchurComplement | None = None  # None where a new one is needed
        self._solved = False

    def begin(self) -> None:
        """Begin a new solve, with a new factor if the last one failed."""
        self.failure = ""
        if not self._solved:
            self._S = None
        self._solved = False

    def residual(
        self, x: PETSc.Vec, out: PETSc.Vec, jumps: Sequence[Floats | None]
    ) -> SupportForces:
        """As said of every `LinearSolver`."""
        self._system.spread(x)
        parts = self._system.residual(out, jumps)
        return SupportForces(self._system.reactions(parts), self._system.supports(parts))

    def finish(self, x: PETSc.Vec) -> None:
        """The unknowns are complete."""
        self._solved = True

    def linearise(self, at: Iterate) -> PETSc.Mat:
        """As said of every `LinearSolver`, with a bulk that is only renewed where it is worth it.

        Not while the active set changes: what the residual does then is not the bulk's doing.
        """
        if self._S is None or (at.settled and should_refactorise(at.residuals, at.tolerance)):
            with self._timers.book("assembly"):
                self.bulk.assemble(at.jumps)
            with self._timers.book("factorisation"):
                self._S = self._new_factor()
        if self._S is None:
            return self._operator
        return self._take(self._interfaces.matrix(self._S, at.states), at.damping)

    def _new_factor(self) -> SchurComplement | None:
        """Factorise the bulk tangent; the next linear system asks again if that fails."""
        try:
            return self.bulk.factorise()
        except PETSc.Error as error:
            self.failure = f"no factor of the bulk (PETSc error {error.ierr})"
            return None

    def step(self, residual: Floats) -> Floats:
        """Newton's step with the bulk as it was."""
        inside = residual.copy()
        inside[self.owned] = 0.0
        right = self.bulk.condense(inside, np.empty(0))
        moved = self.solve(right.kept, self.gathered(residual))
        return self.bulk.expand(right, moved)


PRICE = 2.0  # iterations with an old factor that a new one costs, or less


SLOW = 0.5  # reduction of the residual in one iteration that no old factor is kept for


SLOPE = 5.0  # with a factor of a state with residual r, later iterations reduce by this times r


def should_refactorise(residuals: Sequence[float], tolerance: float) -> bool:
    """Whether a new factor shortens what is left of Newton's method.

    With the rate q of the last iteration log(tolerance / r) / log(q) iterations are left; with that
    of a new factor, which gets the better the nearer the solution is, fewer, but it has its price.

    Args:
        residuals: Scaled residuals of the solve so far [-].
        tolerance: What they must come to [-].
    """
    if len(residuals) < 2 or residuals[-1] <= tolerance:
        return False
    last = residuals[-1]
    rate = last / residuals[-2]
    if not rate < SLOW:
        return True
    new = SLOPE * last
    if new >= rate:
        return False
    left = math.log(last / tolerance)
    return left / -math.log(new) + PRICE < left / -math.log(rate)
