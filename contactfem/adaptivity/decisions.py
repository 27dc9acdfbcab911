"""The fate of a step: advance, repeat, remesh or give up."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from contactfem.common.typing import Floats
from contactfem.results.data import ErrorStep


@dataclass(frozen=True)
class NewSizes:
    """Sizes that new meshes should have, at the vertices of the present ones [m], by body.

    Bodies that are not named keep their mesh.
    """

    mechanical: Mapping[str, Floats]
    thermal: Mapping[str, Floats]


@dataclass(frozen=True)
class Advance:
    """Accept the step and go on.

    Attributes:
        dt: Length of the next step [s]; None leaves it to Newton's method.
        errors: Errors of the accepted step; None where none are estimated.
        within: Whether its error is within the tolerance.
        reason: Why, for people.
    """

    dt: float | None
    errors: ErrorStep | None = None
    within: bool = True
    reason: str = ""


@dataclass(frozen=True)
class RepeatStep:
    """Go back to the start of the last one or two steps, and on with another length.

    Attributes:
        dt: Length of the step [s].
        back: Steps to go back: the present one, or also the one before it.
        reason: Why, for people.
    """

    dt: float
    back: int = 1
    reason: str = ""


@dataclass(frozen=True)
class RemeshAndRepeat:
    """Take the step again on meshes of these sizes."""

    sizes: NewSizes


@dataclass(frozen=True)
class GiveUp:
    """End the run: no smaller step is allowed."""

    reason: str


Decision = Advance | RepeatStep | RemeshAndRepeat


@dataclass(frozen=True)
class MeshHistory:
    """What accepted steps left behind.

    Attributes:
        square: ∫ ⟨ż, ż⟩ dt.
        span: ∫ dt of the steps that count there [s].
        age: Steps on the present meshes, by problem.
        life: Steps that the last replaced meshes lasted, by problem.
        gained: Part of the error that the present meshes took away when they were made, by problem.
    """

    square: float = 0.0
    span: float = 0.0
    age: Mapping[str, int] = field(default_factory=dict)
    life: Mapping[str, int] = field(default_factory=dict)
    gained: Mapping[str, float] = field(default_factory=dict)

    @property
    def mean_square(self) -> float:
        """Mean of ⟨ż, ż⟩ over the run so far."""
        return self.square / self.span if self.span > 0.0 else 0.0

    def expected(self, problem: str) -> float:
        """Steps that a new mesh may last: as many as the last one, or as the present one has."""
        known = problem in self.life
        return max(self.life[problem], self.age.get(problem, 0)) if known else math.inf

    def next(
        self, square: float, span: float, rounds: Mapping[str, int], gained: Mapping[str, float]
    ) -> "MeshHistory":
        """After one more step.

        Args:
            square: ⟨ż, ż⟩ dt of the step.
            span: Its dt, if it counts there [s].
            rounds: New meshes that were made for it, by problem.
            gained: Part of the error that they took away, by problem.
        """
        new = {problem for problem, count in rounds.items() if count}
        ends = {p: age for p, age in self.age.items() if p in new and age > 0}
        age = {p: (0 if p in new else self.age.get(p, 0)) + 1 for p in ("mechanics", "heat")}
        return MeshHistory(
            self.square + square,
            self.span + span,
            age,
            {**self.life, **ends},
            {**self.gained, **gained},
        )
