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
from contactfem.contact import Conditions
from contactfem.direct import Direct
from contactfem.held import Held
from contactfem.interface_matrix import InterfaceMatrix, interface_unknowns
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


class Constant(Direct):
    """Residuals and linear systems on the interfaces of a linear bulk.

    Args:
        equations: The system, condensed, of a linear bulk with interfaces.
        timers: Where time is booked.
    """

    def __init__(self, equations: Condensed, timers: Timers) -> None:
        super().__init__(equations, {}, timers)
        n = self.system.numbering.n_global
        self._held = Held(self.system)
        self._unknowns = interface_unknowns(equations.interfaces)
        self._matrix = InterfaceMatrix(equations.interfaces, self._unknowns, n, timers)
        self._factor: SchurFactor | None = None
        self._origin: _Origin | None = None
        self._damping = 1.0
        self._operator = PETSc.Mat().createPython(((n, n), (n, n)), self, comm=self.system.comm)
        self._operator.setUp()

    def attach(self, snes: PETSc.SNES) -> PETSc.Mat:
        """Solve the linear systems here."""
        snes.ksp.setType(PETSc.KSP.Type.PREONLY)
        pc = snes.ksp.getPC()
        pc.setType(PETSc.PC.Type.PYTHON)
        pc.setPythonContext(self)
        return self._operator

    def begin(self) -> None:
        """Forget the last solve; its factor stays."""
        self._origin = None

    def residual(self, x: PETSc.Vec, out: PETSc.Vec, jumps: Sequence[Floats | None]) -> None:
        """As that of `Direct`; after the first iteration, that which the interior leaves over."""
        if self._origin is None:
            super().residual(x, out, jumps)
            self._rows = self._held.residual(out.array_r, self.parts)
            return
        self.system.spread(x)
        moved = x.array_r[self._unknowns] - self._origin.x
        self._rows = self._origin.condensed + self._schur() @ moved
        out.set(0.0)
        out.array[self._unknowns] = self._rows[: len(moved)]

    def reactions(self) -> list[float]:
        """As those of `Direct`."""
        return [float(v) for v in self._held.motions @ self._rows[-len(self._held.numbers) :]]

    def linearise(
        self, conditions: Sequence[Conditions], jumps: Sequence[Floats | None], damping: float
    ) -> PETSc.Mat:
        """As that of `Direct`, on the interfaces."""
        if self._factor is None:
            self._factor = self._factorise()
        self._inner = np.zeros(len(self._unknowns))
        if self._origin is None:
            with self.timers.book("solve"):
                condensed = self._factor.condense(self._rows)
            x = self.system.x.array_r[self._unknowns]
            self._origin = _Origin(x, self._rows, condensed)
            self._inner = (condensed - self._rows[self._factor.kept])[: len(x)]
        self._matrix.fill(self._schur()[: len(self._unknowns)], conditions)
        self._damping = damping
        return self._operator

    def _factorise(self) -> SchurFactor:
        """Factor of the bulk that gives the interfaces and the reactions away."""
        with self.timers.book("assembly"):
            K = self._held.matrix()
        with self.timers.book("factorisation"):
            kept = np.concatenate((self._unknowns, self._held.numbers))
            factor = SchurFactor(K, kept, symmetric=True)
            factor.factorise()
        return factor

    def _schur(self) -> Floats:
        """Rows of the interfaces and held dofs, columns of the interfaces."""
        assert self._factor is not None
        return self._factor.S[:, : len(self._unknowns)]

    def apply(self, pc: PETSc.PC, b: PETSc.Vec, y: PETSc.Vec) -> None:
        """Newton's step at the interfaces; the interior's is left for the end."""
        y.set(0.0)
        right = b.array_r[self._unknowns]
        y.array[self._unknowns] = self._damping * self._matrix.solve(self._inner, right)

    def finish(self, x: PETSc.Vec) -> None:
        """Let the interior follow, and the bodies."""
        if self._origin is None or self._factor is None:
            return
        moved = np.zeros(len(self._factor.kept))
        moved[: len(self._unknowns)] = x.array_r[self._unknowns] - self._origin.x
        with self.timers.book("solve"):
            change = self._factor.expand(-self._origin.residual, -self._origin.condensed, moved)
        interior = np.ones(len(x.array_r), bool)
        interior[self._unknowns] = False
        x.array[interior] += change[: len(interior)][interior]
        self.system.spread(x)
