"""Reported multipliers of barely covered nodes."""

from contactfem.common.typing import Floats
from contactfem.contact.state import ContactState

BARELY = 1e-3  # cover below which the multiplier has lost its digits


def edge_values(c: ContactState) -> tuple[Floats, Floats]:
    """Pressure and traction, with the rim rule where a node is barely covered.

    There p_j = p_k - g_j/κ_j and t_j = t_k.
    λ_j = -R_j / D_jj loses all digits as D_jj ~ cover² vanishes; the rule, exact at
    convergence, does not. Its terms of slip vanish with 1/κ_j.

    Args:
        c: Conditions at convergence.

    Returns:
        Pressure and traction [Pa], (n,) each.
    """
    pressure, traction = c.pressure.copy(), c.traction.copy()
    poor = c.active & (c.kappa > 0.0) & (c.operators.coverage < BARELY)
    neighbour = c.rim[poor]
    pressure[poor] = pressure[neighbour] - c.operators.gap[poor] / c.kappa[poor]
    traction[poor] = traction[neighbour]
    return pressure, traction
