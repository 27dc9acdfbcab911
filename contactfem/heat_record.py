"""What is reported of heat in an accepted step, and whether the time scheme rings."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from mpi4py import MPI

from contactfem.results import HeatStep
from contactfem.ringing import STEPS, Increment, Increments, ringing
from contactfem.staggered import HeatOutcome
from contactfem.surfaces import Floats
from contactfem.thermal import Thermal


class HeatRecord:
    """Makes the heat side of step reports.

    Args:
        thermal: The heat side of the run.
    """

    def __init__(self, thermal: Thermal) -> None:
        self._thermal = thermal

    def step(
        self, outcome: HeatOutcome, before: Sequence[Floats], increments: Increments
    ) -> tuple[HeatStep, Increments]:
        """Report of an accepted step; collective.

        Args:
            outcome: Its heat side.
            before: Temperatures at its start, flat local arrays of the bodies [K].
            increments: Of the steps before it.

        Returns:
            The report, and the increments with those of this step.
        """
        theta, balance = outcome.solution.theta, outcome.solution.balance
        low, high = self._range(theta)
        flow = {
            link.heat.name: self._flow(k, theta, outcome)
            for k, link in enumerate(self._thermal.interfaces)
        }
        held: dict[str, float] = {}
        for name, heat in zip(self._thermal.held, balance.held, strict=True):
            held[name] = held.get(name, 0.0) + heat
        increments = self._grown(increments, [before, *outcome.solution.stages])
        found = ringing(self._thermal.system.scheme, increments.recent, increments.largest)
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
            rings="" if found is None else str(found),
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
        return Increments(last, tuple(recent[-(STEPS + 1) * len(scheme.nodes) :]), largest)
