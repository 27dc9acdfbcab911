"""Contact zones and errors against closed forms along an interface.

Positions along an interface are counted in nodes: 2.5 is the middle of the facet from node 2 to 3.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.results.data import InterfaceTable, Status
from contactfem.verification.contact import ContactSolution, Profile

_GAUSS_POINTS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(12)


def carriers(table: InterfaceTable) -> Ints:
    """Node whose multiplier acts at each node: itself, or the nearest that carries one.

    Args:
        table: the interface.

    Returns:
        Indices (n,).
    """
    indices = np.arange(len(table.arc))
    carrying = np.flatnonzero(table.status != Status.NONE)
    if not carrying.size:
        return indices
    right = np.clip(np.searchsorted(carrying, indices), 0, carrying.size - 1)
    left = np.maximum(right - 1, 0)
    nearer = indices - carrying[left] < np.abs(carrying[right] - indices)
    return np.where(nearer, carrying[left], carrying[right])


def zone(table: InterfaceTable, members: Iterable[Status]) -> tuple[float, float] | None:
    """Find from where to where nodes have one of some states.

    An edge lies half a facet beyond the last member, or at the end of the surface.

    Args:
        table: the interface.
        members: the states.

    Returns:
        First and last position [nodes]; None without members.
    """
    status = table.status[carriers(table)]
    found = np.flatnonzero(np.isin(status, list(members)))
    if not found.size:
        return None
    return max(found[0] - 0.5, 0.0), min(found[-1] + 0.5, len(status) - 1.0)


def linearised(table: InterfaceTable) -> InterfaceTable:
    """Interface with its tractions as the closed forms of the linear theory mean them.

    The multiplier λ is force per current length, resolved along the current normal and tangent. The
    closed forms know neither the stretch nor the slope of the surface: they speak of force per
    undeformed length along their axis x, resolved across and along that axis.

    Args:
        table: the interface, a chain of nodes that walks along x.

    Returns:
        The same interface with these pressures and tractions; unchanged where it walks back, as
        round surfaces do, whose closed forms speak of normal and tangent.
    """
    if not walks_along_x(table):
        return table
    forward = math.copysign(1.0, table.X[-1, 0] - table.X[0, 0])
    n, edge = _normals(table.x), np.abs(np.diff(table.X[:, 0]))
    around = np.zeros(len(table.X))
    around[:-1] += 0.5 * edge
    around[1:] += 0.5 * edge
    stretch = np.divide(table.facet_length, around, out=np.ones_like(around), where=around > 0.0)
    force_x = table.pressure * n[:, 0] + table.traction * n[:, 1]
    force_y = table.pressure * n[:, 1] - table.traction * n[:, 0]
    return replace(
        table, pressure=-forward * stretch * force_y, traction=-forward * stretch * force_x
    )


def walks_along_x(table: InterfaceTable) -> bool:
    """Whether the nodes of an interface follow one another in the direction of x, or against it."""
    steps = np.diff(table.X[:, 0])
    return bool((steps > 0.0).all() or (steps < 0.0).all())


def _normals(x: Floats) -> Floats:
    """Mean normal (n, 2) of the facets at each node of a chain, (dy, -dx) along the walk."""
    edges = np.diff(x, axis=0)
    facets = np.stack([edges[:, 1], -edges[:, 0]], axis=1)
    facets /= np.linalg.norm(facets, axis=1, keepdims=True)
    nodal = np.zeros_like(x)
    nodal[:-1] += facets
    nodal[1:] += facets
    unit: Floats = nodal / np.linalg.norm(nodal, axis=1, keepdims=True)
    return unit


def value_at(values: Floats, position: float) -> float:
    """Interpolate nodal values linearly.

    Args:
        values: nodal values (n,).
        position: where [nodes].

    Returns:
        The value there.
    """
    return float(np.interp(position, np.arange(len(values)), values))


def position_of(coordinate: Floats, x: float) -> float:
    """Find where the surface first passes a coordinate.

    Args:
        coordinate: nodal coordinate (n,) [m].
        x: the coordinate sought [m].

    Returns:
        The position, or that of the nearest node if the surface does not pass x [nodes].
    """
    crossings = _crossings(coordinate, [x])
    return float(crossings[0] if crossings.size else np.argmin(np.abs(coordinate - x)))


def _crossings(coordinate: Floats, levels: Iterable[float]) -> Floats:
    """Return the positions where the surface passes one of the levels."""
    found: list[Floats] = [np.empty(0)]
    for level in levels:
        offset = coordinate - level
        facet = np.flatnonzero(offset[:-1] * offset[1:] <= 0.0)
        facet = facet[coordinate[facet] != coordinate[facet + 1]]
        found.append(facet + offset[facet] / (coordinate[facet] - coordinate[facet + 1]))
    return np.sort(np.concatenate(found))


def _edges(solution: ContactSolution, low: float, high: float) -> list[float]:
    """Return the coordinates between two bounds where the solution has a kink."""
    halves = [h for h in (solution.half_width, solution.stick_half_width) if 0.0 < h < math.inf]
    shifts = [0.0]
    if math.isfinite(solution.period):
        first = math.floor((low - solution.center) / solution.period)
        last = math.ceil((high - solution.center) / solution.period)
        shifts = [k * solution.period for k in range(first, last + 1)]
    return [solution.center + k + sign * h for k in shifts for h in halves for sign in (-1, 1)]


def error_l2(
    X: Floats,
    values: Floats,
    profile: Profile,
    solution: ContactSolution,
    within: float = math.inf,
) -> float:
    """Relative L2 distance of the linear interpolant of nodal values from a closed form.

    ||v_h - v|| / ||v||, integrated over the reference surface, with facets split at the
    edges of the contact and stick zones.

    Args:
        X: reference positions of the nodes (n, 2) [m].
        values: nodal values (n,) [Pa].
        profile: the closed form v(x), x being the first coordinate.
        solution: whose zones are meant.
        within: only where |x - center| is smaller than this [m].

    Returns:
        The relative distance [-]; NaN where the closed form vanishes.
    """
    x, nodes = X[:, 0], np.arange(len(X), dtype=np.float64)
    limits = [solution.center + within, solution.center - within]
    kinks = _edges(solution, x.min(), x.max()) + [b for b in limits if math.isfinite(b)]
    cuts = np.unique(np.concatenate([nodes, _crossings(x, kinks)]))
    half = 0.5 * np.diff(cuts)
    s = (cuts[:-1] + half)[:, None] + half[:, None] * _GAUSS_POINTS
    facet = np.minimum((cuts[:-1] + half).astype(np.int64), len(X) - 2)
    lengths = np.linalg.norm(np.diff(X, axis=0), axis=1)[facet]
    at = np.interp(s, nodes, x)
    weights = (half * lengths)[:, None] * _GAUSS_WEIGHTS * (np.abs(at - solution.center) < within)
    exact = profile(at)
    square = float(np.sum(weights * exact**2))
    if square == 0.0:
        return math.nan
    return math.sqrt(float(np.sum(weights * (np.interp(s, nodes, values) - exact) ** 2)) / square)
