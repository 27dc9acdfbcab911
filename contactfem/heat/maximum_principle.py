"""Bounds that temperatures cannot leave: the maximum principle of heat conduction."""

from collections.abc import Sequence

import numpy as np

from mpi4py import MPI

from contactfem.common.time_table import Table
from contactfem.common.typing import Floats
from contactfem.heat.body import HeatLoad
from contactfem.heat.interface import HeatExchange
from contactfem.heat.system import HeatSystem

Bounds = tuple[float | None, float | None]  # lower and upper [K]; None where nothing bounds


def widened(
    bounds: Bounds, system: HeatSystem, t: float, dt: float, exchanges: Sequence[HeatExchange]
) -> Bounds:
    """Bounds after one more step: what is prescribed in it, and no upper one where heat enters.

    Args:
        bounds: Before it.
        system: Heat of all bodies.
        t: Time at its start [s].
        dt: Its length [s].
        exchanges: Of the interfaces.

    Returns:
        The bounds; collective.
    """
    times = [float(s) for s in t + dt * np.union1d(system.scheme.nodes, system.scheme.points)]
    seen: list[Floats] = [np.zeros(0)]
    heats = any(float(exchange.friction.sum()) > 0.0 for exchange in exchanges)
    cools = False
    for body in system.bodies:
        if body.law.cooling is not None:
            return None, None
        for load in body.loads:
            if load.coefficient is None:
                up, down = _signs(load, times)
                heats, cools = heats or up, cools or down
            elif isinstance(load.value, Table):
                seen.append(np.array([load.value(s) for s in times]))
            else:
                return None, None
    for interface in system.interfaces:
        if interface.conducts and interface.law.obstacle is not None:
            seen.append(np.array([interface.law.obstacle(s) for s in times]))
    seen += [
        np.array(values, np.float64, ndmin=1) for s in times for values in system.prescribed(s)
    ]
    lowest, highest = _range(system.comm, seen)
    low, high = bounds
    return (
        None if low is None or cools else min(low, lowest),
        None if high is None or heats else max(high, highest),
    )


def outside(bounds: Bounds, lowest: float, highest: float) -> float:
    """How far temperatures are out of their bounds, over the range of both [-]."""
    low = lowest if bounds[0] is None else bounds[0]
    high = highest if bounds[1] is None else bounds[1]
    beyond = max(low - lowest, highest - high, 0.0)
    span = max(high, highest) - min(low, lowest)
    return beyond / span if beyond > 0.0 else 0.0


def _signs(load: HeatLoad, times: Sequence[float]) -> tuple[bool, bool]:
    """Whether a source or flux heats, and whether it cools; both where it varies over place."""
    if not isinstance(load.value, Table):
        return True, True
    values = [load.value(s) for s in times]
    return max(values) > 0.0, min(values) < 0.0


def _range(comm: MPI.Comm, arrays: Sequence[Floats]) -> tuple[float, float]:
    """Smallest and largest value of all ranks; collective."""
    top = max(float(a.max(initial=-np.inf)) for a in arrays)
    bottom = max(float((-a).max(initial=-np.inf)) for a in arrays)
    found = np.array((top, bottom))
    comm.Allreduce(MPI.IN_PLACE, found, MPI.MAX)
    return -float(found[1]), float(found[0])
