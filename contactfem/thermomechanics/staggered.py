"""The staggered step: mechanics, exchange, heat, and again."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mpi4py import MPI

from contactfem.common.typing import Floats
from contactfem.contact.state import ContactState
from contactfem.heat.interface import HeatExchange
from contactfem.heat.system import HeatSolution
from contactfem.solvers.newton import NewtonSolver, SolveReport, StepInput
from contactfem.thermomechanics.thermal_problem import Thermal

NOTABLE = 0.01  # change of temperatures or a conductance that is followed up
FIXED = 1e-4  # change of temperatures over their range at which they count as a fixed point
LIMIT = 40  # passes to a fixed point
ROUND_OFF = 1e-9  # range of temperatures over their size that is none


@dataclass(frozen=True)
class HeatOutcome:
    """The heat side of a coupled step.

    Attributes:
        solution: Temperatures at its end, and the balance.
        exchanges: Of the interfaces.
        passes: How often mechanics and heat were solved.
        change: Last change of temperature over its range [-].
        at: The end of the step [s], (1,).
        dt: Its length [s].
    """

    solution: HeatSolution
    exchanges: Sequence[HeatExchange]
    passes: int
    change: float
    at: Floats
    dt: float


@dataclass(frozen=True)
class HeatStart:
    """What heat starts a step from.

    Attributes:
        t: Time [s].
        theta: Temperatures [K], flat local arrays of the bodies.
        u: Displacements on the thermal meshes [m], likewise.
        exchanges: Of the interfaces; empty where they are not known.
        rate: Of temperatures in the step before [K/s], likewise; empty where there is none.
    """

    t: float
    theta: Sequence[Floats]
    u: Sequence[Floats]
    exchanges: Sequence[HeatExchange] = ()
    rate: Sequence[Floats] = ()


@dataclass(frozen=True)
class Passes:
    """How often mechanics and heat are solved in one step.

    Attributes:
        most: Passes at most; None for one, and more up to the fixed point where it changes
            temperatures or a conductance by more than a percent.
        tolerance: Change of temperature over its range that ends them [-].
        relaxation: "aitken", or a fixed factor [-].
        respond: Whether mechanics depends on temperatures at all.
    """

    most: int | None
    tolerance: float
    relaxation: str | float
    respond: bool = True

    @property
    def limit(self) -> int:
        """Passes after which a step has failed."""
        if self.most is not None:
            return self.most
        return LIMIT if self.respond else 1

    def end(self, number: int, change: float, conductance: float) -> bool:
        """Whether a pass is the last one.

        Args:
            number: Of the pass, from 1.
            change: Of temperatures over their range [-].
            conductance: What that may change of a conductance [-].
        """
        if self.limit == 1:
            return True
        if self.most is not None:
            return change <= self.tolerance
        within = NOTABLE if number == 1 else max(self.tolerance, FIXED)
        return change <= within and conductance <= NOTABLE


class Staggered:
    """Isothermal split: the mechanical and the thermal problem one after the other.

    Args:
        solver: Of mechanics; None without it.
        thermal: The heat side.
        passes: How often both are solved.
    """

    def __init__(self, solver: NewtonSolver | None, thermal: Thermal, passes: Passes) -> None:
        self._solver, self._thermal, self._passes = solver, thermal, passes

    def attempt(self, step: StepInput, start: HeatStart) -> tuple[SolveReport, HeatOutcome | None]:
        """Solve one step; collective. The start of the step is not changed, the bodies are.

        Args:
            step: What mechanics starts from; `step.t` is the end of the step.
            start: What heat starts from.

        Returns:
            How mechanics ended, or why the passes did, and the heat side; None where it failed.
        """
        passes, guess = self._passes, self._predicted(step, start)
        report = SolveReport(True, "", 0, ())
        relaxation = _Relaxation(passes.relaxation, self._thermal)
        change, dt = 0.0, step.t - start.t
        for number in range(1, passes.limit + 1):
            report, conditions = self._mechanics(step, guess, report)
            if not report.converged:
                return report, None
            solution, exchanges = self._thermal.solve(
                start.theta, start.u, conditions, start.t, dt, step.ramp_end, start.exchanges
            )
            if solution.reason:
                return replace(report, converged=False, reason=solution.reason), None
            difference = [b - a for a, b in zip(guess, solution.theta, strict=True)]
            change = self._relative(difference, start.theta, solution.theta)
            if passes.end(number, change, self._conductance_change(conditions, difference)):
                end = np.array([step.t])
                return report, HeatOutcome(solution, exchanges, number, change, end, dt)
            factor = relaxation.factor(difference)
            guess = [a + factor * d for a, d in zip(guess, difference, strict=True)]
            step = self._again(step, conditions)
        reason = (
            f"temperatures still change by {change:.1e} of their range after "
            f"{passes.limit} passes (heat.max_passes)"
        )
        return replace(report, converged=False, reason=reason), None

    def _predicted(self, step: StepInput, start: HeatStart) -> list[Floats]:
        """Temperatures that the first pass of mechanics takes: those of the start, as in the paper.

        Unless passes are counted by the case: then as they would go on, and as they are prescribed,
        so that one pass has a lag of second order alone.
        """
        guess = [values.copy() for values in start.theta]
        if self._passes.most is None and self._passes.respond:
            for values, rate in zip(guess, start.rate, strict=False):
                values += (step.t - start.t) * rate
            self._thermal.system.set_held(step.t, guess)
        return guess

    def _conductance_change(
        self, conditions: Sequence[ContactState | None], difference: Sequence[Floats]
    ) -> float:
        """What a change of temperatures may change of a conductance by its gap [-]; collective."""
        if self._passes.most is not None or self._passes.limit == 1:
            return 0.0
        moved = self._thermal.expansions(difference)
        return self._thermal.conductance_change(conditions, moved)

    def _mechanics(
        self, step: StepInput, guess: Sequence[Floats], before: SolveReport
    ) -> tuple[SolveReport, Sequence[ContactState | None]]:
        """Mechanics at the guessed temperatures; iterations of all passes add up."""
        interfaces = self._thermal.interfaces
        if self._solver is None:
            return before, [None] * len(interfaces)
        with self._solver.timers.book("transfer"):
            self._thermal.set_temperature(guess)
            set_temperature = [
                self._thermal.surface_temperature(k, guess) for k in range(len(interfaces))
            ]
        histories = tuple(
            replace(history, temperature=temperature)
            for history, temperature in zip(step.histories, set_temperature, strict=True)
        )
        report = self._solver.solve(replace(step, histories=histories))
        report = replace(
            report,
            iterations=before.iterations + report.iterations,
            residuals=before.residuals + report.residuals,
        )
        return report, self._solver.conditions

    def _again(self, step: StepInput, conditions: Sequence[ContactState | None]) -> StepInput:
        """The same step from the contact status that the last pass found."""
        starts = tuple(None if c is None else c.active_set for c in conditions)
        return replace(step, starts=starts, known=True)

    def _relative(
        self, difference: Sequence[Floats], start: Sequence[Floats], end: Sequence[Floats]
    ) -> float:
        """Largest change over the range of temperatures of a step; collective."""
        theta = [*start, *end]
        largest = max(float(np.abs(d).max(initial=0.0)) for d in difference)
        top = max(float(values.max(initial=-np.inf)) for values in theta)
        bottom = max(float((-values).max(initial=-np.inf)) for values in theta)
        found = np.array((largest, top, bottom))
        self._thermal.system.comm.Allreduce(MPI.IN_PLACE, found, MPI.MAX)
        span = max(float(found[1] + found[2]), ROUND_OFF * float(np.abs(found[1:]).max()))
        return float(found[0]) / (span if span > 0.0 else 1.0)


class _Relaxation:
    """Factor on the change of a pass: fixed, or Aitken's from the changes of the last two."""

    def __init__(self, setting: str | float, thermal: Thermal) -> None:
        self._fixed = None if isinstance(setting, str) else setting
        self._thermal = thermal
        self._last: list[Floats] | None = None
        self._factor = 1.0

    def factor(self, difference: list[Floats]) -> float:
        """ω_k = -ω_k-1 (r_k-1, r_k - r_k-1) / |r_k - r_k-1|²; collective."""
        if self._fixed is not None:
            return self._fixed
        if self._last is not None:
            turn = [a - b for a, b in zip(difference, self._last, strict=True)]
            square = self._dot(turn, turn)
            if square > 0.0:
                self._factor *= -self._dot(self._last, turn) / square
        self._last = difference
        return self._factor

    def _dot(self, a: list[Floats], b: list[Floats]) -> float:
        """Product over the owned dofs of all bodies; collective."""
        mine = sum(
            float(x[: body.n_owned] @ y[: body.n_owned])
            for body, x, y in zip(self._thermal.bodies, a, b, strict=True)
        )
        return float(self._thermal.system.comm.allreduce(mine))
