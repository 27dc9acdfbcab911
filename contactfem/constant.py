"""Newton's linear systems of a linear bulk, on one rank: factorised once for the whole run.

The interior follows the unknowns of the interfaces, x_i = K_ii⁻¹ (f_i - K_ic x_c), and answers with
their Schur complement S. Newton's method in x_c alone takes the same steps as in all unknowns; the
interior is found once, at the end.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from petsc4py import PETSc

from contactfem.condensed import Condensed
from contactfem.direct import Iterate
from contactfem.held import Held
from contactfem.on_interfaces import OnInterfaces
from contactfem.schur import SchurFactor
from contactfem.surfaces import Floats
from contactfem.timers import Timers


@dataclass(frozen=True)
class _Origin:
    """Where the interior began to follow.

    Attributes:
        x: Unknowns of the interfaces there [m].
        residual: Bulk residual there, with the rows of the held dofs [N/m].
        condensed: What it comes to at the interfaces and held dofs once the interior follows.
    """

    x: Floats
    residual: Floats
    condensed: Floats


class Constant(OnInterfaces):
    """Residuals and linear systems on the interfaces of a linear bulk.

    Args:
        equations: The system, condensed, of a linear bulk with interfaces.
        timers: Where time is booked.
    """

    def __init__(self, equations: Condensed, timers: Timers) -> None:
        super().__init__(equations, timers)
        self._held = Held(self.system)
        self._factor: SchurFactor | None = None
        self._origin: _Origin | None = None

    def begin(self) -> None:
        """Forget the last solve; its factor stays."""
        super().begin()
        self._origin = None

    def residual(self, x: PETSc.Vec, out: PETSc.Vec, jumps: Sequence[Floats | None]) -> None:
        """As that of `Direct`; after the first iteration, that which the interior leaves over."""
        if self._origin is None:
            super().residual(x, out, jumps)
            self._rows = self._held.residual(out.array_r, self.parts)
            return
        self.system.spread(x)
        moved = x.array_r[self.unknowns] - self._origin.x
        self._rows = self._origin.condensed + self._answer @ moved
        out.set(0.0)
        out.array[self.unknowns] = self._rows[: len(moved)]

    def reactions(self) -> list[float]:
        """As those of `Direct`."""
        held = len(self._rows) - len(self._held.numbers)
        return [float(v) for v in self._held.motions @ self._rows[held:]]

    def linearise(self, at: Iterate) -> PETSc.Mat:
        """As that of `Direct`, on the interfaces."""
        if self._factor is None:
            self._factor = self._factorise()
        self._inner: Floats = np.zeros(len(self.unknowns))
        if self._origin is None:
            with self.timers.book("solve"):
                condensed = self._factor.condense(self._rows)
            x = self.system.x.array_r[self.unknowns]
            self._origin = _Origin(x, self._rows, condensed)
            self._inner = (condensed - self._rows[self._factor.kept])[: len(x)]
        self.matrix.fill(self._S, at.conditions)
        self.damping = at.damping
        return self.operator

    def _factorise(self) -> SchurFactor:
        """Factor of the bulk that gives the interfaces and the reactions away."""
        with self.timers.book("assembly"):
            K = self._held.matrix()
        with self.timers.book("factorisation"):
            kept = np.concatenate((self.unknowns, self._held.numbers))
            factor = SchurFactor(K, kept, symmetric=True)
            factor.factorise()
        self._answer = factor.S[:, : len(self.unknowns)]  # with the rows of the held dofs
        self._S = self._answer[: len(self.unknowns)]
        return factor

    def step(self, residual: Floats) -> Floats:
        """Newton's step at the interfaces; the interior's is left for the end."""
        result = np.zeros(len(residual))
        result[self.unknowns] = self.matrix.solve(self._inner, residual[self.unknowns])
        return result

    def finish(self, x: PETSc.Vec) -> None:
        """Let the interior follow, and the bodies."""
        if self._origin is None or self._factor is None:
            return
        moved = np.zeros(len(self._factor.kept))
        moved[: len(self.unknowns)] = x.array_r[self.unknowns] - self._origin.x
        with self.timers.book("solve"):
            change = self._factor.expand(-self._origin.residual, -self._origin.condensed, moved)
        interior = np.ones(len(x.array_r), bool)
        interior[self.unknowns] = False
        x.array[interior] += change[: len(interior)][interior]
        self.system.spread(x)
