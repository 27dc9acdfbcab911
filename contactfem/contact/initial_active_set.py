"""What a step starts from where there was no contact before it."""

import numpy as np

from contactfem.common.typing import Floats
from contactfem.laws.active_set import ActiveSet, Status
from contactfem.mortar.mortar_operators import MortarOperators

TOUCH = 1e-9  # gap over facet size at which surfaces touch
# Where contact alone holds a body, what sticks first:
FIRST_CONTACT = 0.3  # share of the range of gaps that count
COUNTED = (
    0.25  # of the surface's extent, and two facets at least: gaps up to the smallest plus this
)
NEAR = 0.02  # share of the facets' size, where the former did not do


def initial_active_set(
    operators: MortarOperators, gap: Floats, held_by_contact: bool, cautious: bool = False
) -> ActiveSet | None:
    """Active set that a first contact starts from: some nodes stick for one iteration.

    Args:
        operators: At the positions where the step starts.
        gap: Gap that the conditions see there [m], (n,).
        held_by_contact: Whether only contact can hold a body of this interface: then the nodes in
            the lowest 30 % of the range of gaps close, otherwise those that touch.
        cautious: Whether no gap closes that is larger than the smallest one by more than 2 % of a
            facet: a polygon is then borne by its corners instead of being pressed flat.

    Returns:
        The active set; None where no node touches and none has to.
    """
    seen = np.isfinite(gap) & operators.mesh.has_multiplier
    stick = seen & (np.abs(gap) <= TOUCH * operators.size)
    if held_by_contact and seen.any():
        low = gap[seen].min()
        extent = float(np.linalg.norm(np.ptp(operators.x[: len(gap)], axis=0)))
        counted = max(COUNTED * extent, 4.0 * float(operators.size.max()))
        high = gap[seen & (gap <= low + counted)].max()
        near = np.full_like(gap, FIRST_CONTACT * (high - low))
        if cautious:
            near = np.minimum(near, NEAR * operators.size)
        stick = seen & (gap <= low + near)
    if not stick.any():
        return None
    status = np.where(stick, Status.STICK, Status.OPEN).astype(np.int8)
    return ActiveSet(status, np.zeros((len(gap), operators.mesh.dim)))
