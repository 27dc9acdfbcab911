"""The loop over the steps of a run."""

from __future__ import annotations

import copy
import time
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from contactfem.adaptivity.decisions import (
    Advance,
    Decision,
    GiveUp,
    RemeshAndRepeat,
    RepeatStep,
)
from contactfem.case.schema import Case
from contactfem.case.time_points import stops
from contactfem.checkpoint.checkpointer import Checkpointer, RunState, Writing
from contactfem.checkpoint.format import Checkpoint, Progress
from contactfem.checkpoint.state_io import restored
from contactfem.common.timers import Timers
from contactfem.contact.initial_active_set import initial_active_set
from contactfem.contact.resultants import defects
from contactfem.discretisation.discretise import Discretisation, discretise
from contactfem.discretisation.observables import forces
from contactfem.discretisation.state import State, initial_state
from contactfem.laws.active_set import ActiveSet, Status
from contactfem.output.recorder import Recorder
from contactfem.results.data import ErrorStep, MeshErrors, StepReport
from contactfem.run.loop_parts import (
    HeatSide,
    adaptation_of,
    held_by_contact_alone,
    newton_solver,
    nonmortar_temperature,
    verification_of,
)
from contactfem.run.step_control import StepLimits, after_failure, after_success, clipped
from contactfem.run.verdict import heat_verdict
from contactfem.solvers.diagnosis import explain
from contactfem.solvers.newton import NewtonSolver, SolveReport, StepInput

if TYPE_CHECKING:
    from contactfem.thermomechanics.staggered import HeatOutcome


class Loop:
    """Steps from zero to the end; each is tried with smaller lengths until it is solved."""

    def __init__(
        self,
        case: Case,
        discretisation: Discretisation,
        solver: NewtonSolver | None,
        recorder: Recorder,
        keeper: Checkpointer,
        timers: Timers,
        resumed: Progress | None,
    ) -> None:
        self.case, self.discretisation = case, discretisation
        self.solver, self.recorder, self.keeper = solver, recorder, keeper
        self.heat = HeatSide(case, discretisation.heat, solver) if discretisation.heat else None
        self.timers, self.reusing = timers, solver
        start = resumed or Progress(case.time.step, case.time.step)
        self.dt, self.easy = min(start.dt, case.time.step_max), list(start.easy)
        self.reports, self.reactions = list(start.reports), list(start.reactions)
        self.ramp_end = start.ramp_end
        self.state = initial_state(discretisation, self.ramp_end)
        self.adaptation = adaptation_of(case, discretisation, timers, start.lasting)
        self.before: State | None = None
        self.pending: tuple[StepReport, State] | None = None
        self.warnings = list(start.warnings)
        most = case.solver.max_cutbacks
        self.limits = StepLimits(case.time.end, case.time.step_min, case.time.step_max, most)
        self.stops = stops(case)
        self.alone = held_by_contact_alone(self.case, self.discretisation)
        self.cautious = start.cautious
        self.verification = verification_of(case, discretisation.heat, self.ramp_end)
        self.wrong = False

    def restore(self, checkpoint: Checkpoint) -> None:
        """Take the state of a checkpoint; collective."""
        self.state, self.before = restored(self.discretisation, checkpoint.state, self.ramp_end)
        if checkpoint.progress.pending:
            self.pending = self.reports[-1], copy.copy(self.state)

    def progress(self) -> Progress:
        """How far the run has come, to be resumed from."""
        return Progress(
            self.dt,
            self.ramp_end,
            tuple(self.easy),
            self.cautious,
            tuple(self.reports),
            tuple(self.recorder.failures),
            tuple(self.warnings),
            tuple(self.reactions),
            self.recorder.segment,
            self.pending is not None,
            None if self.adaptation is None else self.adaptation.lasting,
        )

    def run(self) -> str:
        """Go to the end; an empty string, or why it was not reached."""
        while self.state.t < self.case.time.end * (1.0 - 1e-12):
            self._keep(self.keeper.visit)
            if why := self._step():
                return why
        for text in heat_verdict(self.case, self.reports):
            self.warn(text)
        self._keep(self.keeper.finish)
        return ""

    def _step(self) -> str:
        """Take one step, cut as often as it must be; an empty string, or why there is none."""
        begun, cutbacks, first = time.perf_counter(), 0, (self.dt, self.easy, self.cautious)
        while True:
            step = clipped(self.state.t, self.dt, self.stops)
            solved, heat = self._attempt(self.state.t + step)
            decision = after_failure(step, cutbacks, self.limits)
            if solved.converged and (not solved.doubt or isinstance(decision, GiveUp)):
                verdict = self._judge(heat, self.state.t + step)
                if not isinstance(verdict, Advance):
                    self.dt, self.easy = self._again(verdict, self.dt), []
                    continue
                solved, decision = self._looked_at(solved, self.state.t + step, decision)
                if solved.converged:
                    break
            self.state.restore(self.discretisation)
            if not solved.converged and not self.wrong and self._renewed():
                continue
            reason = solved.doubt or self._why(solved)
            if isinstance(decision, GiveUp):
                self.dt, self.easy, self.cautious = first  # other limits may do
                self._keep(self.keeper.write)
                return self._ending(self.state.t + step, reason, decision)
            self.recorder.failure(self.state.t + step, reason, decision.dt)
            self.cautious = not self.cautious  # what did not work once, or does not any more
            self.dt, cutbacks, self.easy = decision.dt, cutbacks + 1, []
        if solved.doubt:
            self.warn(f"step to t = {self.state.t + step:g} s: {solved.doubt}")
        wall = time.perf_counter() - begun
        report = self._accept(step, solved, heat, cutbacks, wall, verdict.errors)
        if self.solver is not self.reusing:
            self._use(self.reusing)
        self._choose_step(report, verdict.dt)
        return self._heat_looked_at(report)

    def _ending(self, t: float, reason: str, decision: GiveUp) -> str:
        """Why the run ends before a time [s]."""
        what = "the state is not accepted" if self.wrong else f"no equilibrium found at t = {t:g} s"
        why = f"{reason}; {decision.reason}" if decision.reason else reason
        return (
            f"{self.case.path}: {what}: {why}. The last good state, t = {self.state.t:g} s, is "
            f"written{self.keeper.hint}"
        )

    def _looked_at(
        self, solved: SolveReport, t: float, decision: RepeatStep | GiveUp
    ) -> tuple[SolveReport, RepeatStep | GiveUp]:
        """The same report, or a failure where the state found cannot be; collective.

        Args:
            solved: How the step was solved.
            t: Time at its end [s].
            decision: What would become of it if it had failed.

        Returns:
            How it was solved, and what becomes of it if that is a failure.
        """
        self.wrong = False
        if self.verification is None or self.solver is None:
            return solved, decision
        found = self.verification.look(t, self.discretisation, self.solver)
        if not found.breaches or self.case.solver.verify == "warn":
            if found.breaches and self.verification.new(found):
                self.warn(str(found))
            self.verification.accepted()
            return solved, decision
        self.wrong = True
        if not self.verification.shorter_helps:
            decision = GiveUp("")
        return replace(solved, converged=False, doubt="", reason=str(found)), decision

    def _heat_looked_at(self, report: StepReport) -> str:
        """Why the run ends after a step with heat that cannot be, else empty; collective."""
        if self.verification is None or report.heat is None:
            return ""
        found = self.verification.of_heat(report.heat, report.t, report.dt)
        if not found.breaches:
            return ""
        if self.case.solver.verify == "warn":
            if self.verification.new(found):
                self.warn(str(found))
            return ""
        self.wrong = True
        self._keep(self.keeper.write)
        return self._ending(report.t, str(found), GiveUp(""))

    def _choose_step(self, report: StepReport, wanted: float | None) -> None:
        """Length of the next step: what its error wants, or else what Newton's method bears."""
        self.easy.append(report.iterations)
        grown = after_success(self.dt, self.easy, self.limits)
        if wanted is not None:  # the error decides, but not at once against a failed solve
            grown = min(wanted, self.dt) if report.cutbacks else wanted
        self.dt, self.easy = grown, self.easy if grown == self.dt else []

    def _keep(self, write: Writing) -> None:
        """Write a checkpoint if one is due, and say so if that fails; collective."""
        moment = RunState(self.discretisation, self.state, self.before, self.progress())
        if trouble := write(moment):
            self.warn(trouble)

    def _renewed(self) -> bool:
        """Take the step without factors that serve on, if there were any: it may be their fault."""
        if self.solver is None or not self.solver.reuses:
            return False
        self._use(newton_solver(self.case, self.discretisation, self.timers, reuse=False))
        return True

    def _use(self, solver: NewtonSolver | None) -> None:
        """Go on with a solver."""
        heat = self.discretisation.heat
        self.solver = solver
        self.heat = HeatSide(self.case, heat, solver) if heat else None

    def _judge(self, heat: HeatOutcome | None, t: float) -> Decision:
        """What becomes of a step that was solved; collective."""
        if self.adaptation is None:
            return Advance(None, None)
        conditions = self.solver.conditions if self.solver is not None else []
        return self.adaptation.judge(self.state, conditions, heat, t)

    def _again(self, verdict: RemeshAndRepeat | RepeatStep, dt: float) -> float:
        """Prepare to take the step again, on new meshes or with another length; returns that."""
        if isinstance(verdict, RemeshAndRepeat):
            self._take_new_meshes(verdict)
            return dt
        if verdict.back == 2 and self.before is not None:
            self.state, self.before, self.pending = self.before, None, None
            self.state.repeatable = False
            self.reports.pop()
        self.state.restore(self.discretisation)
        return verdict.dt

    def _take_new_meshes(self, verdict: RemeshAndRepeat) -> None:
        """Go on with new meshes from the last good state; collective."""
        from contactfem.adaptivity.remesh import carried, new_meshes

        assert self.adaptation is not None
        begun = time.perf_counter()
        self.flush()
        with self.timers.book("remesh"):
            old, comm = self.discretisation, self.discretisation.system.comm
            given = new_meshes(self.case, old, verdict.sizes)
            new = discretise(self.case, comm, self.timers, given, old)
            self.state = carried(old, new, self.state, self.ramp_end)
            self.before = None
            self.discretisation = new
            if self.case.mechanics and new.system is not old.system:
                self.reusing = newton_solver(self.case, new, self.timers)
            self._use(self.reusing)
            self.alone = held_by_contact_alone(self.case, self.discretisation)
            self.adaptation.remeshed(old, new, self.state.t, time.perf_counter() - begun)
        self.recorder.remeshed(new)

    @property
    def _mesh_errors(self) -> tuple[MeshErrors, ...]:
        """Errors of the cells that were estimated last, where meshes adapt."""
        return () if self.adaptation is None else self.adaptation.last_meshes

    def flush(self) -> None:
        """Record the last accepted step, if it was kept back because it could be taken again."""
        if self.pending is not None:
            report, state = self.pending
            self.pending = None
            state.restore(self.discretisation)
            self.recorder.step(report, state, self._mesh_errors)
            self.state.restore(self.discretisation)

    def _record(self, report: StepReport) -> None:
        """Record an accepted step; with steps that follow their error only after the next one."""
        self.flush()
        if self.adaptation is None or not self.adaptation.repeats:
            self.recorder.step(report, self.state, self._mesh_errors)
        else:
            self.pending = report, copy.copy(self.state)

    def warn(self, text: str) -> None:
        """Accept what is doubtful, but say so."""
        self.warnings.append(text)
        self.recorder.warning(text)

    def _why(self, solved: SolveReport) -> str:
        """Why a solve failed: what the solver says, and what the contact status says."""
        if self.wrong:
            return solved.reason
        held = {self.discretisation.interfaces[k].name for k in self.alone}
        history = self.solver.history if self.solver is not None else []
        status = explain(self.discretisation.interfaces, history, held)
        return f"{solved.reason}; {status}" if status else solved.reason

    def _attempt(self, t: float) -> tuple[SolveReport, HeatOutcome | None]:
        """Solve a step to a time [s]; collective."""
        self.wrong = False
        starts = tuple(self._start(k) for k in range(len(self.discretisation.interfaces)))
        known = bool(self.state.conditions) or not starts
        histories = tuple(
            replace(
                history,
                dt=t - self.state.t,
                temperature=nonmortar_temperature(self.case, self.discretisation, k, t),
                offset=self._offset(k, t),
            )
            for k, history in enumerate(self.state.histories)
        )
        step = StepInput(t, self.ramp_end, histories, starts, known, self.alone, self.cautious)
        if self.heat is not None:
            return self.heat.driver.attempt(step, self.heat.start(self.state))
        assert self.solver is not None
        return self.solver.solve(step), None

    def _offset(self, k: int, t: float) -> float:
        """Interference less clearance of an interface at a time [m]."""
        return self.case.interfaces[self.discretisation.interfaces[k].name].offset(t, self.ramp_end)

    def _start(self, k: int) -> ActiveSet | None:
        """Status that the first iteration of a step takes for an interface.

        That of the last step where there was contact: with a linear bulk and loads that grow in
        proportion it stays right, and a trial state would not know which of the nodes on the limit
        of friction slip. At a first contact a guess; None where there is none to make.
        """
        if (start := self.state.starts()[k]) is not None:
            return start
        interface = self.discretisation.interfaces[k]
        x = interface.nodes.positions(self.state.t, self.ramp_end)
        operators = interface.contact.operators(x)
        history = replace(self.state.histories[k], offset=self._offset(k, self.state.t))
        gap = interface.contact.gap(operators, history)
        return initial_active_set(operators, gap, k in self.alone, self.cautious)

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
        dissipation = float(sum(np.sum(c.dissipation) for c in conditions))
        repeatable = self.adaptation is not None and self.adaptation.repeats
        self.before = copy.copy(self.state) if repeatable else None
        self.state.accept(self.state.t + dt, self.discretisation, conditions)
        # where data may have a kink the next step says nothing of the error of this one
        at_stop = any(abs(stop - self.state.t) <= 1e-9 * dt for stop in self.stops)
        self.state.repeatable = repeatable and not at_stop
        self.reactions = self.solver.reactions() if self.solver is not None else []
        warmed = None
        if self.heat is not None and heat is not None:
            warmed, self.state.increments = self.heat.record.step(
                heat,
                self.state.theta,
                self.state.increments,
                self.reports[-1].heat if self.reports else None,
            )
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
            forces=forces(self.discretisation, conditions),
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
