"""Resultants of a step: interface forces, largest and mean temperature."""

from collections.abc import Sequence

import numpy as np

from mpi4py import MPI

from contactfem.common.typing import Floats
from contactfem.contact.state import ContactState
from contactfem.discretisation.discretise import Discretisation
from contactfem.results.data import Observables


def forces(
    discretisation: Discretisation, conditions: Sequence[ContactState]
) -> dict[str, tuple[float, ...]]:
    """Resultant of every interface on its mortar side [N/m], in space [N].

    Args:
        discretisation: The interfaces.
        conditions: Contact conditions of each.
    """
    result = {}
    for interface, c in zip(discretisation.interfaces, conditions, strict=True):
        force = -c.nodal_forces()[len(c.status) :].sum(0)
        result[interface.name] = tuple(float(part) for part in force)
    return result


def observed(
    discretisation: Discretisation,
    conditions: Sequence[ContactState],
    theta: Sequence[Floats] | None,
) -> Observables:
    """Forces, and the hottest and the mean temperature, the latter by ρ₀ c; collective.

    Args:
        discretisation: Bodies and interfaces.
        conditions: Contact conditions of each interface.
        theta: Temperatures, flat local arrays of the bodies [K]; None without heat.
    """
    found = forces(discretisation, conditions)
    thermal = discretisation.heat
    if theta is None or thermal is None:
        return Observables(found, None, None)
    mine = max(float(values.max(initial=-np.inf)) for values in theta)
    top = float(thermal.system.comm.allreduce(mine, MPI.MAX))
    ones = [np.ones_like(values) for values in theta]
    capacity = thermal.product(ones, ones)
    return Observables(found, top, thermal.product(ones, theta) / capacity if capacity else None)
