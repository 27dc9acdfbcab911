"""Linear bulk: factorised once for the whole run.

The interior follows the unknowns of the interfaces, x_i = K_ii⁻¹ (f_i - K_ic x_c), and answers with
their Schur complement S. Newton's method in x_c alone takes the same steps as in all unknowns; the
interior is found once, at the end.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from petsc4py import PETSc

from contactfem.common.timers import Timers
from contactfem.common.typing import Floats
from contactfem.mechanics.condensed import Condensed
from contactfem.solvers.constrained_dofs import ConstrainedDofs
from contactfem.solvers.interface import Iterate
from contactfem.solvers.interface_solver import InterfaceSolver
from contactfem.solvers.substructuring import RightHandSide, Substructure


@dataclass(frozen=True)
class _Origin:
    """Where the interior began to follow.

    Attributes:
        x: Unknowns of the interfaces there [m].
        residual: Bulk residual there [N/m], with what it comes to at the interfaces and held dofs
            once the interior follows.
    """

    x: Floats
    residual: RightHandSide


class LinearBulk(InterfaceSolver):
    """Residuals and linear systems on the interfaces of a linear bulk.

    Args:
        equations: The system, condensed, of a linear bulk with interfaces.
        timers: Where time is booked.

    Attributes:
        bulk: The bulk, condensed.
    """

    def __init__(self, equations: Condensed, timers: Timers) -> None:
        super().__init__(equations, timers)
        self._held = ConstrainedDofs(self.system)
        kept = np.concatenate((self.unknowns, self._held.numbers))
        self.bulk = Substructure(self.system, self._held.unknown, kept)
        self._factorised = False
        self._origin: _Origin | None = None

    def begin(self) -> None:
        """Forget the last solve; its factor stays."""
        super().begin()
        self._origin = None

    def residual(self, x: PETSc.Vec, out: PETSc.Vec, jumps: Sequence[Floats | None]) -> None:
        """As that of `Direct`; after the first iteration, that which the interior leaves over."""
        if self._origin is None:
            super().residual(x, out, jumps)
            self._residual = np.array(out.array_r)
            self._reactions = self._held.residual(self.parts)
            return
        self.system.spread(x)
        moved = self.gathered(x.array_r) - self._origin.x
        rows = self._origin.residual.kept + self._answer @ moved
        self._reactions = rows[len(moved) :]
        out.set(0.0)
        self.put(out.array, rows[: len(moved)])

    def reactions(self) -> list[float]:
        """As those of `Direct`."""
        return [float(v) for v in self._held.motions @ self._reactions]

    def supports(self) -> Floats:
        """As those of `Direct`."""
        return self._held.supports(self._reactions)

    def linearise(self, at: Iterate) -> PETSc.Mat:
        """As that of `Direct`, on the interfaces."""
        if not self._factorised:
            self._factorise()
        self._inner: Floats = np.zeros(len(self.unknowns))
        if self._origin is None:
            with self.timers.book("solve"):
                residual = self.bulk.condense(self._residual, self._reactions)
            x = self.gathered(self.system.x.array_r)
            self._origin = _Origin(x, residual)
            self._inner = residual.kept[: len(x)] - self.gathered(self._residual)
        self.matrix.fill(self._S, at.conditions)
        self.damping = at.damping
        return self.operator

    def _factorise(self) -> None:
        """Factor of the bulk that gives the interfaces and the reactions away."""
        with self.timers.book("assembly"):
            self.bulk.assemble([None] * len(self.system.bodies))
        with self.timers.book("factorisation"):
            self.bulk.factorise()
        self._factorised = True
        self._answer = self.bulk.S[:, : len(self.unknowns)]  # with the rows of the held dofs
        self._S = self._answer[: len(self.unknowns)]

    def step(self, residual: Floats) -> Floats:
        """Newton's step at the interfaces; the interior's is left for the end."""
        result = np.zeros(len(residual))
        self.put(result, self.solve(self._inner, self.gathered(residual)))
        return result

    def finish(self, x: PETSc.Vec) -> None:
        """Let the interior follow, and the bodies."""
        if self._origin is None:
            return
        moved = np.zeros(len(self.bulk.kept))
        moved[: len(self.unknowns)] = self.gathered(x.array_r) - self._origin.x
        with self.timers.book("solve"):
            change = self.bulk.expand(self._origin.residual, -moved)
        change[self.owned] = 0.0
        x.array[:] -= change
        self.system.spread(x)
