"""The nodes of one body's surface that a rank owns."""

from dataclasses import dataclass

import numpy as np

from contactfem.common.typing import Ints
from contactfem.mortar.sides import BodySide


@dataclass(frozen=True)
class SurfaceNodes:
    """Owned vertices of one body on one side of an interface.

    Attributes:
        body: Index of the body.
        node: Their numbers among the nodes of the interface, (k,).
        dofs: Their local dofs, one row per vertex, (k, components).
    """

    body: int
    node: Ints
    dofs: Ints


def owned_nodes(
    side: BodySide, offset: int, vertices: Ints, vertex_dofs: Ints, n_owned: int
) -> SurfaceNodes:
    """Find the vertices of a side that this rank owns.

    Args:
        side: The side.
        offset: Number of its first node among the nodes of the interface.
        vertices: Vertices of the body that this rank knows, as the body's mesh numbers them, (m,).
        vertex_dofs: Their local dofs, (m, components).
        n_owned: Number of local dofs, counted as those of the first component, that it owns.

    Returns:
        The nodes.
    """
    order = np.argsort(side.surface.vertices)
    at = np.searchsorted(side.surface.vertices[order], vertices)
    at = np.minimum(at, len(order) - 1)
    owned = vertex_dofs[:, 0] < n_owned
    here = owned & (side.surface.vertices[order[at]] == vertices)
    return SurfaceNodes(side.body, order[at[here]] + offset, vertex_dofs[here])
