"""Rules for new meshes and time steps, from reports of errors."""

import math
from dataclasses import dataclass

from contactfem.adaptivity.decisions import Advance, RepeatStep
from contactfem.common.text import percent
from contactfem.results.relative_error import error_ratio


@dataclass(frozen=True)
class MeshPolicy:
    """When a mesh is replaced.

    Attributes:
        tolerance: Largest relative error η (40), a ratio of norms.
        aim: Error that new meshes are made for, over the tolerance: a margin before the next one.
        most_remeshes: New meshes in one step, at most.
        cost: What a new mesh costs with its transfer, in steps on the present one.
        margin: What coarsening must gain, over that cost.
        least_improvement: Part of the error ‖e‖/‖v‖ that a finer mesh must take away to be worth
            making.
        least_in_limits: The same where limits leave it an error beyond the tolerance.
    """

    tolerance: float
    aim: float = 0.8
    most_remeshes: int = 3
    cost: float = 3.0
    margin: float = 2.0
    least_improvement: float = 0.05
    least_in_limits: float = 0.1


@dataclass(frozen=True)
class MeshReport:
    """A mesh after a step, beside the one that would replace it.

    Attributes:
        eta: Relative error of the step.
        cells: Number of cells.
        predicted_eta: Relative error expected of the new mesh.
        predicted_cells: Number of cells expected of it.
        remeshes: New meshes in this step so far.
        steps_left: Steps to the end at the present length.
        life: Steps that the last mesh lasted; a new one is expected to last as long.
        age: Steps on this mesh.
        gained: Part of the error, as ‖e‖/‖v‖, that this mesh took away when it was made.
        limited: Whether limits of the cells keep the new mesh from being fine enough.
    """

    eta: float
    cells: int
    predicted_eta: float
    predicted_cells: float
    remeshes: int
    steps_left: float
    life: float = math.inf
    age: float = math.inf
    gained: float = 1.0
    limited: bool = False


@dataclass(frozen=True)
class KeepMesh:
    """Go on with this mesh; `within` tells whether its error is within the tolerance."""

    within: bool
    reason: str


@dataclass(frozen=True)
class Remesh:
    """Make the new mesh."""

    reason: str


@dataclass(frozen=True)
class StepPolicy:
    """How the time step follows its error.

    Attributes:
        tolerance: Largest relative error η (40) of a step, a ratio of norms.
        smallest: Smallest step [s].
        largest: Largest step [s].
        most_repeats: Repetitions from one time on, at most.
        safety: Error that new steps are chosen for, over the tolerance.
        cut: Smallest change of the step by one decision.
        growth: Largest change of the step by one decision.
        least_growth: Smaller growth is not worth a new operator.
        order: Power of the step that ‖e‖/‖v‖ falls with: 1 for the rate of cG(1), as a ratio of
            norms. (Their squares, as (40) is printed, fall with 2.)
    """

    tolerance: float
    smallest: float
    largest: float
    most_repeats: int = 4
    safety: float = 0.8
    cut: float = 0.2
    growth: float = 2.0
    least_growth: float = 1.2
    order: float = 1.0


@dataclass(frozen=True)
class TimedStep:
    """Length [s] and relative error η of a step."""

    dt: float
    eta: float


@dataclass(frozen=True)
class TimeReport:
    """A step and the one before it, whose rate may turn out to be wrong only now.

    Attributes:
        newer: The step that was just computed.
        older: The one before it; None if it cannot be computed again.
        repeats: How often steps from here on were repeated.
    """

    newer: TimedStep
    older: TimedStep | None
    repeats: int


def decide_mesh(report: MeshReport, policy: MeshPolicy) -> KeepMesh | Remesh:
    """Keep a mesh or replace it: by a finer one if its error is too large and limits allow it.

    A coarser one has to pay: it saves (1 - n_new/n) of each step for as long as it is expected to
    last, and this has to exceed what a new mesh costs. One that stays too coarse, as limits bind,
    has to be much better.

    Args:
        report: The mesh and the one that would replace it.
        policy: The rules.

    Returns:
        The decision.
    """
    if report.eta > policy.tolerance:
        return _refine(report, policy)
    if report.remeshes:
        return KeepMesh(True, f"an error of {percent(report.eta)} is within the tolerance")
    steps = min(report.steps_left, report.life)
    gain = (1.0 - report.predicted_cells / report.cells) * steps
    change = f"{report.cells} to about {report.predicted_cells:.0f} cells"
    if report.predicted_eta > policy.tolerance:
        return KeepMesh(True, f"{change} would exceed the tolerance")
    if gain <= policy.margin * policy.cost:
        saved = f"{max(gain, 0.0):.2g} steps of work"
        return KeepMesh(True, f"{change} would save {saved}, a new mesh costs {policy.cost:.2g}")
    return Remesh(f"{change} saves {gain:.2g} steps of work, a new mesh costs {policy.cost:.2g}")


def decide_step(report: TimeReport, policy: StepPolicy) -> Advance | RepeatStep:
    """Accept a step or go back and take a smaller one, and choose the length of the next one.

    h_new = h (safety · tolerance / error)^(1/order), with errors as ratios ‖e‖/‖v‖, within limits.
    The error of the older step appears when the rate changes after it: then both are repeated, as
    no length of the newer one would help. The larger error of both counts. A repeated step does not
    grow: what made it small may lie ahead.

    Args:
        report: The step and the one before.
        policy: The rules.

    Returns:
        The decision.
    """
    newer, older = report.newer, report.older
    shortest = policy.smallest * (1.0 + 1e-9)
    wrong, back = newer, 1
    if older is not None and older.eta > newer.eta:
        helpless = older.dt <= shortest and newer.eta > policy.tolerance  # but the newer may help
        wrong, back = (newer, 1) if helpless else (older, 2)
    found = f"an error of {percent(wrong.eta)} against {percent(policy.tolerance)}"
    if wrong.eta <= policy.tolerance:
        # each by its own length: one of them may have been cut to end at a given time
        dt = min(_wanted(step, policy) for step in (newer, older) if step is not None)
        if newer.dt < dt and (report.repeats or dt < policy.least_growth * newer.dt):
            dt = newer.dt
        dt = min(max(dt, policy.smallest), policy.largest)
        return Advance(dt, reason=f"{found}: the next step is {dt:.3g} s")
    if wrong.dt <= shortest:
        reason = f"{found} with the smallest step"
        return Advance(newer.dt, within=False, reason=reason)
    if report.repeats >= policy.most_repeats:
        reason = f"{found} after {report.repeats} repetitions"
        return Advance(newer.dt, within=False, reason=reason)
    dt = max(_wanted(wrong, policy), policy.smallest)
    return RepeatStep(dt, back, f"{found}: back by {back} and on with {dt:.3g} s")


def _refine(report: MeshReport, policy: MeshPolicy) -> KeepMesh | Remesh:
    found = f"an error of {percent(report.eta)} exceeds {percent(policy.tolerance)}"
    if report.remeshes >= policy.most_remeshes:
        return KeepMesh(False, f"{found} after {report.remeshes} new meshes in this step")
    limited = report.limited and report.predicted_eta > policy.tolerance
    # a larger error than before is another solution, of which that mesh says nothing
    same = abs(report.gained) < policy.least_improvement
    idle = same and report.age < policy.margin * policy.cost
    if limited and idle:
        return KeepMesh(False, f"{found}, but limits bind, and the last new mesh gained nothing")
    least = policy.least_in_limits if limited else policy.least_improvement
    if error_ratio(report.predicted_eta) > (1.0 - least) * error_ratio(report.eta):
        expected = percent(report.predicted_eta)
        return KeepMesh(False, f"{found}, but the limits allow no mesh with less than {expected}")
    return Remesh(f"{found}: {report.cells} to about {report.predicted_cells:.0f} cells")


def _wanted(step: TimedStep, policy: StepPolicy) -> float:
    """The length that a step should have had [s], within the limits of one decision."""
    wanted, found = policy.safety * error_ratio(policy.tolerance), error_ratio(step.eta)
    if found == 0.0:
        return policy.growth * step.dt
    change = math.pow(wanted / found, 1.0 / policy.order)
    return min(max(change, policy.cut), policy.growth) * step.dt
