"""Complementarity of contact and friction (4)-(6), also regularised (13).

They know nothing of segments or meshes; every argument is an array over nodes.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from contactfem.common.typing import Floats
from contactfem.laws.active_set import ActiveSet, Status


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


class Regularisation(NamedTuple):
    """Compliance that ties a multiplier to a value: 1/ε to an estimate, κ to a neighbour's."""

    compliance: Floats
    value: Floats


def trial(multiplier: Floats, motion: Floats, c: Floats, ties: Sequence[Regularisation]) -> Floats:
    """Trial multiplier λ* = (λ + Σ c a v + c m) / (1 + Σ c a); p* = p - c g without ties.

    The condition of a multiplier is m = Σ a (λ - v), m = -g for pressure and s for traction.
    λ* tells its status whatever the size of a: with a vanishing cover (κ without bound) it becomes
    the neighbour's value, so round-off in λ does not decide, and a penalty (a = 1/ε_N) needs no
    other iteration than exact contact (a = 0).

    Args:
        multiplier: λ, pressure or traction [Pa].
        motion: m, -g_j / D_jj or slip [m].
        c: Scale [Pa/m].
        ties: Compliances a [m/Pa] and values v [Pa].

    Returns:
        λ* [Pa].
    """
    weight, value = np.ones_like(c), multiplier + c * motion
    for tie in ties:
        weight = weight + c * tie.compliance
        value = value + c * tie.compliance * tie.value
    return np.asarray(value / weight)


def stick_or_slip(p_trial: Floats, t_trial: Floats, limit: Floats, has_friction: bool) -> ActiveSet:
    """Status of unilateral contact with friction: open, slip if |t*| > b, else stick.

    Args:
        p_trial: p* [Pa].
        t_trial: t* [Pa].
        limit: Largest traction b at p* [Pa].
        has_friction: Whether there is friction; without it every node in contact slips, without
            direction.

    Returns:
        Status and slip direction.
    """
    slides = np.abs(t_trial) > limit if has_friction else np.ones(len(t_trial), bool)
    status = np.where(p_trial <= 0.0, Status.OPEN, np.where(slides, Status.SLIP, Status.STICK))
    direction = np.sign(t_trial) if has_friction else np.zeros(len(t_trial))
    return ActiveSet(status.astype(np.int8), np.where(status == Status.SLIP, direction, 0.0))
