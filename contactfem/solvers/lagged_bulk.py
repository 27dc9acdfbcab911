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
from contactfem.mechanics.condensed import Condensed
from contactfem.solvers.interface import Iterate
from contactfem.solvers.interface_solver import InterfaceSolver
from contactfem.solvers.substructuring import Substructure


class LaggedBulk(InterfaceSolver):
    """Linear systems with the bulk of an earlier iteration.

    Args:
        equations: The system, condensed, with interfaces.
        timers: Where time is booked.

    Attributes:
        bulk: The bulk, condensed.
    """

    def __init__(self, equations: Condensed, timers: Timers) -> None:
        super().__init__(equations, timers)
        self.bulk = Substructure(self.system, self.system.numbering.unknown, self.unknowns)
        self._new = self._unsolved = True

    def begin(self) -> None:
        """Begin a new solve, with a new factor if the last one failed."""
        super().begin()
        self._new, self._unsolved = self._new or self._unsolved, True

    def finish(self, x: PETSc.Vec) -> None:
        """The unknowns are complete."""
        self._unsolved = False

    def linearise(self, at: Iterate) -> PETSc.Mat:
        """As that of `Direct`, with a bulk that is only renewed where it is worth it.

        Not while the contact status changes: what the residual does then is not the bulk's doing.
        """
        if self._new or (at.settled and should_refactorise(at.residuals, at.tolerance)):
            with self.timers.book("assembly"):
                self.bulk.assemble(at.jumps)
            with self.timers.book("factorisation"):
                self._renew()
        self.matrix.fill(self.bulk.S, at.conditions)
        self.damping = at.damping
        return self.operator

    def _renew(self) -> None:
        """Factorise the bulk tangent; the next linear system asks again if that fails."""
        try:
            self.bulk.factorise()
            self._new = False
        except PETSc.Error as error:
            self._new, self.failure = True, f"no factor of the bulk (PETSc error {error.ierr})"

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
