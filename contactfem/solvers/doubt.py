"""Whether the answer of a step can be trusted: friction of nodes that were nowhere near before."""

from collections.abc import Sequence

import numpy as np

from contactfem.contact.state import Conditions
from contactfem.mechanics.condensed import Interface

SHARE = 0.01  # of the normal force of an interface that may stand on nodes without slip


def doubt(interfaces: Sequence[Interface], conditions: Sequence[Conditions]) -> str:
    """What is wrong with a step that was solved.

    Slip is an increment from the start of the step, so a node that faced nothing there (D⁰ = 0) has
    none, and no friction either unless it follows a neighbour. That is right for the edge of a
    contact that moves on, but not for all of a contact that lands or leaves its place in one step.

    Args:
        interfaces: The interfaces.
        conditions: Of each, where the step was solved.

    Returns:
        One sentence, empty where there is no doubt.
    """
    for interface, c in zip(interfaces, conditions, strict=True):
        if not interface.contact.law.rubs:
            continue
        force = np.where(c.active, c.operators.D * np.abs(c.pressure), 0.0)
        lost = (c.history.D <= 0.0) & (c.direction == 0.0)
        share = force[lost].sum() / force.sum() if force.any() else 0.0
        if share > SHARE:
            return (
                f"{share:.0%} of the normal force at '{interface.name}' is on nodes that faced "
                "nothing when the step began, so their friction is not known"
            )
    return ""
