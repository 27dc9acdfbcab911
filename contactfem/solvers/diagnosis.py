"""Say in words why a solve failed, from the contact status of its last two iterations."""

from collections.abc import Collection, Sequence

import numpy as np

from contactfem.contact.state import Conditions
from contactfem.laws.active_set import Status
from contactfem.mechanics.condensed import Interface

SHOWN = 4  # nodes named in a message


def explain(
    interfaces: Sequence[Interface],
    iterations: Sequence[Sequence[Conditions]],
    held_by_contact: Collection[str],
) -> str:
    """What the contact status says about a solve that did not converge.

    Args:
        interfaces: The interfaces.
        iterations: Conditions of every interface at every iteration.
        held_by_contact: Interfaces that alone hold a body.

    Returns:
        One sentence, empty where there is nothing to say.
    """
    for k, interface in enumerate(interfaces):
        if interface.name not in held_by_contact:
            continue
        law = interface.contact.law
        course = [conditions[k] for conditions in iterations]
        if law.rubs and any(_only_slips(c) for c in course):
            return (
                f"all nodes in contact at '{interface.name}' slip, and nothing but friction holds "
                "the body there: the load may exceed what friction can carry "
                f"({law.friction}), and then there is no equilibrium; lower the load, or prescribe "
                "a motion instead of it"
            )
        if course and not (course[-1].pressure[course[-1].active] > 0.0).any():
            return (
                f"contact at '{interface.name}' is lost, and nothing else holds the body there: "
                "the load may pull it off; hold the body by a condition, or change the load"
            )
    if len(iterations) < 2:
        return ""
    flips = [
        _flips(interface.name, old, new)
        for interface, old, new in zip(interfaces, iterations[-2], iterations[-1], strict=True)
    ]
    found = [text for text in flips if text]
    return (
        f"in the last iteration the contact status changed at {'; '.join(found)}" if found else ""
    )


def _only_slips(c: Conditions) -> bool:
    """Whether there is contact and every node of it slips."""
    return bool(c.active.any()) and not bool((c.status == Status.STICK).any())


def _flips(name: str, old: Conditions, new: Conditions) -> str:
    """Nodes of one interface whose status changed in the last iteration."""
    nodes = np.flatnonzero((old.status != new.status) | (old.direction != new.direction))
    if not len(nodes):
        return ""
    shown = [
        f"node {j} at ({new.operators.x[j, 0]:.6g}, {new.operators.x[j, 1]:.6g}) m "
        f"{_word(old, j)} -> {_word(new, j)}"
        for j in map(int, nodes[:SHOWN])
    ]
    more = f" and {len(nodes) - SHOWN} more" if len(nodes) > SHOWN else ""
    return f"'{name}': {', '.join(shown)}{more}"


def _word(c: Conditions, node: int) -> str:
    """Status of a node, with the direction of its slip."""
    sign = {1.0: "+", -1.0: "-"}.get(float(c.direction[node]), "")
    return Status(int(c.status[node])).name.lower() + sign
