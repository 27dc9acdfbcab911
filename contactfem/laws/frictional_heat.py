"""Heat flux through an interface and its frictional part (16) (17)."""

from typing import NamedTuple

from contactfem.common.typing import Floats
from contactfem.laws.conductance import Conductance


class Flux(NamedTuple):
    """Heat q conducted from nonmortar to mortar [W/m²], dq/d[θ], dq/dp and dq/dg, each (n,)."""

    q: Floats
    by_jump: Floats
    by_pressure: Floats
    by_gap: Floats


def conducted(at: Conductance, jump: Floats) -> Flux:
    """Heat conducted through the interface, q = h (θ_nm - θ_m) (15).

    Args:
        at: conductance at the points.
        jump: θ_nm - θ_m (n,) [K].

    Returns:
        The flux, > 0 from nonmortar to mortar, and its derivatives.
    """
    return Flux(at.h * jump, at.h, at.dh_dp * jump, at.dh_dgap * jump)


class Outflow(NamedTuple):
    """Heat that leaves each body through the interface, each (n,) [W/m²]."""

    nonmortar: Floats
    mortar: Floats


def outflow(q: Floats, dissipation: Floats, partition: float = 0.5) -> Outflow:
    """Heat out of both bodies, q_nm = q - f d and q_m = -q - (1 - f) d (16); they add up to -d.

    Args:
        q: heat conducted from nonmortar to mortar (n,) [W/m²].
        dissipation: frictional power d = t·(slip rate) >= 0 (n,), (17) [W/m²].
        partition: f, share of the frictional heat that enters nonmortar [-].

    Returns:
        What leaves nonmortar and mortar.
    """
    return Outflow(q - partition * dissipation, -q - (1.0 - partition) * dissipation)
