"""Contact laws at a node as trial states: gap and pressure, and Coulomb friction.

They know nothing of segments or meshes; every argument is an array over nodes.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

RIM = 0.5  # covered share of a node's facets below which the rim rule acts
RIM_COMPLIANCE = 0.1


class Status(IntEnum):
    """Contact status of a nonmortar node."""

    NONE = -1  # carries no multiplier
    OPEN = 0
    STICK = 1
    SLIP = 2


class Trial(NamedTuple):
    """Status of every node and the direction of its slip (-1, 0, 1)."""

    status: NDArray[np.int8]
    direction: Floats


def contact_scale(
    h_nonmortar: Floats, E_nonmortar: float, h_mortar: float, E_mortar: float
) -> Floats:
    """Scale between gap and pressure, c = 1 / (h_nm/E_nm + h_m/E_m), of the order of the stiffness.

    Args:
        h_nonmortar: Facet size at the nonmortar nodes [m].
        E_nonmortar: Young's modulus [Pa].
        h_mortar: Facet size of the mortar side [m].
        E_mortar: Young's modulus [Pa], infinite for a rigid obstacle.

    Returns:
        c [Pa/m], same shape as h_nonmortar.
    """
    return np.asarray(1.0 / (h_nonmortar / E_nonmortar + h_mortar / E_mortar))


def rim_compliance(cover: Floats, c: Floats) -> tuple[Floats, Floats]:
    """Compliance that ties a barely covered node to its neighbour, κ = (0.1/c) (1/(2f) - 1).

    For f < 1/2. Without it the pressure of a node is unbounded as its cover f vanishes.

    Args:
        cover: Covered share f of the node's facets [-].
        c: Scale of `contact_scale` [Pa/m].

    Returns:
        κ [m/Pa] and dκ/df [m/Pa]; zero where f >= 1/2 or nothing is covered.
    """
    rim = (cover > 0.0) & (cover < RIM)
    f = np.where(rim, cover, RIM)
    a = RIM_COMPLIANCE / c
    return a * (0.5 / f - 1.0), np.where(rim, -0.5 * a / f**2, 0.0)


def trial_pressure(p: Floats, p_rim: Floats, gap: Floats, c: Floats, kappa: Floats) -> Floats:
    """Trial pressure p* = (p + cκ p_k - c g) / (1 + cκ); without rim p* = p - c g.

    Its sign tells whether a node is in contact; as the cover vanishes it becomes the pressure that
    the neighbour k imposes, so round-off in p does not decide.

    Args:
        p: Pressure [Pa].
        p_rim: Pressure p_k of the neighbour that the rim rule ties to [Pa].
        gap: Mean gap g_j / D_jj [m].
        c: Scale [Pa/m].
        kappa: Rim compliance [m/Pa].

    Returns:
        p* [Pa].
    """
    return (p + c * kappa * p_rim - c * gap) / (1.0 + c * kappa)


def coulomb(
    p_trial: Floats, t: Floats, t_rim: Floats, slip: Floats, c: Floats, kappa: Floats, mu: float
) -> Trial:
    """Trial of unilateral contact with Coulomb friction: open, slip if |t*| > μ p*, else stick.

    t* = (t + cκ t_k + c s) / (1 + cκ).

    Args:
        p_trial: p* [Pa].
        t: Traction [Pa].
        t_rim: Traction t_k of the neighbour that the rim rule ties to [Pa].
        slip: Slip increment s of the step [m].
        c: Scale [Pa/m].
        kappa: Rim compliance [m/Pa].
        mu: Friction coefficient; 0 makes every node in contact slip without direction.

    Returns:
        Status and slip direction.
    """
    t_trial = (t + c * kappa * t_rim + c * slip) / (1.0 + c * kappa)
    slides = np.abs(t_trial) > mu * p_trial if mu > 0.0 else np.ones(len(t), bool)
    status = np.where(p_trial <= 0.0, Status.OPEN, np.where(slides, Status.SLIP, Status.STICK))
    direction = np.sign(t_trial) if mu > 0.0 else np.zeros(len(t))
    return Trial(status.astype(np.int8), np.where(status == Status.SLIP, direction, 0.0))
