"""What is reported of heat in an accepted step, and whether the time scheme rings."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from mpi4py import MPI

from contactfem.results import HeatStep
from contactfem.ringing import STEPS, Increment, ringing
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
        self._last: list[Floats] | None = None
        self._increments: list[Increment] = []
        self._largest = 0.0

    def step(self, outcome: HeatOutcome, before: Sequence[Floats]) -> HeatStep:
        """Report of an accepted step; collective.

        Args:
            outcome: Its heat side.
            before: Temperatures at its start, flat local arrays of the bodies [K].
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
        return HeatStep(
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
            rings=self._rings([before, *outcome.solution.stages]),
        )

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

    def _rings(self, stages: Sequence[Sequence[Floats]]) -> str:
        """Whether the temperature rings, from the increments of the last steps; collective."""
        scheme = self._thermal.system.scheme
        if scheme.l_stable:
            return ""
        for before, now in pairwise(stages):
            change = [b - a for a, b in zip(before, now, strict=True)]
            norm = float(np.sqrt(max(self._thermal.product(change, change), 0.0)))
            inner = 0.0 if self._last is None else self._thermal.product(change, self._last)
            self._increments.append(Increment(norm, inner))
            self._last, self._largest = change, max(self._largest, norm)
        self._increments = self._increments[-(STEPS + 1) * len(scheme.nodes) :]
        found = ringing(scheme, self._increments, self._largest)
        return "" if found is None else str(found)
