"""Nodes that stand on several surfaces of interfaces: they carry no multiplier.

Forces of a node with a multiplier are eliminated once, so it must not stand in two interfaces.
Where surfaces share a node, at an end of each, the multiplier of its neighbour acts for it too (the
modified basis of `mortar`); this passes a uniform pressure on exactly, as at prescribed nodes.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from contactfem.common.typing import Bools, Ints
from contactfem.errors import CaseError
from contactfem.mortar.interface_mesh import InterfaceMesh

Side = tuple[int, Ints]  # body, and its vertices on a surface


def shared_nodes(interfaces: Mapping[str, tuple[Side, Side | None]]) -> dict[str, Bools]:
    """Nonmortar nodes that are on another surface of some interface as well.

    Args:
        interfaces: Nonmortar and mortar side of each; None for an obstacle.

    Returns:
        Whether each nonmortar node is shared, by interface.
    """
    count = Counter(
        (side[0], int(vertex))
        for sides in interfaces.values()
        for side in sides
        if side is not None
        for vertex in side[1]
    )
    return {
        name: np.array([count[body, int(vertex)] > 1 for vertex in vertices])
        for name, ((body, vertices), _) in interfaces.items()
    }


def check_shared(meshes: Mapping[str, InterfaceMesh]) -> None:
    """Make sure that contact has multipliers, and that every shared node has one beside it.

    Args:
        meshes: The interfaces by name.

    Raises:
        CaseError: A surface or a facet has none, so contact would not see it.
    """
    for name, mesh in meshes.items():
        free = replace(mesh, shared=None).has_multiplier  # what sharing takes is said below
        if not free.any():
            raise CaseError(
                f"interface {name}: no node of the nonmortar surface is free to move, so it has no "
                "multiplier and contact would act on nothing; exchange nonmortar and mortar"
            )
        if mesh.shared is None:
            continue
        ends, served = mesh.nonmortar, mesh.has_multiplier
        if mesh.dim == 3:  # multipliers reach further than one facet there
            served = np.asarray(mesh.extension.sum(axis=1)).ravel() > 0.0
        lost = mesh.shared[ends].any(1) & ~served[ends].any(1)
        if lost.any():
            place = ", ".join(f"{c:g}" for c in mesh.X[ends[np.argmax(lost)]].mean(0))
            raise CaseError(
                f"interface {name}: nodes of the nonmortar facet at ({place}) m are on "
                "surfaces of other interfaces as well, and none carries a multiplier; refine the "
                "surface, split it, or make it the mortar side"
            )
