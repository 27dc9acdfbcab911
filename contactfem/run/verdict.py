"""Verdict on a run's heat."""

from collections.abc import Iterator, Sequence

from contactfem.case.schema import Case
from contactfem.case.temperature_scale import responds_to_temperature
from contactfem.results.data import HeatStep, StepReport

NOTABLE = 0.01  # share of the range of temperatures that is said


def heat_verdict(case: Case, steps: Sequence[StepReport]) -> Iterator[str]:
    """What is to be doubted of the temperatures of a run as a whole.

    Args:
        case: The case.
        steps: Its steps.

    Yields:
        A sentence about each.
    """
    found = [(step.t, step.heat) for step in steps if step.heat is not None]
    if not found or case.heat is None:
        return
    t, worst = max(found, key=lambda each: each[1].outside)
    if worst.outside > NOTABLE:
        yield _outside(t, worst)
    t, worst = max(found, key=lambda each: each[1].change)
    lags = case.mechanics and case.heat.max_passes == 1 and responds_to_temperature(case)
    if lags and worst.change > NOTABLE:
        yield (
            f"mechanics of a step took temperatures that its heat changed by up to "
            f"{100 * worst.change:.2g} % of their range (t = {t:g} s): leave heat.max_passes out, "
            "or take smaller steps"
        )


def _outside(t: float, step: HeatStep) -> str:
    low, high = step.bounds
    bounds = " and ".join(
        f"{word} {value:.5g} K"
        for word, value in (("above", low), ("below", high))
        if value is not None
    )
    return (
        f"temperatures must stay {bounds}, and leave that by up to {100 * step.outside:.2g} % of "
        f"their range (t = {t:g} s): take thinner cells where they jump, longer steps, or, with a "
        "scheme cG, an L-stable one such as dG(1)"
    )
