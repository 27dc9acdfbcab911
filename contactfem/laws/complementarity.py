"""Contact conditions at a node: complementarity, stick and slip (4)-(6), penalty (13).

Arrays over nodes, pressures and gaps (n,), tractions and slips as vectors (n, dim) in the tangent
plane. They know nothing of segments or meshes, and any dimension is as good as another.
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
    """Compliance a [m/Pa], (n,), that ties a multiplier to a target v [Pa], (n,) or (n, dim).

    With a = 1/ε and an estimate as target it is a penalty or an augmented Lagrangian, with κ and a
    neighbour's value the edge stabilisation.
    """

    compliance: Floats
    target: Floats


def trial_multiplier(
    multiplier: Floats, motion: Floats, c: Floats, regularisations: Sequence[Regularisation]
) -> Floats:
    """Trial multiplier λ* = (λ + Σ c a v + c m) / (1 + Σ c a); p* = p - c g without compliances.

    The condition of a multiplier is m = Σ a (λ - v), m = -g for pressure and s for traction.
    λ* tells its status whatever the size of a: with a vanishing coverage (κ without bound) it
    becomes the neighbour's value, so round-off in λ does not decide, and a penalty (a = 1/ε_N)
    needs no other iteration than exact contact (a = 0).

    Args:
        multiplier: λ, pressure (n,) or traction (n, dim) [Pa].
        motion: m, -g_j or slip [m], likewise.
        c: Scale [Pa/m], (n,).
        regularisations: Compliances a and targets v.

    Returns:
        λ* [Pa], as the multiplier.
    """
    weight, factor = np.ones_like(c), _over(c, multiplier)
    value = multiplier + factor * motion
    for compliance, target in regularisations:
        weight = weight + c * compliance
        value = value + _over(c * compliance, multiplier) * target
    return np.asarray(value / _over(weight, multiplier))


def active_set(p_trial: Floats, t_trial: Floats, bound: Floats, has_friction: bool) -> ActiveSet:
    """Active set of unilateral contact (5) with friction (6): open, slip if |t*| > b, else stick.

    Open where p* <= 0, which is p >= 0, g >= 0 and p g = 0 at once.

    Args:
        p_trial: p* [Pa], (n,).
        t_trial: t* [Pa], (n, dim).
        bound: Largest traction b at p* [Pa], (n,).
        has_friction: Without it every node in contact slips without direction.

    Returns:
        Status, and the slip direction t*/|t*|.
    """
    size = lengths(t_trial)
    slides = size > bound if has_friction else np.ones(len(size), bool)
    status = np.where(p_trial <= 0.0, Status.OPEN, np.where(slides, Status.SLIP, Status.STICK))
    at = (status == Status.SLIP) & has_friction
    return ActiveSet(status.astype(np.int8), unit(np.where(at[:, None], t_trial, 0.0)))


def normal_condition(gap: Floats, p: Floats, regularisations: Sequence[Regularisation]) -> Floats:
    """Residual of the normal condition of a node in contact (5), g + Σ a (p - v) [m].

    With a = 1/ε_N and v = 0 it is the penalty p = -ε_N g (13).

    Args:
        gap: g [m], (n,).
        p: Pressure [Pa], (n,).
        regularisations: Compliances a and targets v.
    """
    result = gap
    for compliance, target in regularisations:
        result = result + compliance * (p - target)
    return result


def stick_condition(slip: Floats, t: Floats, regularisations: Sequence[Regularisation]) -> Floats:
    """Residual of the tangential condition of a sticking node (6), s - Σ a (t - v) [m].

    Args:
        slip: s [m], (n, dim).
        t: Traction [Pa], (n, dim).
        regularisations: Compliances a and targets v.
    """
    result = slip
    for compliance, target in regularisations:
        result = result - compliance[:, None] * (t - target)
    return result


def slip_condition(t: Floats, direction: Floats, bound: Floats) -> Floats:
    """Residual of the tangential condition of a slipping node (6), t - b d [Pa].

    Args:
        t: Traction [Pa], (n, dim).
        direction: Slip direction d, unit vectors or zero, (n, dim).
        bound: Largest traction b [Pa], (n,).
    """
    return np.asarray(t - bound[:, None] * direction)


def lengths(vectors: Floats) -> Floats:
    """Length of every vector, (n, dim) to (n,)."""
    return np.asarray(np.sqrt(np.einsum("ji,ji->j", vectors, vectors)), np.float64)


def unit(vectors: Floats) -> Floats:
    """Vectors over their lengths; zero where they are, (n, dim)."""
    size = lengths(vectors)
    return np.asarray(vectors / np.where(size > 0.0, size, 1.0)[:, None])


def _over(factor: Floats, values: Floats) -> Floats:
    """A factor for every node, shaped to multiply values (n,) or (n, dim)."""
    return factor if values.ndim == 1 else factor[:, None]
