"""Balance of forces and moments between the sides of an interface."""

import numpy as np

from contactfem.contact.state import ContactState


def defects(c: ContactState) -> tuple[float, float]:
    """Force and moment that the forces f on the nodes x of both sides leave over.

    |Σ f| / Σ |f| is round-off, as Σ_l M_jl = D_jj. |Σ (x - x̄) × f| / (R Σ |f|) is of the order h²
    where surfaces are curved, as either side's forces act where its own nodes are; R is the largest
    distance of a node in contact from the middle x̄ of them all.

    Args:
        c: The contact state; the same on all ranks.

    Returns:
        Both, relative [-]; zero without contact.
    """
    force, touching = c.nodal_forces(), np.flatnonzero(c.active)
    whole = float(np.linalg.norm(force, axis=1).sum())
    if whole == 0.0:
        return 0.0, 0.0
    arm = c.operators.x - c.operators.x[touching].mean(0)
    R = max(np.linalg.norm(arm[touching], axis=1).max(), c.operators.size[touching].max())
    product = arm.T @ force  # its skew part is the moment, in any dimension
    moment = np.linalg.norm(product - product.T) / np.sqrt(2.0)
    return float(np.linalg.norm(force.sum(0)) / whole), float(moment / (R * whole))
