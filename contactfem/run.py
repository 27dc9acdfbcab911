"""Run a case: the loop over load steps."""

from __future__ import annotations

import copy
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mpi4py import MPI

from contactfem.balance import defects
from contactfem.case import Case
from contactfem.contact import Conditions
from contactfem.control import GiveUp, StepLimits, after_failure, after_success, clipped
from contactfem.diagnosis import explain
from contactfem.discretise import Discretisation, discretise
from contactfem.errors import about
from contactfem.gathering import body_pictures, heat_pictures, interface_tables, probe_values
from contactfem.laws import Status, Trial
from contactfem.newton import NewtonSolver, SolveReport, StepInput
from contactfem.recorder import Recorder
from contactfem.results import ErrorStep, RunResult, StepReport
from contactfem.scene import Condition
from contactfem.state import State, initial_state
from contactfem.surfaces import Bools, Floats
from contactfem.tables import Table
from contactfem.timers import Timers
from contactfem.verdicts import Accept, NewMeshes, ShorterStep, Verdict

if TYPE_CHECKING:
    from contactfem.adapt import Adaptation
    from contactfem.staggered import HeatOutcome
    from contactfem.thermal import Thermal

TOUCH = 1e-9  # gap over facet length at which surfaces touch
FIRST_CONTACT = 0.3  # share of the range of gaps that sticks first where contact alone holds a body


@dataclass(frozen=True)
class Invocation:
    """How a run was started: the command that repeats it, and what imports took before it [s]."""

    command: str
    import_seconds: float


def run_case(
    case: Case, comm: MPI.Comm, out: Path | None, invocation: Invocation | None = None
) -> RunResult:
    """Solve a case from time zero to its end; collective.

    Args:
        case: The case.
        comm: All ranks.
        out: Folder for the results, None to write nothing.
        invocation: How it was started, from the command line.

    Returns:
        The results; pictures and probes on the first rank only. If the solver gave up they are
        those of the last good state, with the reason in `message`.

    Raises:
        CaseError: The case does not fit its meshes.
    """
    with about(case.path):
        return _run(case, comm, out, invocation or Invocation(f"contactfem run {case.path}", 0.0))


def _run(case: Case, comm: MPI.Comm, out: Path | None, invocation: Invocation) -> RunResult:
    """Solve a case; collective."""
    start = time.perf_counter() - invocation.import_seconds
    timers = Timers()
    timers.add("import", invocation.import_seconds)
    discretisation = discretise(case, comm, timers)
    solver = _solver(case, discretisation, timers) if case.mechanics else None
    with Recorder(case, comm, out, discretisation, timers, invocation.command) as recorder:
        loop = _Loop(case, discretisation, solver, recorder, timers)
        message = loop.run()
        loop.flush()
        timers.add("total", time.perf_counter() - start)
        result = _result(case, loop.discretisation, loop, timers, message)
        recorder.finish(result)
    return result


def _solver(case: Case, discretisation: Discretisation, timers: Timers) -> NewtonSolver:
    return NewtonSolver(
        discretisation.system,
        discretisation.interfaces,
        case.solver.tolerance,
        case.solver.max_iterations,
        case.solver.petsc,
        timers,
    )


class _Loop:
    """Steps from zero to the end; each is tried with smaller lengths until it is solved."""

    def __init__(
        self,
        case: Case,
        discretisation: Discretisation,
        solver: NewtonSolver | None,
        recorder: Recorder,
        timers: Timers,
    ) -> None:
        self.case, self.discretisation = case, discretisation
        self.solver, self.recorder = solver, recorder
        self.heat = _HeatSide(case, discretisation.heat, solver) if discretisation.heat else None
        self.timers = timers
        self.ramp_end = case.time.step
        self.state = initial_state(discretisation, self.ramp_end)
        self.adaptation = _adaptation(case, discretisation, timers)
        self.before: State | None = None
        self.pending: tuple[StepReport, State] | None = None
        self.reports: list[StepReport] = []
        self.warnings: list[str] = []
        self.limits = StepLimits(
            case.time.end, case.time.step_min, case.time.step_max, case.solver.max_cutbacks
        )
        self.stops = _stops(case)
        self.reactions: list[float] = []
        self.alone = self._alone()

    def _alone(self) -> frozenset[int]:
        """Interfaces of which only contact holds a body."""
        names = [interface.name for interface in self.discretisation.interfaces]
        return frozenset(k for k, name in enumerate(names) if self._alone_holds(name))

    def run(self) -> str:
        """Go to the end; an empty string, or why it was not reached."""
        dt = self.case.time.step
        easy: list[int] = []
        while self.state.t < self.case.time.end * (1.0 - 1e-12):
            begun, cutbacks = time.perf_counter(), 0
            while True:
                step = clipped(self.state.t, dt, self.stops)
                solved, heat = self._attempt(self.state.t + step)
                decision = after_failure(step, cutbacks, self.limits)
                if solved.converged and (not solved.doubt or isinstance(decision, GiveUp)):
                    verdict = self._judge(heat, self.state.t + step)
                    if isinstance(verdict, Accept):
                        break
                    dt, easy = self._again(verdict, dt), []
                    continue
                self.state.restore(self.discretisation)
                reason = solved.doubt or self._why(solved)
                if isinstance(decision, GiveUp):
                    return (
                        f"{self.case.path}: no equilibrium found at t = {self.state.t + step:g} s: "
                        f"{reason}; {decision.reason}. The last good state, "
                        f"t = {self.state.t:g} s, is written"
                    )
                self.recorder.failure(self.state.t + step, reason, decision.dt)
                dt, cutbacks, easy = decision.dt, cutbacks + 1, []
            if solved.doubt:
                self._warn(f"step to t = {self.state.t + step:g} s: {solved.doubt}")
            wall = time.perf_counter() - begun
            report = self._accept(step, solved, heat, cutbacks, wall, verdict.errors)
            easy.append(report.iterations)
            grown = after_success(dt, easy, self.limits) if verdict.dt is None else verdict.dt
            dt, easy = grown, easy if grown == dt else []
        return ""

    def _judge(self, heat: HeatOutcome | None, t: float) -> Verdict:
        """What becomes of a step that was solved; collective."""
        if self.adaptation is None:
            return Accept(None, None)
        conditions = self.solver.conditions if self.solver is not None else []
        return self.adaptation.judge(self.state, conditions, heat, t)

    def _again(self, verdict: NewMeshes | ShorterStep, dt: float) -> float:
        """Prepare to take the step again, on new meshes or with another length; returns that."""
        if isinstance(verdict, NewMeshes):
            self._take_new_meshes(verdict)
            return dt
        if verdict.back == 2 and self.before is not None:
            self.state, self.before, self.pending = self.before, None, None
            self.state.repeatable = False
            self.reports.pop()
        self.state.restore(self.discretisation)
        return verdict.dt

    def _take_new_meshes(self, verdict: NewMeshes) -> None:
        """Go on with new meshes from the last good state; collective."""
        from contactfem.remesh import carried, new_meshes

        assert self.adaptation is not None
        begun = time.perf_counter()
        self.flush()
        with self.timers.book("remesh"):
            old, comm = self.discretisation, self.discretisation.system.comm
            given = new_meshes(self.case, old, verdict.sizes)
            new = discretise(self.case, comm, self.timers, given)
            self.state = carried(old, new, self.state, self.ramp_end)
            self.before = None
            self.discretisation = new
            self.solver = _solver(self.case, new, self.timers) if self.case.mechanics else None
            self.heat = _HeatSide(self.case, new.heat, self.solver) if new.heat else None
            self.alone = self._alone()
            self.adaptation.remeshed(old, new, self.state.t, time.perf_counter() - begun)
        self.recorder.remeshed(new)

    def flush(self) -> None:
        """Record the last accepted step, if it was kept back because it could be taken again."""
        if self.pending is not None:
            report, state = self.pending
            self.pending = None
            state.restore(self.discretisation)
            self.recorder.step(report, state)
            self.state.restore(self.discretisation)

    def _record(self, report: StepReport) -> None:
        """Record an accepted step; with steps that follow their error only after the next one."""
        self.flush()
        if self.adaptation is None or not self.adaptation.repeats:
            self.recorder.step(report, self.state)
        else:
            self.pending = report, copy.copy(self.state)

    def _warn(self, text: str) -> None:
        """Accept what no smaller step mends, but say so."""
        self.warnings.append(text)
        self.recorder.warning(text)

    def _why(self, solved: SolveReport) -> str:
        """Why a solve failed: what the solver says, and what the contact status says."""
        held = {self.discretisation.interfaces[k].name for k in self.alone}
        history = self.solver.history if self.solver is not None else []
        status = explain(self.discretisation.interfaces, history, held)
        return f"{solved.reason}; {status}" if status else solved.reason

    def _alone_holds(self, name: str) -> bool:
        """Whether only contact can hold a body of an interface."""
        sides = self.case.interfaces[name]
        bodies = {side.partition(".")[0] for side in (sides.nonmortar, sides.mortar)}
        return not bodies.isdisjoint(self.discretisation.unheld)

    def _attempt(self, t: float) -> tuple[SolveReport, HeatOutcome | None]:
        starts = tuple(self._start(k) for k in range(len(self.discretisation.interfaces)))
        known = bool(self.state.conditions) or not starts
        histories = tuple(
            replace(history, dt=t - self.state.t, temperature=self._temperature(k, t))
            for k, history in enumerate(self.state.histories)
        )
        step = StepInput(t, self.ramp_end, histories, starts, known, self.alone)
        if self.heat is not None:
            return self.heat.driver.attempt(
                step, self.state.t, self.state.theta, self.state.thermal_u
            )
        assert self.solver is not None
        return self.solver.solve(step), None

    def _temperature(self, k: int, t: float) -> float:
        """Relative temperature of the nonmortar body of an interface at a time [K]."""
        sides = self.case.interfaces[self.discretisation.interfaces[k].name]
        return self.case.bodies[sides.nonmortar.partition(".")[0]].temperature(t)

    def _start(self, k: int) -> Trial | None:
        """Status that the first iteration of a step takes for an interface.

        That of the last step where there was contact: with a linear bulk and loads that grow in
        proportion it stays right, and a trial state would not know which of the nodes on the limit
        of friction slip. At a first contact a guess; None where there is none to make.
        """
        if (start := self.state.starts()[k]) is not None:
            return start
        interface = self.discretisation.interfaces[k]
        operators = interface.contact.operators(
            interface.nodes.positions(self.state.t, self.ramp_end)
        )
        seen = np.isfinite(operators.gap) & interface.nodes.mesh.carries
        return first_contact(operators.gap, operators.length, seen, k in self.alone)

    def _accept(
        self,
        dt: float,
        solved: SolveReport,
        heat: HeatOutcome | None,
        cutbacks: int,
        wall: float,
        errors: ErrorStep | None,
    ) -> StepReport:
        conditions = self.solver.conditions if self.solver is not None else []
        dissipation = float(
            sum(np.sum(c.history.D * c.traction * c.plastic_slip) for c in conditions)
        )
        repeatable = self.adaptation is not None and self.adaptation.repeats
        self.before = copy.copy(self.state) if repeatable else None
        self.state.accept(self.state.t + dt, self.discretisation, conditions)
        self.state.repeatable = repeatable
        self.reactions = self.solver.reactions() if self.solver is not None else []
        warmed = None
        if self.heat is not None and heat is not None:
            warmed = self.heat.record.step(heat, self.state.theta)
            pairs = zip(self.state.theta, heat.solution.theta, strict=True)
            self.state.rate = [np.asarray((b - a) / dt) for a, b in pairs]
            self.state.accept_heat(heat.solution.theta, heat.exchanges, self.discretisation)
        status = np.concatenate([c.status for c in conditions] or [np.empty(0, np.int8)])
        report = StepReport(
            step=len(self.reports) + 1,
            t=self.state.t,
            dt=dt,
            iterations=solved.iterations,
            cutbacks=cutbacks,
            residuals=solved.residuals,
            open=int((status == Status.OPEN).sum()),
            stick=int((status == Status.STICK).sum()),
            slip=int((status == Status.SLIP).sum()),
            forces=_forces(self.discretisation, conditions),
            dissipation=dissipation,
            wall=wall,
            moment_defects={
                interface.name: defects(c)[1]
                for interface, c in zip(self.discretisation.interfaces, conditions, strict=True)
            },
            heat=warmed,
            errors=errors,
        )
        if self.adaptation is not None:
            self.adaptation.accepted(self.state.rate, dt)
        self.reports.append(report)
        self._record(report)
        return report


def _adaptation(case: Case, discretisation: Discretisation, timers: Timers) -> Adaptation | None:
    """What judges steps, only imported where the case asks for an error."""
    if case.adaptivity is None:
        return None
    from contactfem.adapt import Adaptation

    return Adaptation(case, discretisation, timers)


class _HeatSide:
    """Driver and record of heat; only imported where heat is solved for."""

    def __init__(self, case: Case, thermal: Thermal, solver: NewtonSolver | None) -> None:
        from contactfem.heat_record import HeatRecord
        from contactfem.staggered import Staggered

        assert case.heat is not None
        self.driver = Staggered(solver, thermal, case.heat)
        self.record = HeatRecord(thermal)


def first_contact(gap: Floats, size: Floats, seen: Bools, held_by_contact: bool) -> Trial | None:
    """Status that a first contact starts from: some nodes stick for one iteration.

    Args:
        gap: Mean gap of the nodes [m], (n,).
        size: Facet length of the nodes [m], (n,).
        seen: Nodes that carry a multiplier and face the other side, (n,).
        held_by_contact: Whether only contact can hold a body of this interface: then the nodes in
            the lowest 30 % of the range of gaps close, otherwise those that touch.

    Returns:
        Status of every node; None where no node touches and none has to.
    """
    stick = seen & (np.abs(gap) <= TOUCH * size)
    if held_by_contact and seen.any():
        low, high = gap[seen].min(), gap[seen].max()
        stick = seen & (gap <= low + FIRST_CONTACT * (high - low))
    if not stick.any():
        return None
    status = np.where(stick, Status.STICK, Status.OPEN).astype(np.int8)
    return Trial(status, np.zeros(len(gap)))


def _stops(case: Case) -> list[float]:
    """Times that a step must end at: corners of tables, times of output, the end."""
    tables = [t for c in case.conditions for t in _tables(c)]
    tables += [t for o in case.obstacles.values() for t in o.displacement.values()]
    tables += [body.temperature for body in case.bodies.values()]
    tables += [o.temperature for o in case.obstacles.values() if o.temperature is not None]
    for interface in case.interfaces.values():
        given = (interface.heat.pressure, interface.heat.dissipation)
        tables += [table for table in given if table is not None]
    times = {t for table in tables for t in table.times} | set(case.output.times)
    return sorted({t for t in times if 0.0 < t < case.time.end} | {case.time.end})


def _tables(condition: Condition) -> list[Table]:
    """All values over time of a condition."""
    given = [condition.traction, condition.body_force]
    given += [condition.grip.force] if condition.grip else []
    tables = [table for group in given if group for table in group.values()]
    tables += [condition.pressure] if condition.pressure else []
    tables += [condition.field] if isinstance(condition.field, Table) else []
    tables += [condition.convection.ambient] if condition.convection else []
    return tables + list(condition.components().values())


def _forces(
    discretisation: Discretisation, conditions: Sequence[Conditions]
) -> dict[str, tuple[float, float]]:
    """Resultant of every interface on its mortar side [N/m]."""
    result = {}
    for interface, c in zip(discretisation.interfaces, conditions, strict=True):
        force = -c.nodal_forces()[len(c.multiplier) :].sum(0)
        result[interface.name] = (float(force[0]), float(force[1]))
    return result


def _result(
    case: Case, discretisation: Discretisation, loop: _Loop, timers: Timers, message: str
) -> RunResult:
    """Gather everything on the first rank; collective."""
    with timers.book("output"):
        pictures = body_pictures(discretisation)
        heat = heat_pictures(discretisation, loop.state)
        probes = probe_values(case, pictures, heat)
        tables = interface_tables(discretisation, loop.state)
    reactions: dict[str, tuple[float, ...]] = {
        name: (force,) for name, force in zip(discretisation.held, loop.reactions, strict=False)
    }
    system = discretisation.system
    sizes = {
        "unknowns": system.numbering.n_global,
        "ranks": system.comm.size,
        "nonmortar_nodes": sum(i.nodes.mesh.n_nonmortar for i in discretisation.interfaces),
    }
    if discretisation.heat is not None:
        sizes["temperatures"] = discretisation.heat.system.numbering.n_global
    seconds = dict(timers.seconds)
    seconds["contact"] = sum(v for k, v in seconds.items() if k.startswith("contact."))
    return RunResult(
        case, tuple(loop.reports), tuple(tables), tuple(pictures), reactions, probes, seconds,
        sizes, not message, message, warnings=tuple(loop.warnings), heat=tuple(heat),
    )  # fmt: skip
