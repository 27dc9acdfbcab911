"""Thickness of a body behind its surface, along straight lines."""

import numpy as np

from contactfem.common.typing import Floats, Ints

BESIDE = 1e-9  # of the size of the outline: what lies nearer than that is where the line starts
AT_ONCE = 2**20  # pairs of lines and facets


def thickness(points: Floats, normals: Floats, outline: Floats) -> tuple[Floats, Ints]:
    """How far a body reaches behind points of its surface.

    Args:
        points: Points on the surface [m], (n, 2).
        normals: Outward unit normals there [-], (n, 2).
        outline: Both ends of all facets around the body, walked with the body on the left [m],
            (b, 2, 2).

    Returns:
        Length of the line from each point against its normal to where it leaves the body [m], (n,);
        infinite where it does not. The facet through which it leaves, -1 for none, (n,).
    """
    size = float(np.ptp(outline.reshape(-1, 2), axis=0).max(initial=0.0))
    step = max(1, AT_ONCE // max(1, len(outline)))
    length, facet = np.full(len(points), np.inf), np.full(len(points), -1, np.int64)
    for first in range(0, len(points), step):
        at = slice(first, first + step)
        found = _crossings(points[at], normals[at], outline, BESIDE * size)
        if len(outline):
            facet[at] = np.argmin(found, axis=1)
            length[at] = found[np.arange(len(found)), facet[at]]
    facet[~np.isfinite(length)] = -1
    return length, facet


def _crossings(points: Floats, normals: Floats, outline: Floats, beside: float) -> Floats:
    """Distances at which lines leave through each facet, infinite where they do not, (n, b)."""
    a, edge = outline[:, 0], outline[:, 1] - outline[:, 0]
    across = np.column_stack((-normals[:, 1], normals[:, 0]))
    start = across @ a.T - np.sum(across * points, axis=1)[:, None]
    turn = across @ edge.T
    leaving = turn < 0.0  # against its walk, seen along -n: the line goes out
    share = np.divide(-start, turn, out=np.full(turn.shape, -1.0), where=leaving)
    reach = np.sum(normals * points, axis=1)[:, None] - normals @ a.T - share * (normals @ edge.T)
    hit = leaving & (share >= 0.0) & (share <= 1.0) & (reach > beside)
    return np.where(hit, reach, np.inf)
