"""The adaptive strategy (paper 2.5): estimate, decide, report."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from mpi4py import MPI

from contactfem.adaptivity.anisotropic_layers import mechanical_cells, thermal_cells
from contactfem.adaptivity.body_recovery import BodyErrors
from contactfem.adaptivity.decisions import (
    Advance,
    Decision,
    MeshHistory,
    NewSizes,
    RemeshAndRepeat,
    RepeatStep,
)
from contactfem.adaptivity.estimators import FluxEstimator, StressEstimator, total
from contactfem.adaptivity.mesh_decision import CellLimits, Lifetime, MeshChoice, choose_meshes
from contactfem.adaptivity.policies import (
    MeshPolicy,
    StepPolicy,
    TimedStep,
    TimeReport,
    decide_step,
)
from contactfem.adaptivity.recovery.time import time_error
from contactfem.case.schema import Case
from contactfem.common.timers import Timers
from contactfem.common.typing import Floats
from contactfem.contact.state import ContactState
from contactfem.discretisation.discretise import Discretisation
from contactfem.discretisation.observables import observed
from contactfem.discretisation.state import State
from contactfem.results.data import ErrorStep, MeshErrors, Observables, Remeshing
from contactfem.results.relative_error import RelativeError, error_ratio
from contactfem.thermomechanics.staggered import HeatOutcome

REMESH_COST = 3.0  # of new meshes in steps of mechanics, which solve for many Newton iterations
REMESH_COST_OF_HEAT = 30.0  # and in steps of heat alone, which only substitute


@dataclass
class _Progress:
    """What the present step has been through.

    By problem new meshes and the error before them; when the step ended before the first new mesh,
    and what was observed there.
    """

    remeshes: list[Remeshing] = field(default_factory=list)
    decisions: list[str] = field(default_factory=list)
    rounds: dict[str, int] = field(default_factory=dict)
    before: dict[str, float] = field(default_factory=dict)
    repeats: int = 0
    first: tuple[float, Observables] | None = None

    def gained(self, found: Mapping[str, RelativeError]) -> dict[str, float]:
        """Part of the error that the last new meshes took away."""
        return {
            problem: 1.0 - error_ratio(found[problem].eta) / error_ratio(eta)
            for problem, eta in self.before.items()
            if problem in found
        }


class Adaptation:
    """Judges solved steps.

    Args:
        case: The case, with adaptivity.
        discretisation: The present meshes.
        timers: Where time is booked.
        lasting: As the property; None at the start of a run.
    """

    def __init__(
        self,
        case: Case,
        discretisation: Discretisation,
        timers: Timers,
        lasting: tuple[MeshHistory, MeshHistory] | None = None,
    ) -> None:
        assert case.adaptivity is not None
        self.case, self.settings, self.timers = case, case.adaptivity, timers
        self._now = _Progress()
        self._lasting, self._lasting_before = lasting or (MeshHistory(), MeshHistory())
        self._found: dict[str, RelativeError] = {}
        self._asked: dict[str, tuple[str, ...]] = {}
        self._reasons: dict[str, str] = {}
        self._discretisation = discretisation
        self.first_meshes: tuple[MeshErrors, ...] = ()
        self.last_meshes: tuple[MeshErrors, ...] = ()
        self._stress: StressEstimator | None = None
        self._flux: FluxEstimator | None = None
        self.use(discretisation)

    def use(self, discretisation: Discretisation) -> None:
        """Go on with these meshes; collective."""
        self._discretisation = discretisation
        settings = self.settings
        if self.case.mechanics and settings.for_mechanics() is not None:
            self._stress = StressEstimator(self.case, discretisation, self._stress)
        if discretisation.heat is not None and settings.for_heat() is not None:
            self._flux = FluxEstimator(self.case, discretisation, self._flux)

    @property
    def lasting(self) -> tuple[MeshHistory, MeshHistory]:
        """What accepted steps left behind, now and before the last one."""
        return self._lasting, self._lasting_before

    @property
    def repeats(self) -> bool:
        """Whether a step may be taken again when the next one shows its error."""
        heat = self._discretisation.heat
        steady = heat is None or heat.system.scheme.steady
        return self.settings.for_time() is not None and not steady

    def judge(
        self,
        state: State,
        conditions: Sequence[ContactState],
        heat: HeatOutcome | None,
        t: float,
    ) -> Decision:
        """Decide about a step that was solved; collective, the same on all ranks.

        Args:
            state: The last good state, from which it started.
            conditions: Contact conditions at its end.
            heat: Its heat side.
            t: Time at its end [s].

        Returns:
            The decision.
        """
        if t <= self.settings.start * (1.0 + 1e-12):
            return Advance(None, self._report({}, None))
        theta = None if heat is None else heat.solution.theta
        with self.timers.book("estimate"):
            if heat is not None and not self._counts(heat):
                heat = None
            timed = self._judge_step(state, heat, t)  # first: it costs next to nothing
            if isinstance(timed, RepeatStep):
                self._now.repeats += 1
                self._now.first = None
                if timed.back > 1:
                    self._lasting = self._lasting_before
                return timed
            found, sizes = self._judge_meshes(conditions, heat, t, t - state.t)
            change = self._change(conditions, theta, t, again=sizes is not None)
        if sizes is not None:
            return RemeshAndRepeat(sizes)
        dt, eta_time = timed
        return Advance(dt, self._report(found, eta_time, change))

    def _change(
        self,
        conditions: Sequence[ContactState],
        theta: Sequence[Floats] | None,
        t: float,
        *,
        again: bool,
    ) -> Observables | None:
        """What new meshes changed of the step; what was before the first is kept for that."""
        first = self._now.first
        if first is None and not again:
            return None
        now = observed(self._discretisation, conditions, theta)
        if first is None:
            self._now.first = t, now
            return None
        return now.minus(first[1]) if first[0] == t else None

    def _counts(self, heat: HeatOutcome) -> bool:
        """Whether temperatures of a body are far enough apart for its flux to count; collective."""
        theta = heat.solution.theta
        top = np.array([float(values.max(initial=-np.inf)) for values in theta])
        bottom = np.array([float((-values).max(initial=-np.inf)) for values in theta])
        for ends in (top, bottom):
            self._discretisation.system.comm.Allreduce(MPI.IN_PLACE, ends, MPI.MAX)
        return bool((top + bottom).max() > self.settings.least_temperature)

    def _strained(self) -> bool:
        """Whether a body is strained by more than round-off for errors to count; collective."""
        bodies = self._discretisation.system.bodies
        largest = [
            float(np.abs(body.cell_stress()).max(initial=0.0)) / body.law.youngs_modulus
            for body in bodies
        ]
        strain = self._discretisation.system.comm.allreduce(max(largest), MPI.MAX)
        return bool(strain > self.settings.least_strain)

    def remeshed(
        self, before: Discretisation, after: Discretisation, t: float, seconds: float
    ) -> None:
        """Note what new meshes were made for the present step.

        Args:
            before: The old meshes.
            after: The new ones.
            t: Time at the start of the step [s].
            seconds: What it took.
        """
        for problem, old, new in _both(before, after):
            for name, cells in new.items():
                if cells != old[name] or name in self._asked.get(problem, ()):
                    reason = self._reasons.get(problem, "")
                    eta = self._found[problem].eta if problem in self._found else 0.0
                    self._now.remeshes.append(
                        Remeshing(t, problem, name, old[name], cells, reason, seconds, eta)
                    )
        self.use(after)

    def accepted(self, rate: Sequence[Floats], dt: float) -> None:
        """Note that the present step was accepted; collective.

        Args:
            rate: Its mean rates of temperature, flat local arrays of the bodies [K/s].
            dt: Its length [s].
        """
        thermal = self._discretisation.heat
        self._lasting_before, square, span = self._lasting, 0.0, 0.0
        if thermal is not None and self.repeats:
            square, span = thermal.product(rate, rate) * dt, dt
        gained = self._now.gained(self._found)
        self._lasting = self._lasting.next(square, span, self._now.rounds, gained)
        self._now = _Progress()

    def _judge_meshes(
        self,
        conditions: Sequence[ContactState],
        heat: HeatOutcome | None,
        t: float,
        dt: float,
    ) -> tuple[dict[str, RelativeError], NewSizes | None]:
        """Errors of both problems, and new sizes if a mesh is to be replaced."""
        errors: dict[str, list[BodyErrors]] = {}
        if self._stress is not None and self._strained():
            errors["mechanics"] = self._stress(conditions, t)
        if self._flux is not None and heat is not None:
            errors["heat"] = self._flux(heat.solution.theta, heat.exchanges, t)
        self._found = found = {problem: total(bodies) for problem, bodies in errors.items()}
        tolerances = {
            "mechanics": self.settings.for_mechanics(),
            "heat": self.settings.for_heat(),
        }
        wanted: dict[str, Mapping[str, Floats]] = {}
        self.last_meshes = tuple(
            one for problem, bodies in errors.items() for one in _with_errors(problem, bodies, t)
        )
        self._asked, self._reasons = {}, {}
        for problem, bodies in errors.items():
            tolerance = tolerances[problem]
            assert tolerance is not None
            choice = self._choice(problem, bodies, tolerance, t, dt)
            self._now.decisions.append(f"{problem}: {choice.reason}")
            if choice.sizes:
                wanted[problem] = choice.sizes
                self._asked[problem] = tuple(choice.sizes)
                self._reasons[problem] = choice.reason
                self._now.rounds[problem] = self._now.rounds.get(problem, 0) + 1
                self._now.before[problem] = found[problem].eta
        if not wanted:
            return found, None
        self.first_meshes = self.first_meshes or self.last_meshes
        return found, NewSizes(wanted.get("mechanics", {}), wanted.get("heat", {}))

    def _choice(
        self, problem: str, bodies: Sequence[BodyErrors], tolerance: float, t: float, dt: float
    ) -> MeshChoice:
        """New sizes of the meshes of one problem, and why."""
        settings = self.settings
        cells = mechanical_cells if problem == "mechanics" else thermal_cells
        chosen = [cells(self.case, body) for body in bodies if self._may_change(body.name)]
        limits = CellLimits(
            settings.size_min,
            settings.size_max,
            settings.growth,
            settings.max_cells,
            settings.contact_size or np.inf,
        )
        cost = REMESH_COST if self.case.mechanics else REMESH_COST_OF_HEAT
        policy = MeshPolicy(tolerance, most_remeshes=settings.max_remeshes, cost=cost)
        rounds, lasting = self._now.rounds.get(problem, 0), self._lasting
        gained = {**lasting.gained, **self._now.gained(self._found)}
        lifetime = Lifetime(
            rounds,
            (self.case.time.end - t) / dt,
            lasting.expected(problem),
            0 if rounds else lasting.age.get(problem, 0),
            gained.get(problem, 1.0),
        )
        return choose_meshes(chosen, total(bodies), limits, policy, lifetime)

    def _may_change(self, name: str) -> bool:
        return self.settings.bodies is None or name in self.settings.bodies

    def _judge_step(
        self, state: State, heat: HeatOutcome | None, t: float
    ) -> RepeatStep | tuple[float | None, float | None]:
        """Decide about the length of the step: shorter, or the next length and the error."""
        tolerance, thermal = self.settings.for_time(), self._discretisation.heat
        if tolerance is None or heat is None or thermal is None or not self.repeats:
            return None, None
        dt = t - state.t
        pairs = zip(state.theta, heat.solution.theta, strict=True)
        rate = [np.asarray((after - before) / dt) for before, after in pairs]
        square = thermal.product(rate, rate)
        if not state.rate:
            return None, None
        change = [b - a for a, b in zip(state.rate, rate, strict=True)]
        change_square = thermal.product(change, change)
        older_square = thermal.product(state.rate, state.rate)
        least = self._lasting.mean_square
        newer = time_error(change_square, square, state.dt, dt, least)
        older = time_error(change_square, older_square, dt, state.dt, least)
        limits = self.case.time
        policy = StepPolicy(tolerance, limits.step_min, limits.step_max)
        report = TimeReport(
            TimedStep(dt, newer.eta),
            TimedStep(state.dt, older.eta) if state.repeatable else None,
            self._now.repeats,
        )
        decision = decide_step(report, policy)
        self._now.decisions.append(f"time: {decision.reason}")
        if isinstance(decision, RepeatStep):
            return decision
        return decision.dt, newer.eta

    def _report(
        self,
        found: Mapping[str, RelativeError],
        time: float | None,
        change: Observables | None = None,
    ) -> ErrorStep:
        """What the step report says of errors and decisions."""
        mechanics, heat = found.get("mechanics"), found.get("heat")
        mechanical, thermal = _cells(self._discretisation)
        return ErrorStep(
            mechanics=None if mechanics is None else mechanics.eta,
            mechanics_printed=None if mechanics is None else mechanics.eta_printed,
            heat=None if heat is None else heat.eta,
            heat_printed=None if heat is None else heat.eta_printed,
            time=time,
            time_printed=None if time is None else time**2,
            cells=mechanical,
            thermal_cells=thermal,
            remeshes=tuple(self._now.remeshes),
            repeats=self._now.repeats,
            decisions=tuple(self._now.decisions),
            change=change,
        )


def _with_errors(problem: str, bodies: Sequence[BodyErrors], t: float) -> list[MeshErrors]:
    """Meshes of one problem with the densities of their errors."""
    data = [body.view.data for body in bodies]
    areas = [body.view.sizes**2 for body in bodies]
    area = sum(float(part.sum()) for part in areas)
    square = total(bodies).error_square
    scale = total(bodies).eta_printed * area / square if square > 0.0 else 0.0
    return [
        MeshErrors(t, problem, body.name, mesh.points, mesh.cells, scale * body.errors / part)
        for body, mesh, part in zip(bodies, data, areas, strict=True)
    ]


def _cells(discretisation: Discretisation) -> tuple[dict[str, int], dict[str, int]]:
    """Cells of the mechanical and the thermal meshes, by body."""

    def count(body: object) -> int:
        topology = body.mesh.mesh.topology  # type: ignore[attr-defined]
        return int(topology.index_map(topology.dim).size_global)

    mechanical = {name: count(body) for name, body in discretisation.bodies.items()}
    heat = discretisation.heat
    return mechanical, {} if heat is None else {body.name: count(body) for body in heat.bodies}


def _both(
    before: Discretisation, after: Discretisation
) -> list[tuple[str, dict[str, int], dict[str, int]]]:
    """Cells before and after, of both problems."""
    old, new = _cells(before), _cells(after)
    return [("mechanics", old[0], new[0]), ("heat", old[1], new[1])]
