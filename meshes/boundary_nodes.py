"""Where the nodes of an adapted mesh lie on its boundary."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.errors import MeshError
from contactfem.meshes.curves import Boundary, Curve
from contactfem.meshes.size_field import SizeField, nearest_edge

TURN = np.deg2rad(20.0)  # of the curve along a facet, about, at most: facets follow it at any size
STEP = 0.5  # distance of samples over the size there
MAX_SAMPLES = 1_000_000  # of a curve
NEAR = 0.1  # of the size: a kept point this close to the boundary is moved onto it
SAME = 1e-7  # of the body's size: nodes this close are one
_NONE: Mapping[str, SizeField] = MappingProxyType({})


@dataclass(frozen=True)
class Division:
    """Boundary nodes (n, 2) [m], the loops they form, and their facets (k, 2) by group.

    `inner` (m, 2) [m] are the kept points inside.
    """

    nodes: Floats
    loops: tuple[Ints, ...]
    groups: dict[str, Ints]
    inner: Floats


@dataclass(frozen=True)
class _Sampled:
    """A curve, points x (k, 2) [m] of it at parameters t (k,), and the facets from its start."""

    curve: Curve
    t: Floats
    x: Floats
    reached: Floats


def divided(
    boundary: Boundary, field: SizeField, keep: Floats, lengths: Mapping[str, SizeField] = _NONE
) -> Division:
    """Divide every curve from corner to corner into facets of the field's sizes.

    Args:
        boundary: closed loops of curves.
        field: wanted sizes.
        keep: points (k, 2) [m] that become nodes.
        lengths: wanted lengths of the facets of some groups, where they differ.

    Returns:
        The nodes, where the curves place them.

    Raises:
        MeshError: curves do not join, the sizes are too small, or a kept point is not in the body.
    """
    loops = [[_sampled(curve, _on(curve, field, lengths)) for curve in loop] for loop in boundary]
    size = float(np.ptp(field.points, axis=0).max())
    for loop in loops:
        _check_closed(loop, SAME * size)
    pins, inner = _pinned([each for loop in loops for each in loop], field, keep, SAME * size)
    nodes: list[Floats] = []
    numbers: list[Ints] = []
    groups: dict[str, list[Ints]] = {}
    for loop in loops:
        parts = [each.curve.nodes(_nodes(each, pins.pop(0), SAME * size))[:-1] for each in loop]
        first = sum(map(len, numbers))
        number = np.arange(first, first + sum(map(len, parts)), dtype=np.int64)
        facets = np.stack([number, np.roll(number, -1)], axis=1)
        ends = np.cumsum([len(part) for part in parts])[:-1]
        for each, own in zip(loop, np.split(facets, ends), strict=True):
            for name in each.curve.groups:
                groups.setdefault(name, []).append(own)
        nodes += parts
        numbers.append(number)
    joined = {name: np.concatenate(parts) for name, parts in groups.items()}
    return Division(np.concatenate(nodes), tuple(numbers), joined, inner)


def _on(curve: Curve, field: SizeField, lengths: Mapping[str, SizeField]) -> SizeField:
    """What the lengths of a curve's facets follow."""
    return next((lengths[name] for name in curve.groups if name in lengths), field)


def _sampled(curve: Curve, field: SizeField) -> _Sampled:
    """Samples so close that sizes and directions are straight lines in between."""
    t = curve.knots()
    x = curve.at(t)
    h = field.at(x)
    while True:
        length = np.hypot(*np.diff(x, axis=0).T)
        coarse = np.flatnonzero(length > STEP * np.minimum(h[:-1], h[1:]))
        if not len(coarse):
            break
        if len(t) + len(coarse) > MAX_SAMPLES:
            raise MeshError(f"the sizes ask for more than {STEP * MAX_SAMPLES:.0f} facets")
        middle = 0.5 * (t[coarse] + t[coarse + 1])
        new = curve.at(middle)
        t, x = np.insert(t, coarse + 1, middle), np.insert(x, coarse + 1, new, axis=0)
        h = np.insert(h, coarse + 1, field.at(new))
    facets = np.maximum(length * 0.5 * (1.0 / h[:-1] + 1.0 / h[1:]), _turns(x) / TURN)
    return _Sampled(curve, t, x, np.concatenate([[0.0], np.cumsum(facets)]))


def _turns(x: Floats) -> Floats:
    """Angles (k - 1,) by which a polyline (k, 2) turns along its pieces: half at either end."""
    (ax, ay), (bx, by) = np.diff(x, axis=0)[:-1].T, np.diff(x, axis=0)[1:].T
    turn = np.abs(np.arctan2(ax * by - ay * bx, ax * bx + ay * by))
    ends = np.concatenate([turn[:1], turn, turn[-1:]]) if len(turn) else np.zeros(2)
    angles: Floats = 0.5 * (ends[:-1] + ends[1:])
    return angles


def _nodes(sampled: _Sampled, pins: list[float], same: float) -> Floats:
    """Parameters of the nodes: equal shares of the facets between corners and kept points."""
    stops = sampled.curve.corners()
    for pin in pins:
        apart = np.hypot(*(sampled.curve.at(stops) - sampled.curve.at(np.array([pin]))).T)
        if apart.min() > same:
            stops = np.insert(stops, np.searchsorted(stops, pin), pin)
    parts = [stops[:1]]
    for (start, end), stop in zip(
        pairwise(np.interp(stops, sampled.t, sampled.reached)), stops[1:], strict=True
    ):
        facets = max(1, round(end - start))
        inner = np.linspace(start, end, facets + 1)[1:-1]
        parts += [np.interp(inner, sampled.reached, sampled.t), np.array([stop])]
    return np.concatenate(parts)


def _pinned(
    curves: list[_Sampled], field: SizeField, keep: Floats, same: float
) -> tuple[list[list[float]], Floats]:
    """Parameters of kept points on each curve, and the points inside (k, 2)."""
    pins: list[list[float]] = [[] for _ in curves]
    inner = []
    for k, size in enumerate(field.at(keep)):
        point: Floats = keep[k]
        close = [_closest(each, point) for each in curves]
        nearest = int(np.argmin([distance for _, distance in close]))
        t, distance = close[nearest]
        if distance < max(NEAR * size, same):
            pins[nearest].append(t)
        elif _winding(curves, point) > 0.5:
            inner.append(point)
        else:
            raise MeshError(f"the point ({point[0]:g}, {point[1]:g}) m to keep is not in the body")
    return pins, np.array(inner).reshape(-1, 2)


def _closest(sampled: _Sampled, point: Floats) -> tuple[float, float]:
    """Parameter of a curve where it comes closest to a point, and the distance [m] there."""
    edges, _ = nearest_edge(point[None], sampled.x[:-1], sampled.x[1:])
    edge = int(edges[0])
    low, high = sampled.t[edge], sampled.t[edge + 1]
    for _ in range(15):  # each time a fifth of the interval
        t = np.linspace(low, high, 11)
        distance = np.hypot(*(sampled.curve.at(t) - point).T)
        k = int(np.argmin(distance))
        low, high = t[max(k - 1, 0)], t[min(k + 1, 10)]
    return float(t[k]), float(distance[k])


def _winding(curves: list[_Sampled], point: Floats) -> float:
    """How often the curves go around a point that is not on them."""
    turns = 0.0
    for each in curves:
        (ax, ay), (bx, by) = (each.x[:-1] - point).T, (each.x[1:] - point).T
        turns += float(np.sum(np.arctan2(ax * by - ay * bx, ax * bx + ay * by)))
    return turns / (2.0 * np.pi)


def _check_closed(loop: list[_Sampled], same: float) -> None:
    """Raise the error for curves that do not form a closed loop."""
    for each, after in zip(loop, loop[1:] + loop[:1], strict=True):
        (x, y), gap = each.x[-1], float(np.hypot(*(each.x[-1] - after.x[0])))
        if gap > same:
            raise MeshError(f"the boundary has a gap of {gap:g} m at ({x:g}, {y:g}) m")
