"""Recovery on contact boundaries: joint patches of both bodies (34), (35).

Every surface vertex has its standard patch; the extended patch is that of the closest vertex on the
other body. Each of the two surfaces is the standard one in turn, with its own outward normals n and
jumps [[a]] = a_standard - a_extended: (34) and (35) read the same from both sides. Heat q_s·n that
leaves the standard body and frictional heat d enter the other one, q_e·n = q_s·n + d, hence
[[q·n]] = -d.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from contactfem.adaptivity.recovery.constraints import (
    PENALTY,
    Expansion,
    constrained,
    expansion,
    heat_flow_rows,
    traction_rows,
)
from contactfem.adaptivity.recovery.patches import Patches
from contactfem.common.typing import Bools, Floats, Ints


@dataclass(frozen=True)
class Side:
    """Patches (s of them) of one contact surface and what they fitted, shape (s, b, c).

    Of bodies in the positions where the surfaces touch: the current ones, or, where nothing moves
    much, the reference ones.
    """

    patches: Patches
    coefficients: Floats


@dataclass(frozen=True)
class ThermalState:
    """What is known of the heat at the vertices of one surface.

    Attributes:
        normals: Unit normals, outward from the body of this surface [-], shape (s, 2).
        active: Where heat passes to the other body, shape (s,).
        dissipation: Frictional heat d, of both sides together [W/m²], shape (s,).
        outflow: q·n where no heat passes, 0 where insulated [W/m²], shape (s,).
    """

    normals: Floats
    active: Bools
    dissipation: Floats
    outflow: Floats


@dataclass(frozen=True)
class MechanicalState:
    """What is known of the tractions at the vertices of one surface.

    Attributes:
        normals: Unit normals, outward from the body of this surface [-], shape (s, 2).
        active: Where the bodies touch; elsewhere the surface is free of traction, shape (s,).
        frictionless: Where they touch without any tangential traction, shape (s,).
    """

    normals: Floats
    active: Bools
    frictionless: Bools


@dataclass(frozen=True)
class JointFit:
    """Polynomials of both patches at each vertex; `standard.values` are the recovered values."""

    standard: Expansion
    extended: Expansion


def closest(points: Floats, others: Floats) -> Ints:
    """The closest of some other points to each point.

    Args:
        points: Points [m], shape (k, 2).
        others: The other points [m], shape (n, 2), at least one.

    Returns:
        Indices into `others`, shape (k,).
    """
    from scipy.spatial import cKDTree

    found: Ints = cKDTree(others).query(points)[1].astype(np.int64)
    return found


def recover_heat_flux(
    standard: Side,
    extended: Side,
    state: ThermalState,
    chosen: Ints | None = None,
    penalty: float = PENALTY,
) -> JointFit:
    """Heat flux (x, y) at surface vertices with [[q·n]] = -d where heat passes, (35) and (36).

    Args:
        standard: The surface.
        extended: The surface opposite.
        state: What is known at the vertices of `standard`.
        chosen: Indices of these vertices, shape (k,); all without.
        penalty: Weight of a condition, relative to that of a sample.

    Returns:
        The fits at the chosen vertices.
    """
    rows = np.arange(len(state.active)) if chosen is None else chosen
    passes = state.active[rows]
    own = heat_flow_rows(state.normals[rows])
    target = np.where(passes, -state.dissipation[rows], state.outflow[rows])
    other = np.where(passes[:, None, None], -own, 0.0)
    return _joint(standard, extended, rows, (own, other), target[:, None], penalty)


def recover_stress(
    standard: Side,
    extended: Side,
    state: MechanicalState,
    chosen: Ints | None = None,
    penalty: float = PENALTY,
) -> JointFit:
    """Stress (xx, yy, zz, xy) at surface vertices with [[σn]] = 0 where they touch, (34) and (36).

    Args:
        standard: The surface.
        extended: The surface opposite.
        state: What is known at the vertices of `standard`.
        chosen: Indices of these vertices, shape (k,); all without.
        penalty: Weight of a condition, relative to that of a sample.

    Returns:
        The fits at the chosen vertices.
    """
    rows = np.arange(len(state.active)) if chosen is None else chosen
    own = traction_rows(state.normals[rows])
    passes = np.repeat(state.active[rows][:, None], 2, axis=1)
    passes[:, 1] &= ~state.frictionless[rows]
    other = np.where(passes[:, :, None], -own, 0.0)
    return _joint(standard, extended, rows, (own, other), np.zeros(passes.shape), penalty)


def _joint(
    standard: Side,
    extended: Side,
    rows: Ints,
    conditions: Sequence[Floats],
    targets: Floats,
    penalty: float,
) -> JointFit:
    """Fit pairs of patches under conditions at the vertex of the standard one.

    A sample counts as h⁻²: fits err by O(h²), in the same direction on both sides where heat or
    stress fades away from the interface, so that each has its share of a wrong jump. (The areas in
    (36) would move the finer side to what the coarser one says.)
    """
    x = standard.patches.centres[rows]
    partner = closest(x, extended.patches.centres)
    first = expansion(standard.patches, standard.coefficients, rows, x)
    second = expansion(extended.patches, extended.coefficients, partner, x)
    ratio = extended.patches.sizes[partner] / standard.patches.sizes[rows]
    second = replace(second, compliance=second.compliance * ratio[:, None, None] ** 2)
    return JointFit(*constrained((first, second), conditions, targets, penalty))
