"""Heat of several bodies as one system (18), (22)-(27)."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mpi4py import MPI
from petsc4py import PETSc

from contactfem.common.place_time import PlaceTime
from contactfem.common.time_table import Table
from contactfem.common.timers import Timers
from contactfem.common.typing import Floats, Ints
from contactfem.fem.dof_numbering import Unknowns
from contactfem.heat.body import HeatBody
from contactfem.heat.interface import HeatExchange, HeatInterface
from contactfem.heat.stage_matrix import StageMatrix
from contactfem.heat.time_schemes import TimeScheme

SOLVES = 3  # at most: the problem is linear, but round-off of one solve may be above the tolerance
TOLERANCE = 1e-12  # of the residual, relative to that of the start
ROUND_OFF = 4 * np.finfo(float).eps


@dataclass(frozen=True)
class PrescribedTemperature:
    """Temperature prescribed at some vertices of a body, over time or over place and time [K]."""

    body: int
    vertices: Ints
    value: Table | PlaceTime
    component: int = 0


@dataclass(frozen=True)
class HeatStepInput:
    """What a step of the heat problem starts from.

    Attributes:
        t: Time at its start [s].
        dt: Its length [s].
        theta: Temperatures at its start, flat local arrays of the bodies [K].
        u: Displacements at its start, likewise [m].
        exchanges: Of the interfaces, at its end.
        before: Those at its start, from which conduction goes linearly to that at the end; empty
            to take that of the end all along.
    """

    t: float
    dt: float
    theta: Sequence[Floats]
    u: Sequence[Floats]
    exchanges: Sequence[HeatExchange]
    before: Sequence[HeatExchange] = ()

    def shares(self, points: Floats) -> list[tuple[Floats, Sequence[HeatExchange]]]:
        """Exchanges, and their share in conduction at points of the step in (0, 1]."""
        if not self.before:
            return [(np.ones_like(points), self.exchanges)]
        return [(1.0 - points, self.before), (points, self.exchanges)]


@dataclass(frozen=True)
class HeatBalance:
    """Heat of one step [J/m], with an axis [J]; the same on all ranks.

    Attributes:
        stored: Growth of the heat that the bodies hold.
        held: What came in where temperature is prescribed, per condition.
        loads: What sources, fluxes and surroundings brought.
        friction: Frictional heat that entered the bodies.
        obstacles: What came in from obstacles by conduction.
        strained: What straining brought.
        moved: What moved inside: ∫ ρ₀ c |Δϑ| dV, and what crossed interfaces either way.
    """

    stored: float
    held: tuple[float, ...]
    loads: float
    friction: float
    obstacles: float
    strained: float
    moved: float

    @property
    def defect(self) -> float:
        """What is stored but came from nowhere."""
        came = sum(self.held) + self.loads + self.friction + self.obstacles + self.strained
        return self.stored - came


@dataclass(frozen=True)
class HeatSolution:
    """A step of the heat problem.

    Attributes:
        theta: Temperatures at its end, flat local arrays of the bodies [K].
        stages: Those of every stage, likewise.
        balance: Where the heat came from.
        reason: Why there is no solution; empty where there is one.
    """

    theta: list[Floats]
    stages: list[list[Floats]]
    balance: HeatBalance
    reason: str


class HeatSystem(Unknowns):
    """Heat of all bodies as one vector of unknown temperatures and one matrix.

    Args:
        comm: All ranks.
        bodies: The bodies.
        held: Prescribed temperatures.
        scheme: Time scheme.
        options: PETSc options for the linear solver, over the defaults.
        timers: Where time is booked.
    """

    def __init__(
        self,
        comm: MPI.Comm,
        bodies: Sequence[HeatBody],
        held: Sequence[PrescribedTemperature],
        scheme: TimeScheme,
        options: Mapping[str, str],
        timers: Timers,
    ) -> None:
        super().__init__(comm, bodies, held, ())
        self.bodies, self.scheme, self.timers = tuple(bodies), scheme, timers
        self.interfaces: tuple[HeatInterface, ...] = ()
        self._held = [
            (h.body, bodies[h.body].dofs(h.vertices), _values(bodies[h.body], h)) for h in held
        ]
        self._counted = [
            np.setdiff1d(
                dofs, [d for b, later, _ in self._held[k + 1 :] if b == body for d in later]
            )
            for k, (body, dofs, _) in enumerate(self._held)
        ]  # where conditions meet the last one holds the temperature, so heat comes in through it
        self._matrix = StageMatrix(self, bodies, scheme, options)

    def couple(self, interfaces: Sequence[HeatInterface]) -> None:
        """Name the interfaces, whose nodes need the numbering first."""
        self.interfaces = tuple(interfaces)

    def set_held(self, t: float, arrays: Sequence[Floats]) -> None:
        """Write the prescribed temperatures of a time into the bodies' local arrays.

        Args:
            t: Time [s].
            arrays: One array per body, flat over local dofs [K].
        """
        for body, dofs, value in self._held:
            arrays[body][dofs] = value(t)

    def prescribed(self, t: float) -> list[Floats | float]:
        """Prescribed temperatures of a time on this rank, per condition [K]."""
        return [value(t) for _, dofs, value in self._held if len(dofs)]

    def solve(self, step: HeatStepInput) -> HeatSolution:
        """Temperatures at the end of a step, with the bodies' present displacement; collective.

        Args:
            step: What it starts from.

        Returns:
            The temperatures and where their heat came from.
        """
        stages = [[theta.copy() for theta in step.theta] for _ in self.scheme.nodes]
        for stage, alpha in zip(stages, self.scheme.nodes, strict=True):
            self.set_held(step.t + alpha * step.dt, stage)
        with self.timers.book("heat.assembly"):
            given = self._given(step)
        try:
            residual, reason = self._iterate(step, stages, given)
        except PETSc.Error as error:
            self._matrix.forget()
            residual = self._residual(step, stages, given)[-1]
            reason = f"heat: linear solver failed (PETSc error {error.ierr})"
        end = [
            np.sum([w * stage[b] for w, stage in zip(self.scheme.end, stages, strict=True)], axis=0)
            for b in range(len(self.bodies))
        ]
        return HeatSolution(end, stages, self._balance(step, stages, given, residual, end), reason)

    def _iterate(
        self,
        step: HeatStepInput,
        stages: Sequence[Sequence[Floats]],
        given: Sequence[Sequence[Floats]],
    ) -> tuple[Sequence[Floats], str]:
        """Solve for the stages, in place; the residual of the last equation, and why it failed.

        Raises:
            PETSc.Error: The linear solver failed.
        """
        with self.timers.book("heat.assembly"):
            self._matrix.update(step.dt, self.interfaces, step.shares(self.scheme.points))
        largest = self._largest(step.theta, stages)
        first, k = 0.0, 0
        while True:
            with self.timers.book("heat.residual"):
                parts = self._residual(step, stages, given)
                residual, norm = self._matrix.vector([self._gathered(p) for p in parts])
            first = first or norm
            if norm <= max(TOLERANCE * first, ROUND_OFF * largest * self._matrix.size):
                return parts[-1], ""
            if k == SOLVES or not np.isfinite(norm):
                break
            with self.timers.book("heat.solve"):
                corrections = self._matrix.solve(residual)
            for stage, correction in zip(stages, corrections, strict=True):
                self._correct(stage, correction)
            k += 1
        hint = "; without storage something must hold the temperature of every body"
        reason = f"heat: no solution, residual {norm:.1e} after {k} solves"
        return parts[-1], reason + (hint if self.scheme.steady else "")

    def _largest(self, theta: Sequence[Floats], stages: Sequence[Sequence[Floats]]) -> float:
        """Largest temperature of the start and the prescribed ones, in size [K]; collective."""
        arrays = [a for stage in (theta, *stages) for a in stage]
        largest = max(float(np.abs(a).max(initial=0.0)) for a in arrays)
        return float(self.comm.allreduce(largest, MPI.MAX))

    def _gathered(self, parts: Sequence[Floats]) -> Floats:
        """Local parts of all ranks summed over the unknowns of this one; collective."""
        self.x.set(0.0)
        self.add_fields(parts, self.x)
        return np.asarray(self.x.array_r.copy())

    def _correct(self, stage: Sequence[Floats], correction: Floats) -> None:
        """Subtract a correction of this rank's unknowns from the bodies' arrays; collective."""
        self.x.array[:] = correction
        changes = [np.zeros_like(array) for array in stage]
        self.to_fields(self.x, changes)
        for array, change in zip(stage, changes, strict=True):
            array -= change

    def _given(self, step: HeatStepInput) -> list[list[Floats]]:
        """What does not depend on the unknowns, per equation and body [J/m]: loads, friction."""
        times = step.t + self.scheme.points * step.dt
        supplies = [[body.supplied(float(t)) for body in self.bodies] for t in times]
        steady = [
            -body.cooled(theta, u, step.dt)
            for body, theta, u in zip(self.bodies, step.theta, step.u, strict=True)
        ]
        for interface, exchange in zip(self.interfaces, step.exchanges, strict=True):
            interface.nodes.scatter(exchange.friction, steady)
        return [
            [
                step.dt
                * (
                    weights.sum() * fixed
                    + sum(w * s[b] for w, s in zip(weights, supplies, strict=True))
                )
                for b, fixed in enumerate(steady)
            ]
            for weights in self.scheme.test
        ]

    def _residual(
        self,
        step: HeatStepInput,
        stages: Sequence[Sequence[Floats]],
        given: Sequence[Sequence[Floats]],
    ) -> list[list[Floats]]:
        """Local parts of the equations of all stages, prescribed dofs included [J/m]."""
        scheme = self.scheme
        by_stage, by_start = scheme.test @ scheme.trial, scheme.test @ scheme.trial_start
        result = []
        for k, supply in enumerate(given):
            growth = _combined(scheme.rate[k], scheme.rate_start[k], stages, step.theta)
            mean = _combined(by_stage[k], by_start[k], stages, step.theta)
            parts = [
                step.dt * body.conducted(m) - s
                for body, m, s in zip(self.bodies, mean, supply, strict=True)
            ]
            if not scheme.steady:
                for part, body, g in zip(parts, self.bodies, growth, strict=True):
                    part += body.stored(g)
            for interface, power in self._crossing(step, stages, scheme.test[k]):
                interface.nodes.scatter(power, parts)
            result.append(parts)
        return result

    def _crossing(
        self, step: HeatStepInput, stages: Sequence[Sequence[Floats]], test: Floats
    ) -> list[tuple[HeatInterface, Floats]]:
        """Heat that leaves the nodes of each interface that conducts, weighted [J/m]; collective.

        Conductance is linear over the step, so that the coupled scheme is of second order.
        """
        scheme, times = self.scheme, step.t + self.scheme.points * step.dt
        shares = [(test * share, exchanges) for share, exchanges in step.shares(scheme.points)]
        means = [
            _combined(w @ scheme.trial, float(w @ scheme.trial_start), stages, step.theta)
            for w, _ in shares
        ]
        result: list[tuple[HeatInterface, Floats]] = []
        for k, interface in enumerate(self.interfaces):
            if not interface.conducts:
                continue
            power: Floats = np.zeros(len(interface.nodes.mesh.X))
            for (w, exchanges), mean in zip(shares, means, strict=True):
                theta = interface.nodes.gather(mean, interface.obstacle_mean(times, w))
                power += step.dt * (exchanges[k].conduction @ theta)
            result.append((interface, power))
        return result

    def _balance(
        self,
        step: HeatStepInput,
        stages: Sequence[Sequence[Floats]],
        given: Sequence[Sequence[Floats]],
        residual: Sequence[Floats],
        end: Sequence[Floats],
    ) -> HeatBalance:
        """Where the heat of a step came from; collective."""
        scheme = self.scheme
        weights = scheme.test[-1]
        mean = _combined(weights @ scheme.trial, weights @ scheme.trial_start, stages, step.theta)
        stored = strained = loads = inside = crossed = 0.0
        for b, body in enumerate(self.bodies):
            if not scheme.steady:
                change = end[b] - step.theta[b]
                stored += float(body.stored(change).sum())
                inside += float(body.stored(np.abs(change)).sum())
            cooled = step.dt * float(body.cooled(step.theta[b], step.u[b], step.dt).sum())
            strained -= cooled
            loads += float(given[-1][b].sum()) + cooled
            loads -= step.dt * float(body.conducted(mean[b]).sum())
        friction = obstacles = 0.0
        for interface, exchange in zip(self.interfaces, step.exchanges, strict=True):
            own = interface.nodes.is_of_body
            friction += step.dt * float(exchange.friction[own].sum())
        for interface, power in self._crossing(step, stages, weights):
            own = interface.nodes.is_of_body
            crossed += float(np.abs(power[: interface.nodes.mesh.n_nonmortar]).sum())
            obstacles -= float(power[own].sum()) if interface.nodes.is_rigid else 0.0
        held = [
            float(residual[body][dofs].sum())
            for (body, _, _), dofs in zip(self._held, self._counted, strict=True)
        ]
        sums = self.comm.allreduce(np.array((stored, strained, loads, inside, *held)))
        return HeatBalance(
            stored=float(sums[0]),
            held=tuple(float(v) for v in sums[4:]),
            loads=float(sums[2]) - friction,
            friction=friction,
            obstacles=obstacles,
            strained=float(sums[1]),
            moved=float(sums[3]) + crossed,
        )


def _combined(
    weights: Floats, start: float, stages: Sequence[Sequence[Floats]], theta: Sequence[Floats]
) -> list[Floats]:
    """Sum of weighted stages and start, per body."""
    return [
        start * begin + sum(w * stage[b] for w, stage in zip(weights, stages, strict=True))
        for b, begin in enumerate(theta)
    ]


def _values(body: HeatBody, held: PrescribedTemperature) -> Callable[[float], Floats | float]:
    """Prescribed values at a body's dofs over time."""
    value = held.value
    if isinstance(value, Table):
        return value
    points = body.V.tabulate_dof_coordinates()[body.dofs(held.vertices)].T
    return lambda t: value(points, t)
