"""Newton's linear systems with an older factor of the bulk: contact is always new.

The bulk tangent changes little between iterations, contact all at once. So a factor of an earlier
bulk tangent serves on through its Schur complement on the unknowns of the interfaces, where the
rows of contact are those of the present state. Residuals are exact, so is what they lead to.
"""

import numpy as np

from petsc4py import PETSc

from contactfem.common.timers import Timers
from contactfem.common.typing import Floats
from contactfem.mechanics.condensed import Condensed
from contactfem.solvers.interface import Iterate
from contactfem.solvers.interface_solver import OnInterfaces
from contactfem.solvers.renewal import worth_renewing
from contactfem.solvers.substructuring import Substructure


class Reused(OnInterfaces):
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
        if self._new or (at.settled and worth_renewing(at.residuals, at.tolerance)):
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
