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
