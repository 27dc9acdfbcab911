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
from contactfem.mechanics.contact_equations import ContactEquations
from contactfem.solvers.constrained_dofs import ConstrainedDofs
from contactfem.solvers.dense_elimination import SchurComplement
from contactfem.solvers.interface import Iterate, SupportForces
from contactfem.solvers.interface_solver import InterfaceSolver
from contactfem.solvers.substructuring import RightHandSide, Substructure


@dataclass(frozen=True)
class _Start:
    """Residuals where a solve starts.

    Attributes:
        residual: Of this rank's unknowns [N/m].
        reactions: Of the constrained dofs [N/m].
    """

    residual: Floats
    reactions: Floats


@dataclass(frozen=True)
class _Origin:
    """Where the interior began to follow.

    Attributes:
        x: Unknowns of the interfaces there [m].
        residual: Bulk residual there [N/m], with what it comes to at the interfaces and constrained
            dofs once the interior follows.
    """

    x: Floats
    residual: RightHandSide


@dataclass(frozen=True)
class _Answer:
    """What the bulk answers with to motions of the interfaces.

    Attributes:
        rows: Rows of the interfaces and of the constrained dofs, columns of the interfaces.
        S: The rows of the interfaces alone.
    """

    rows: Floats
    S: SchurComplement


class LinearBulk(InterfaceSolver):
    """Residuals and linear systems on the interfaces of a linear bulk.

    Args:
        equations: The equations, with multipliers eliminated, of a linear bulk with interfaces.
        timers: Where time is booked.

    Attributes:
        bulk: The bulk, condensed.
    """

    def __init__(self, equations: ContactEquations, timers: Timers) -> None:
        super().__init__(equations, timers)
        self._constrained = ConstrainedDofs(self._system)
        kept = np.concatenate((self.unknowns, self._constrained.numbers))
        self.bulk = Substructure(self._system, self._constrained.unknown, kept)
        self._answer: _Answer | None = None
        self._start: _Start | None = None
        self._origin: _Origin | None = None
        self._inner: Floats = np.zeros(len(self.unknowns))

    def begin(self) -> None:
        """Forget the last solve; its factor stays."""
        self.failure = ""
        self._start = self._origin = None

    def residual(
        self, x: PETSc.Vec, out: PETSc.Vec, jumps: Sequence[Floats | None]
    ) -> SupportForces:
        """As said of every `LinearSolver`; after the first iteration, what the interior leaves."""
        self._system.spread(x)
        if self._origin is None or self._answer is None:
            parts = self._system.residual(out, jumps)
            reactions = self._constrained.residual(parts)
            self._start = _Start(np.array(out.array_r), reactions)
        else:
            moved = self.gathered(x.array_r) - self._origin.x
            rows = self._origin.residual.kept + self._answer.rows @ moved
            reactions = rows[len(moved) :]
            out.set(0.0)
            self.put(out.array, rows[: len(moved)])
        motions = [float(v) for v in self._constrained.motions @ reactions]
        return SupportForces(motions, self._constrained.supports(reactions))

    def linearise(self, at: Iterate) -> PETSc.Mat:
        """As said of every `LinearSolver`, on the interfaces."""
        if self._answer is None:
            self._answer = self._factorised()
        self._inner = np.zeros(len(self.unknowns))
        if self._origin is None:
            assert self._start is not None
            with self._timers.book("solve"):
                residual = self.bulk.condense(self._start.residual, self._start.reactions)
            x = self.gathered(self._system.x.array_r)
            self._origin = _Origin(x, residual)
            self._inner = residual.kept[: len(x)] - self.gathered(self._start.residual)
        return self._take(self._interfaces.matrix(self._answer.S, at.states), at.damping)

    def _factorised(self) -> _Answer:
        """What a factor of the bulk says of the interfaces and the reactions."""
        with self._timers.book("assembly"):
            self.bulk.assemble([None] * len(self._system.bodies))
        with self._timers.book("factorisation"):
            S = self.bulk.factorise()
        count = len(self.unknowns)
        rows = S.values[:, :count]
        return _Answer(rows, SchurComplement(rows[:count], S.number))

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
        with self._timers.book("solve"):
            change = self.bulk.expand(self._origin.residual, -moved)
        change[self.owned] = 0.0
        x.array[:] -= change
        self._system.spread(x)
