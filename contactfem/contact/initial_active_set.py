"""What a step starts from where there was no contact before it."""

import numpy as np

from contactfem.common.typing import Floats
from contactfem.laws.active_set import ActiveSet, Status
from contactfem.mortar.mortar_operators import MortarOperators

TOUCH = 1e-9  # gap over facet size at which surfaces touch
FIRST_CONTACT = 0.3  # share of the range of gaps that sticks first where contact alone holds a body


def initial_active_set(
    operators: MortarOperators, gap: Floats, held_by_contact: bool
) -> ActiveSet | None:
    """Active set that a first contact starts from: some nodes stick for one iteration.

    Args:
        operators: At the positions where the step starts.
        gap: Gap that the conditions see there [m], (n,).
        held_by_contact: Whether only contact can hold a body of this interface: then the nodes in
            the lowest 30 % of the range of gaps close, otherwise those that touch.

    Returns:
        The active set; None where no node touches and none has to.
    """
    seen = np.isfinite(gap) & operators.mesh.has_multiplier
    stick = seen & (np.abs(gap) <= TOUCH * operators.size)
    if held_by_contact and seen.any():
        low, high = gap[seen].min(), gap[seen].max()
        stick = seen & (gap <= low + FIRST_CONTACT * (high - low))
    if not stick.any():
        return None
    status = np.where(stick, Status.STICK, Status.OPEN).astype(np.int8)
    return ActiveSet(status, np.zeros((len(gap), operators.mesh.dim)))
