"""Edge stabilisation: ties barely covered nodes to their neighbours."""

import numpy as np

from contactfem.common.typing import Floats

EDGE_COVERAGE = 0.5  # covered share of a node's facets below which it is an edge node
EDGE_COMPLIANCE = 0.1


def edge_compliance(coverage: Floats, c: Floats) -> tuple[Floats, Floats]:
    """Compliance that ties an edge node to its neighbour, κ = (0.1/c) (1/(2f) - 1) for f < 1/2.

    Without it the pressure of a node is unbounded as its coverage f vanishes.

    Args:
        coverage: Covered share f of the node's facets [-], (n,).
        c: Scale of `contact_scale` [Pa/m], (n,).

    Returns:
        κ [m/Pa] and dκ/df [m/Pa], (n,) each; zero where f >= 1/2 or nothing is covered.
    """
    edge = (coverage > 0.0) & (coverage < EDGE_COVERAGE)
    f = np.where(edge, coverage, EDGE_COVERAGE)
    a = EDGE_COMPLIANCE / c
    return a * (0.5 / f - 1.0), np.where(edge, -0.5 * a / f**2, 0.0)
