"""Exact boundaries: curves with their facet groups."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import atan2, ceil, dist

import numpy as np

from contactfem.common.typing import Floats

Point = tuple[float, float]
CHORDS = 10  # of an outline between two knots
SAMPLE_TURN = np.deg2rad(10.0)  # between two knots of a curve, about


class Curve(ABC):
    """Piece of a boundary, walked with the body on its left.

    `groups` are the names its facets go by.
    """

    groups: tuple[str, ...]

    @abstractmethod
    def at(self, t: Floats) -> Floats:
        """Points (k, 2) [m] at parameters t (k,) from 0 at the start to 1 at the end."""

    def knots(self) -> Floats:
        """Ascending parameters from 0 to 1 between which the curve turns by some degrees only."""
        return np.array([0.0, 1.0])

    def corners(self) -> Floats:
        """Ascending parameters from 0 to 1 where every mesh has a node."""
        return np.array([0.0, 1.0])

    def nodes(self, t: Floats) -> Floats:
        """Nodes (k, 2) [m] of a mesh whose facets end at the parameters t (k,), from 0 to 1."""
        return self.at(t)


Loop = tuple[Curve, ...]
Boundary = tuple[Loop, ...]  # the outer loop counter-clockwise, then holes clockwise


@dataclass(frozen=True)
class Edge(Curve):
    """Line, or arc of less than half a turn about `centre`.

    A `fine` edge gets facets of equal length from `triangulate`.
    """

    start: Point
    end: Point
    groups: tuple[str, ...]
    centre: Point | None = None
    fine: bool = False

    def angle(self) -> float:
        """Angle of an arc from its start to its end, positive counter-clockwise."""
        if self.centre is None:
            return 0.0
        a, b = np.subtract(self.start, self.centre), np.subtract(self.end, self.centre)
        return atan2(a[0] * b[1] - a[1] * b[0], a @ b)

    def length(self) -> float:
        """Length along the edge [m]."""
        if self.centre is None:
            return dist(self.start, self.end)
        return dist(self.start, self.centre) * abs(self.angle())

    def at(self, t: Floats) -> Floats:
        """Points (k, 2) [m] at the parts t (k,) of the length."""
        start = np.array(self.start, dtype=np.float64)
        if self.centre is None:
            on_line: Floats = start + t[:, None] * (np.array(self.end) - start)
            return on_line
        centre, phi = np.array(self.centre), self.angle() * t
        x, y = start - centre
        turned = [x * np.cos(phi) - y * np.sin(phi), x * np.sin(phi) + y * np.cos(phi)]
        on_arc: Floats = centre + np.stack(turned, axis=1)
        return on_arc

    def knots(self) -> Floats:
        """Ends of equal parts, at least two of an arc."""
        parts = 1 if self.centre is None else max(2, ceil(abs(self.angle()) / SAMPLE_TURN))
        return equal_parts(parts)


@dataclass(frozen=True)
class FairCircle(Curve):
    """Whole circle whose polygons of nodes are as large as it is, so that pressure fits are right.

    `turn` is 1 counter-clockwise around a body, -1 clockwise around a hole. It starts on the x axis
    and has nodes on both axes.
    """

    centre: Point
    radius: float
    groups: tuple[str, ...]
    turn: int = 1

    def at(self, t: Floats) -> Floats:
        """Points (k, 2) [m] on the circle at the parts t (k,) of a turn."""
        return np.array(self.centre) + self.radius * self._direction(t)

    def knots(self) -> Floats:
        """Ends of equal parts."""
        return equal_parts(4 * ceil(np.pi / 2 / SAMPLE_TURN))

    def corners(self) -> Floats:
        """On the axes."""
        return equal_parts(4)

    def nodes(self, t: Floats) -> Floats:
        """Nodes (k, 2) [m] at R sqrt(mean of 2φ / sin 2φ over both facets there), 2φ their angle.

        Facets of equal length thus enclose the circle's area, as the builders' polygons do; nodes
        lie outside by O(h²), and facets with different neighbours are off by O(h²) times that
        difference. Nodes on the circle itself would make the body too small in the mean, by
        h² / 12 R in its radius, and interference along with it.
        """
        angle = 2.0 * np.pi * np.diff(t)
        share = angle / np.sin(angle)
        mean = 0.5 * (share + np.roll(share, 1))
        fair = np.sqrt(np.append(mean, mean[0]))
        nodes: Floats = np.array(self.centre) + self.radius * fair[:, None] * self._direction(t)
        return nodes

    def _direction(self, t: Floats) -> Floats:
        """Unit vectors (k, 2) at the parts t (k,) of a turn, on the axes to the last digit."""
        phi = 2.0 * np.pi * t * self.turn
        unit = np.stack([np.cos(phi), np.sin(phi)], axis=1)
        unit[np.abs(unit) < 1e-15] = 0.0
        return unit


@dataclass(frozen=True)
class Parametric(Curve):
    """Curve by a function from parameters (k,) to points (k, 2) [m]; `bends` are its knots."""

    place: Callable[[Floats], Floats]
    bends: Floats
    groups: tuple[str, ...]

    def at(self, t: Floats) -> Floats:
        """Points (k, 2) [m] of the function."""
        return self.place(t)

    def knots(self) -> Floats:
        """As given."""
        return self.bends


def equal_parts(number: int) -> Floats:
    """Parameters (number + 1,) that divide a curve evenly."""
    return np.linspace(0.0, 1.0, number + 1, dtype=np.float64)


def line(ends: Floats, groups: tuple[str, ...]) -> Edge:
    """Line between two points (2, 2) [m]."""
    (x0, y0), (x1, y1) = ends
    return Edge((float(x0), float(y0)), (float(x1), float(y1)), groups)


def mapped(edges: Sequence[Edge], factor: Point, shift: Point) -> list[Edge]:
    """Edges at factor * x + shift; a mirror image is walked backwards, its body on the left again.

    Args:
        edges: connected edges.
        factor: of x and y, each 1 or -1.
        shift: of x and y [m].

    Returns:
        The edges in the order of their walk.
    """

    def image(point: Point) -> Point:
        return factor[0] * point[0] + shift[0], factor[1] * point[1] + shift[1]

    moved = [
        replace(
            edge,
            start=image(edge.start),
            end=image(edge.end),
            centre=None if edge.centre is None else image(edge.centre),
        )
        for edge in edges
    ]
    if factor[0] * factor[1] > 0.0:
        return moved
    return [replace(edge, start=edge.end, end=edge.start) for edge in reversed(moved)]


def enclosed(x: Floats) -> float:
    """Area [m²] inside a closed polygon (k, 2), negative if it is clockwise."""
    dx, dy = (np.roll(x, -1, axis=0) - x).T
    return 0.5 * float(np.sum((x[:, 0] - x[0, 0]) * dy - (x[:, 1] - x[0, 1]) * dx))


def outlined(boundary: Boundary) -> dict[str, Floats]:
    """Polyline (k, 2) [m] of every group: curves by chords of about a degree, lines by their ends.

    Args:
        boundary: loops; the curves of each group follow each other in one of them.

    Returns:
        The polylines by group.
    """
    lines: dict[str, list[Floats]] = {}
    for curve in (curve for loop in boundary for curve in loop):
        knots = curve.knots()
        chords = CHORDS * (len(knots) - 1) if len(knots) > 2 else 1
        x = curve.at(
            np.interp(np.linspace(0, len(knots) - 1, chords + 1), range(len(knots)), knots)
        )
        for name in curve.groups:
            before = lines.setdefault(name, [])
            before.append(x[1:] if before else x)
    return {name: np.concatenate(parts) for name, parts in lines.items()}
