"""Whether Newton's method has converged, or cannot: residual and active set together."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from contactfem.common.typing import Bools, Floats, Ints
from contactfem.contact.state import ContactState

CONVERGED, DIVERGED_LINEAR, DIVERGED_NAN, DIVERGED_ITERATIONS = 2, -3, -4, -5  # as PETSc has them
# Residual that round-off leaves, over stiffness times size: always reached, and where it may stall
ROUND_OFF, STALLED = 4 * np.finfo(float).eps, 64 * np.finfo(float).eps
TURNED_OVER = (
    "the residual is not a number: a cell was turned inside out (shorter steps or other facets "
    "where it happens may help)"
)
UNSETTLED = (
    ", as the contact status does not settle (shorter steps may help, or a c_factor of the "
    "interface and its friction nearer to 1)"
)
LOST = 4  # iterations without the contact that alone holds a body after which it has flown away


class ActiveSets:
    """Active sets of the iterations of one solve.

    Two are the same if every node has the same status and slips the same way: its direction makes
    an acute angle with the first one that the node had.
    """

    def __init__(self) -> None:
        self._first: list[Floats] = []
        self._keys: list[bytes] = []

    def add(self, states: Sequence[ContactState]) -> None:
        """Take those of one more iteration."""
        directions = [c.active_set.direction for c in states]
        if not self._first:
            self._first = [d.copy() for d in directions]
        key = b""
        for c, first, d in zip(states, self._first, directions, strict=True):
            none = ~first.any(axis=1)
            first[none] = d[none]
            sense = np.sign(np.einsum("ji,ji->j", d, first)).astype(np.int8)
            key += c.status.tobytes() + sense.tobytes()
        self._keys.append(key)

    @property
    def unchanged(self) -> bool:
        """Whether the last one is that of the iteration before."""
        return len(self._keys) > 1 and self._keys[-1] == self._keys[-2]

    @property
    def settled(self) -> bool:
        """Whether the iteration before the last one, if there was any, had no other."""
        return self.unchanged or len(self._keys) == 1

    @property
    def comes_back(self) -> bool:
        """Whether the last one has been there before, and was left: the iteration would cycle."""
        left = len(self._keys) > 1 and not self.unchanged
        return left and self._keys.count(self._keys[-1]) > 1


class Outcome(NamedTuple):
    """How a solve ends: PETSc's code, and the reason in words if it failed."""

    code: int
    reason: str = ""


@dataclass(frozen=True)
class Criteria:
    """What a solve is held against.

    Attributes:
        tolerance: Of the scaled residual [-].
        max_iterations: Newton iterations at most.
        known: Whether the first active set is that of an equilibrium found before.
        alone: Numbers of the interfaces that alone hold a body.
    """

    tolerance: float
    max_iterations: int
    known: bool
    alone: frozenset[int]


@dataclass(frozen=True)
class Balance:
    """How far bodies are from equilibrium at an iteration, (bodies,) each.

    Attributes:
        squares: Sums of squares of the residual [N²/m²].
        forces: Size of the forces that the residual is compared with [N/m].
        stiffness: Force that relative round-off is multiplied with [N/m].
        joined: The same number for bodies that contact joins: these are judged together, others
            each by its own forces, however large those of the rest.
    """

    squares: Floats
    forces: Floats
    stiffness: Floats
    joined: Ints


class Convergence:
    """The course of one solve, and four questions to it.

    Args:
        criteria: What it is held against.

    Attributes:
        residuals: Scaled residual of every iteration [-].
        active_sets: Of every iteration.
    """

    def __init__(self, criteria: Criteria) -> None:
        self._criteria = criteria
        self.residuals: list[float] = []
        self.active_sets = ActiveSets()
        self._initial: Floats = np.zeros(1)
        self._norm = self._forces = self._scale = self._floor = np.zeros(1)  # of joined bodies
        self._contact_kept = False
        self._touching: list[list[bool]] = []

    def add(self, balance: Balance, states: Sequence[ContactState], contact_kept: bool) -> None:
        """Take one more iteration.

        Args:
            balance: Of the bodies.
            states: Contact of every interface.
            contact_kept: Whether contact that was just lost is kept for this iteration.
        """
        if not self.residuals:
            self._initial = np.where(np.isfinite(balance.squares), balance.squares, 0.0)
        members = balance.joined == np.unique(balance.joined)[:, None]
        self._norm = np.sqrt((members * balance.squares).sum(1))
        self._forces = (members * balance.forces).max(1)
        self._scale = np.maximum(np.sqrt((members * self._initial).sum(1)), self._forces)
        self._floor = (members * balance.stiffness).max(1)
        self._contact_kept = contact_kept
        self.residuals.append(self._scaled())
        self.active_sets.add(states)
        self._touching.append([bool(c.active.any()) for c in states])

    def _scaled(self) -> float:
        """Largest scaled residual of the groups; what is round-off counts by all forces."""
        scale = np.where(self._norm <= ROUND_OFF * self._floor, self._scale.max(), self._scale)
        return float(np.divide(self._norm, scale, out=np.zeros_like(scale), where=scale > 0).max())

    @property
    def _is_small(self) -> Bools:
        floor = ROUND_OFF * self._floor
        return self._norm <= np.maximum(self._criteria.tolerance * self._scale, floor)

    @property
    def residual_small(self) -> bool:
        """Whether every group's residual is below the tolerance, or is round-off."""
        return bool(self._is_small.all())

    @property
    def stalled(self) -> bool:
        """Whether the residual is near round-off and does not shrink any more."""
        near = bool((self._is_small | (self._norm <= STALLED * self._floor)).all())
        return near and len(self.residuals) > 1 and self.residuals[-1] > 0.5 * self.residuals[-2]

    @property
    def force_free(self) -> bool:
        """Whether there is no force but round-off: surfaces may touch without it."""
        largest = np.maximum(self._norm, self._forces)
        return bool((largest <= ROUND_OFF * self._floor).all())

    @property
    def active_set_unchanged(self) -> bool:
        """Whether the active set is that of the iteration before, or could be.

        A node on the limit of friction or of contact may change status by round-off for ever: if
        the residual is small with either status, both describe the same equilibrium. Contact that
        is only kept for one iteration is none.
        """
        small = self.residuals[-2:]
        unchanged = (
            self.active_sets.unchanged
            or (len(self.residuals) == 1 and self._criteria.known)
            or (len(small) == 2 and max(small) <= self._criteria.tolerance)
        )
        return unchanged and (not self._contact_kept or self.force_free)

    def outcome(self) -> Outcome | None:
        """How the solve ends at this iteration; None if it goes on."""
        if not np.isfinite(self._norm).all():
            return Outcome(DIVERGED_NAN, TURNED_OVER)
        unchanged = self.active_set_unchanged
        if unchanged and (self.residual_small or self.stalled):
            return Outcome(CONVERGED)
        if self._contact_lost():
            lost = f"contact that alone holds a body is lost for {LOST} iterations"
            return Outcome(DIVERGED_ITERATIONS, lost)
        iterations = len(self.residuals) - 1
        if iterations >= self._criteria.max_iterations:
            why = f"no convergence in {iterations} iterations{'' if unchanged else UNSETTLED}"
            return Outcome(DIVERGED_ITERATIONS, why)
        return None

    def _contact_lost(self) -> bool:
        """Whether an interface that alone holds a body had no contact for some iterations."""
        recent = self._touching[-LOST:]
        return len(recent) == LOST and any(
            not any(touching[k] for touching in recent) for k in self._criteria.alone
        )

    def reached(self) -> str:
        """How far the residual got, in words."""
        found = [residual for residual in self.residuals if np.isfinite(residual)]
        if not found:
            return "no residual before that"
        last = f"the last residual is {found[-1]:.1e}, the smallest {min(found):.1e}"
        return f"{last}, and {self._criteria.tolerance:.0e} is asked for"
