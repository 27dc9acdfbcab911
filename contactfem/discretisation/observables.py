"""What is observed of a step as a whole: forces of the interfaces, and temperatures."""

from collections.abc import Sequence

import numpy as np

from mpi4py import MPI

from contactfem.common.typing import Floats
from contactfem.contact.state import Conditions
from contactfem.discretisation.discretise import Discretisation
from contactfem.results.data import Observed


def forces(
    discretisation: Discretisation, conditions: Sequence[Conditions]
) -> dict[str, tuple[float, float]]:
    """Resultant of every interface on its mortar side [N/m].

    Args:
        discretisation: The interfaces.
        conditions: Contact conditions of each.
    """
    result = {}
    for interface, c in zip(discretisation.interfaces, conditions, strict=True):
        force = -c.nodal_forces()[len(c.multiplier) :].sum(0)
        result[interface.name] = (float(force[0]), float(force[1]))
    return result


def observed(
    discretisation: Discretisation,
    conditions: Sequence[Conditions],
    theta: Sequence[Floats] | None,
) -> Observed:
    """Forces, and the hottest and the mean temperature, the latter by ρ₀ c; collective.

    Args:
        discretisation: Bodies and interfaces.
        conditions: Contact conditions of each interface.
        theta: Temperatures, flat local arrays of the bodies [K]; None without heat.
    """
    found = forces(discretisation, conditions)
    thermal = discretisation.heat
    if theta is None or thermal is None:
        return Observed(found, None, None)
    mine = max(float(values.max(initial=-np.inf)) for values in theta)
    top = float(thermal.system.comm.allreduce(mine, MPI.MAX))
    ones = [np.ones_like(values) for values in theta]
    capacity = thermal.product(ones, ones)
    return Observed(found, top, thermal.product(ones, theta) / capacity if capacity else None)
