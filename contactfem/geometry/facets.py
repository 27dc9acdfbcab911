"""Lengths and normals of facets."""

import numpy as np

from contactfem.common.typing import Floats, Ints


def line_lengths(X: Floats, facets: Ints) -> Floats:
    """Lengths of facets [m], (k,).

    Args:
        X: Positions [m], (n, 2).
        facets: Their nodes, (k, 2).
    """
    edge = X[facets[:, 1]] - X[facets[:, 0]]
    return np.asarray(np.hypot(edge[:, 0], edge[:, 1]))


def facet_sizes(X: Floats, facets: Ints) -> Floats:
    """Lengths of lines, or square roots of the areas of facets in space [m], (k,).

    Args:
        X: Positions [m], (n, dim).
        facets: Their nodes, (k, 2), (k, 3), or (k, 4) in tensor order.
    """
    if facets.shape[1] == 2:
        return line_lengths(X, facets)
    a, b, c, d = X[around(facets)].swapaxes(0, 1)
    return np.asarray(np.sqrt(0.5 * np.linalg.norm(np.cross(c - a, d - b), axis=1)))


def around(facets: Ints) -> Ints:
    """Nodes of facets in space in the order of a walk around them, a triangle's last one twice.

    Args:
        facets: Their nodes, (k, 3), or (k, 4) in tensor order.

    Returns:
        (k, 4).
    """
    return np.ascontiguousarray(facets[:, [0, 1, 2, 2] if facets.shape[1] == 3 else [0, 1, 3, 2]])
