"""What a step starts from where there was no contact before it."""

import numpy as np

from contactfem.common.typing import Bools, Floats
from contactfem.laws.active_set import ActiveSet, Status

TOUCH = 1e-9  # gap over facet length at which surfaces touch
FIRST_CONTACT = 0.3  # share of the range of gaps that sticks first where contact alone holds a body


def initial_active_set(
    gap: Floats, size: Floats, seen: Bools, held_by_contact: bool
) -> ActiveSet | None:
    """Status that a first contact starts from: some nodes stick for one iteration.

    Args:
        gap: Mean gap of the nodes [m], (n,).
        size: Facet length of the nodes [m], (n,).
        seen: Nodes that carry a multiplier and face the other side, (n,).
        held_by_contact: Whether only contact can hold a body of this interface: then the nodes in
            the lowest 30 % of the range of gaps close, otherwise those that touch.

    Returns:
        Status of every node; None where no node touches and none has to.
    """
    stick = seen & (np.abs(gap) <= TOUCH * size)
    if held_by_contact and seen.any():
        low, high = gap[seen].min(), gap[seen].max()
        stick = seen & (gap <= low + FIRST_CONTACT * (high - low))
    if not stick.any():
        return None
    status = np.where(stick, Status.STICK, Status.OPEN).astype(np.int8)
    return ActiveSet(status, np.zeros(len(gap)))
