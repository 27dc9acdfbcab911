"""Heat of an accepted step: balance, range, ringing."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from mpi4py import MPI

from contactfem.common.typing import Floats
from contactfem.heat.maximum_principle import outside, widened
from contactfem.heat.ringing import (
    COLD,
    STEPS,
    Increment,
    Increments,
    Zigzag,
    local_ringing,
    ringing,
)
from contactfem.results.data import HeatStep
from contactfem.thermomechanics.staggered import HeatOutcome
from contactfem.thermomechanics.thermal_problem import Thermal


class HeatRecord:
    """Makes the heat side of step reports.

    Args:
        thermal: The heat side of the run.
    """

    def __init__(self, thermal: Thermal) -> None:
        self._thermal = thermal

    def step(
        self,
        outcome: HeatOutcome,
        before: Sequence[Floats],
        increments: Increments,
        last: HeatStep | None,
    ) -> tuple[HeatStep, Increments]:
        """Report of an accepted step; collective.

        Args:
            outcome: Its heat side.
            before: Temperatures at its start, flat local arrays of the bodies [K].
            increments: Of the steps before it.
            last: Report of the step before it, if there was one.

        Returns:
            The report, and the increments with those of this step.
        """
        theta, balance = outcome.solution.theta, outcome.solution.balance
        low, high = self._range(theta)
        bounds = last.bounds if last is not None else self._range(before)
        start, system = float(outcome.at[0]) - outcome.dt, self._thermal.system
        bounds = widened(bounds, system, start, outcome.dt, outcome.exchanges)
        flow = {
            link.heat.name: self._flow(k, theta, outcome)
            for k, link in enumerate(self._thermal.interfaces)
        }
        held: dict[str, float] = {}
        for name, heat in zip(self._thermal.held, balance.held, strict=True):
            held[name] = held.get(name, 0.0) + heat
        increments = self._grown(increments, [before, *outcome.solution.stages])
        pairs = zip(before, theta, strict=True)
        rates = [np.asarray((b - a) / outcome.dt) for a, b in pairs]
        increments = replace(increments, zigzags=self._zigzags(increments.zigzags, rates))
        report = HeatStep(
            passes=outcome.passes,
            change=outcome.change,
            temperature_min=low,
            temperature_max=high,
            stored=balance.stored,
            held=held,
            loads=balance.loads,
            friction=balance.friction,
            obstacles=balance.obstacles,
            strained=balance.strained,
            defect=balance.defect,
            flow=flow,
            friction_defect=max((abs(e.defect) for e in outcome.exchanges), default=0.0),
            rings=self._rings(increments, outcome.dt, high - low),
            moved=balance.moved,
            bounds=bounds,
            outside=outside(bounds, low, high),
        )
        return report, increments

    def _range(self, theta: Sequence[Floats]) -> tuple[float, float]:
        """Smallest and largest temperature [K]; collective."""
        top = max(float(values.max(initial=-np.inf)) for values in theta)
        bottom = max(float((-values).max(initial=-np.inf)) for values in theta)
        found = np.array((top, bottom))
        self._thermal.system.comm.Allreduce(MPI.IN_PLACE, found, MPI.MAX)
        return -float(found[1]), float(found[0])

    def _flow(self, k: int, theta: Sequence[Floats], outcome: HeatOutcome) -> float:
        """∫ q da through an interface, from nonmortar to mortar [W/m]; collective."""
        interface = self._thermal.interfaces[k].heat
        at = interface.nodes.gather(theta, interface.obstacle_mean(outcome.at, np.ones(1)))
        power = outcome.exchanges[k].conduction @ at
        return float(power[: interface.nodes.mesh.n_nonmortar].sum())

    def _rings(self, increments: Increments, dt: float, span: float) -> str:
        """What is said of ringing, of the whole or of single temperatures; collective."""
        scheme = self._thermal.system.scheme
        found = ringing(scheme, increments.recent, increments.largest) if span > COLD else None
        amplitude = max((z.amplitude(dt) for z in increments.zigzags), default=0.0)
        amplitude = self._thermal.system.comm.allreduce(amplitude, MPI.MAX)
        return str(found) if found is not None else local_ringing(scheme, amplitude, span)

    def _zigzags(self, zigzags: Sequence[Zigzag], rates: Sequence[Floats]) -> tuple[Zigzag, ...]:
        """Zigzags of the bodies with one more step; none for a scheme that does not ring."""
        if self._thermal.system.scheme.l_stable:
            return ()
        if not zigzags:
            return tuple(Zigzag.begun(rate) for rate in rates)
        return tuple(z.followed(rate) for z, rate in zip(zigzags, rates, strict=True))

    def _grown(self, increments: Increments, stages: Sequence[Sequence[Floats]]) -> Increments:
        """Increments with those from stage to stage of one more step; collective."""
        scheme = self._thermal.system.scheme
        if scheme.l_stable:
            return increments
        last, recent, largest = increments.last, list(increments.recent), increments.largest
        for before, now in pairwise(stages):
            change = tuple(b - a for a, b in zip(before, now, strict=True))
            norm = float(np.sqrt(max(self._thermal.product(change, change), 0.0)))
            inner = self._thermal.product(change, last) if last else 0.0
            recent.append(Increment(norm, inner))
            last, largest = change, max(largest, norm)
        kept = tuple(recent[-(STEPS + 1) * len(scheme.nodes) :])
        return replace(increments, last=last, recent=kept, largest=largest)
