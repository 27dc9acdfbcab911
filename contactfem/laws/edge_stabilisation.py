"""Edge stabilisation: ties barely covered nodes to their neighbours."""

import numpy as np

from contactfem.common.typing import Floats

EDGE_COVERAGE = 0.5  # covered share of a node's facets below which the rim rule acts


EDGE_COMPLIANCE = 0.1


def edge_compliance(cover: Floats, c: Floats) -> tuple[Floats, Floats]:
    """Compliance that ties a barely covered node to its neighbour, κ = (0.1/c) (1/(2f) - 1).

    For f < 1/2. Without it the pressure of a node is unbounded as its cover f vanishes.

    Args:
        cover: Covered share f of the node's facets [-].
        c: Scale of `contact_scale` [Pa/m].

    Returns:
        κ [m/Pa] and dκ/df [m/Pa]; zero where f >= 1/2 or nothing is covered.
    """
    rim = (cover > 0.0) & (cover < EDGE_COVERAGE)
    f = np.where(rim, cover, EDGE_COVERAGE)
    a = EDGE_COMPLIANCE / c
    return a * (0.5 / f - 1.0), np.where(rim, -0.5 * a / f**2, 0.0)
