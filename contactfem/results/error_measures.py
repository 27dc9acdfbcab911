"""Measures of estimated errors and their cost."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from contactfem.results.data import ErrorStep, StepReport
from contactfem.results.relative_error import error_ratio

if TYPE_CHECKING:
    from contactfem.case.schema import Case

PROBLEMS = ("mechanics", "heat", "time")
ORDER, DIMENSION = 1, 2  # of the elements; of the meshes


def measurable_errors(case: Case) -> dict[str, str]:
    """Names of all numbers about errors that a run of the case can measure; none has a unit."""
    if case.adaptivity is None:
        return {}
    names = ["remeshes", "steps.repeated", "cost.estimate_share", "cost.remesh_steps"]
    given = {
        "mechanics": case.adaptivity.for_mechanics() if case.mechanics else None,
        "heat": case.adaptivity.for_heat() if case.heat is not None else None,
        "time": case.adaptivity.for_time() if case.heat is not None else None,
    }
    for problem in PROBLEMS:
        if given[problem] is not None:
            names += [f"error.{problem}.last", f"error.{problem}.max"]
    names += [f"cells.{body}" for body in case.bodies]
    if case.heat is not None:
        names += [f"thermal_cells.{body}" for body in case.bodies]
    times = {"time.step.min": "s", "time.step.max": "s", "time.step.last": "s"}
    return dict.fromkeys(names, "") | times


def errors_of_steps(steps: Sequence[StepReport]) -> dict[str, float]:
    """Errors of the last step and the largest ones; meshes and steps."""
    found = [step.errors for step in steps if step.errors is not None]
    if not found:
        return {}
    values = {
        "remeshes": float(len(remesh_events(steps))),
        "steps.repeated": float(sum(errors.repeats for errors in found)),
        "time.step.min": min(step.dt for step in steps),
        "time.step.max": max(step.dt for step in steps),
        "time.step.last": steps[-1].dt,
    }
    for problem in PROBLEMS:
        known = [eta for errors in found if (eta := getattr(errors, problem)) is not None]
        if known:
            values |= {f"error.{problem}.last": known[-1], f"error.{problem}.max": max(known)}
    last = found[-1]
    values |= {f"cells.{body}": float(count) for body, count in last.cells.items()}
    return values | {f"thermal_cells.{b}": float(count) for b, count in last.thermal_cells.items()}


def errors_of_costs(timings: Mapping[str, float], steps: Sequence[StepReport]) -> dict[str, float]:
    """Share of estimates and decisions in a step, and the cost of new meshes in steps."""
    wall, remesh = sum(step.wall for step in steps), timings.get("remesh", 0.0)
    events, solved = len(remesh_events(steps)), wall - remesh
    if "estimate" not in timings or solved <= 0.0:
        return {}
    values = {"cost.estimate_share": timings["estimate"] / solved}
    return values | ({"cost.remesh_steps": remesh / events * len(steps) / solved} if events else {})


def remesh_events(steps: Sequence[StepReport]) -> list[tuple[float, float]]:
    """Times at which new meshes were made [s], and what that took [s]; one for all bodies."""
    events: list[tuple[float, float]] = []
    for step in steps:
        new = step.errors.remeshes if step.errors is not None else ()
        for one in new:
            if not events or events[-1] != (one.t, one.seconds):
                events.append((one.t, one.seconds))
    return events


@dataclass(frozen=True)
class UniformCost:
    """What the error of one problem would cost on the first mesh, refined everywhere alike.

    Attributes:
        problem: "mechanics" or "heat".
        eta: Error that was reached in the end.
        cells: Cells of its meshes in the end.
        first_eta: Error on the first meshes.
        first_cells: Cells of these.
        uniform_cells: Cells of uniform refinement, predicted from the first error and its order.
    """

    problem: str
    eta: float
    cells: int
    first_eta: float
    first_cells: int
    uniform_cells: float


def uniform_costs(steps: Sequence[StepReport]) -> list[UniformCost]:
    """Predicted cost of uniform meshes of the same error, where the first ones were replaced.

    (η_first/η)^(d/p) times the cells of the first meshes, with ‖e‖/‖v‖ for η.

    Args:
        steps: Accepted steps.
    """
    found = [step.errors for step in steps if step.errors is not None]
    costs = []
    for problem in ("mechanics", "heat"):
        first = [new for errors in found for new in errors.remeshes if new.problem == problem]
        eta = getattr(found[-1], problem) if found else None
        if not first or not eta:
            continue
        replaced = {new.body: new.cells_before for new in first[::-1]}
        before = _first_cells(found[0], problem, replaced)
        ratio = error_ratio(first[0].eta) / error_ratio(eta)
        cells = sum(_cells(found[-1], problem).values())
        uniform = before * math.pow(ratio, DIMENSION / ORDER)
        costs.append(UniformCost(problem, eta, cells, first[0].eta, before, uniform))
    return costs


def _cells(errors: ErrorStep, problem: str) -> Mapping[str, int]:
    return errors.cells if problem == "mechanics" else errors.thermal_cells


def _first_cells(errors: ErrorStep, problem: str, replaced: Mapping[str, int]) -> int:
    """Cells of the first meshes: of those that were replaced, and of those that stayed."""
    return sum(replaced.get(body, count) for body, count in _cells(errors, problem).items())
