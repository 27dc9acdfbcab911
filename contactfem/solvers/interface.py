"""What Newton's method asks of a linear solver."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from petsc4py import PETSc

from contactfem.common.typing import Floats
from contactfem.contact.state import ContactState


@dataclass(frozen=True)
class Iterate:
    """Where Newton's method is.

    Attributes:
        states: Contact state of every interface.
        jumps: Of `System.advance` in the first iteration, else all None.
        damping: Share of the coming step that is taken.
        residuals: Scaled residuals of the solve so far [-].
        tolerance: What they must come to [-].
        settled: Whether the active set is that of the iteration before.
    """

    states: Sequence[ContactState]
    jumps: Sequence[Floats | None]
    damping: float
    residuals: Sequence[float]
    tolerance: float
    settled: bool


class SupportForces(NamedTuple):
    """What prescribed motions exert, contact forces on their nodes left out.

    Attributes:
        reactions: Resultant of every one on its body [N/m].
        by_body: Sum of all on each body, each dof once [N/m], (bodies, dim).
    """

    reactions: list[float]
    by_body: Floats


class LinearSolver(Protocol):
    """Residuals of the bulk and linear systems of Newton's method for a system with contact.

    Attributes:
        options: PETSc options that it needs.
        reuses: Whether a factor may serve longer than one iteration.
        failure: Why the last linear system had no solution, in words; else empty.
    """

    options: Mapping[str, str]
    reuses: bool
    failure: str

    def attach(self, snes: PETSc.SNES) -> PETSc.Mat:
        """Prepare PETSc's solver, after its options; returns a matrix to start with."""

    def begin(self) -> None:
        """Begin a new solve."""

    def residual(
        self, x: PETSc.Vec, out: PETSc.Vec, jumps: Sequence[Floats | None]
    ) -> SupportForces:
        """Residual without contact at some unknowns, which the bodies take over; collective.

        Args:
            x: The unknowns.
            out: Receives the residual [N/m].
            jumps: Of `System.advance` in the first iteration, else all None.

        Returns:
            What prescribed motions exert.
        """

    def linearise(self, at: Iterate) -> PETSc.Mat:
        """Operator of the next linear system, the tangent over the damping; collective.

        It is factorised here, so that the time is booked.
        """

    def finish(self, x: PETSc.Vec) -> None:
        """Complete the unknowns of a solution; collective."""
