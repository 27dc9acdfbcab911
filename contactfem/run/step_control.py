"""Step control: pure decisions from reports."""

from collections.abc import Sequence
from dataclasses import dataclass

from contactfem.adaptivity.decisions import GiveUp, RepeatStep

EASY_ITERATIONS = 8  # a solve with no more iterations than these is easy
EASY_STEPS = 2  # easy solves in a row before the step grows


@dataclass(frozen=True)
class StepLimits:
    """Limits of the step: end of time, smallest and largest step [s]; cut-backs of one step."""

    end: float
    smallest: float
    largest: float
    max_cutbacks: int


def after_failure(dt: float, cutbacks: int, limits: StepLimits) -> RepeatStep | GiveUp:
    """What to do when a step failed: half of it, unless a limit is reached.

    Args:
        dt: The step that failed [s].
        cutbacks: How often this step was cut already.
        limits: Limits of the step.

    Returns:
        The decision.
    """
    if cutbacks >= limits.max_cutbacks:
        return GiveUp(
            f"the smallest step tried is {dt:g} s, cut {cutbacks} times; "
            "a larger solver.max_cutbacks allows more"
        )
    if 0.5 * dt < limits.smallest * (1.0 - 1e-12):
        return GiveUp(
            f"the smallest step tried is {dt:g} s; "
            f"a smaller time.step_min than {limits.smallest:g} s allows more"
        )
    return RepeatStep(0.5 * dt)


def after_success(dt: float, iterations: Sequence[int], limits: StepLimits) -> float:
    """The next step: twice as large after a few easy solves.

    Args:
        dt: The step that was accepted [s].
        iterations: Newton iterations of the solves accepted so far with this step.
        limits: Limits of the step.

    Returns:
        Next step [s].
    """
    recent = iterations[-EASY_STEPS:]
    if len(recent) == EASY_STEPS and max(recent) <= EASY_ITERATIONS:
        return min(2.0 * dt, limits.largest)
    return min(dt, limits.largest)


def clipped(t: float, dt: float, stops: Sequence[float]) -> float:
    """A step that ends at the next stop if it would pass it, and halves what two would pass.

    A short last step has the error of a short step, but that of the recovery over it and the long
    one before.

    Args:
        t: Start of the step [s].
        dt: Wanted step [s].
        stops: Times that a step must end at, ascending [s].

    Returns:
        The step [s].
    """
    for stop in stops:
        if stop > t + 1e-9 * dt:
            left = stop - t
            if left <= dt * (1.0 + 1e-9):
                return left
            return 0.5 * left if left < 2.0 * dt * (1.0 - 1e-9) else dt
    return dt
