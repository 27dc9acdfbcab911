"""Why a step failed, and whether an accepted one is doubtful."""

from collections.abc import Collection, Sequence

import numpy as np

from contactfem.common.typing import Floats
from contactfem.contact.state import ContactState
from contactfem.laws.active_set import Status
from contactfem.mechanics.contact_equations import Interface

SHOWN = 4  # nodes named in a message


def explain(
    interfaces: Sequence[Interface],
    iterations: Sequence[Sequence[ContactState]],
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
        if law.has_friction and any(_only_slips(c) for c in course):
            return (
                f"all nodes in contact at '{interface.name}' slip, and nothing but friction holds "
                "the body there: the load may exceed what friction can carry "
                f"({law.friction}), and then there is no equilibrium; lower the load, or prescribe "
                "a motion instead of it"
            )
        if course and not (course[-1].multiplier.pressure[course[-1].active] > 0.0).any():
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


def _only_slips(c: ContactState) -> bool:
    """Whether there is contact and every node of it slips."""
    return bool(c.active.any()) and not bool((c.status == Status.STICK).any())


def _flips(name: str, old: ContactState, new: ContactState) -> str:
    """Nodes of one interface whose status changed in the last iteration."""
    nodes = np.flatnonzero(new.active_set.differs_from(old.active_set))
    if not len(nodes):
        return ""
    shown = [
        f"node {j} at ({_listed(new.operators.x[j], '.6g')}) m {_word(old, j)} -> {_word(new, j)}"
        for j in map(int, nodes[:SHOWN])
    ]
    more = f" and {len(nodes) - SHOWN} more" if len(nodes) > SHOWN else ""
    return f"'{name}': {', '.join(shown)}{more}"


def _word(c: ContactState, node: int) -> str:
    """Status of a node, with the direction of its slip."""
    direction, word = c.active_set.direction[node], Status(int(c.status[node])).name.lower()
    return f"{word} along ({_listed(direction, '.2f')})" if direction.any() else word


def _listed(values: Floats, form: str) -> str:
    """Numbers with commas between them."""
    return ", ".join(f"{value + 0.0:{form}}" for value in values)


WITHOUT_SLIP = 0.01  # of the normal force of an interface that may stand on nodes without slip


def trust_check(interfaces: Sequence[Interface], conditions: Sequence[ContactState]) -> str:
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
        if not interface.contact.law.has_friction:
            continue
        force = np.where(c.active, c.operators.D * np.abs(c.multiplier.pressure), 0.0)
        lost = (c.history.D <= 0.0) & ~c.active_set.direction.any(axis=1)
        share = force[lost].sum() / force.sum() if force.any() else 0.0
        if share > WITHOUT_SLIP:
            return (
                f"{share:.0%} of the normal force at '{interface.name}' is on nodes that faced "
                "nothing when the step began, so their friction is not known"
            )
    return ""
