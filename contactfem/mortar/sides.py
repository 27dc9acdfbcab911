"""Sides of an interface: a body's surface, or a rigid obstacle."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contactfem.common.time_table import Table
from contactfem.common.typing import Floats, Ints
from contactfem.meshes.data import Surface
from contactfem.mortar.directions import OfCircle, OfPlane
from contactfem.mortar.interface_mesh import Directions


@dataclass(frozen=True)
class BodySide:
    """A side that is a surface of a body."""

    body: int
    surface: Surface


@dataclass(frozen=True)
class RigidSide:
    """A side that is a rigid obstacle: facets that move as a whole.

    Attributes:
        X: Nodes at time 0 [m], (n, dim).
        facets: Facets as those of a `Surface`, seen from outside of the obstacle, (k, 2 to 4).
        displacement: Components over time [m].
        directions: Of contact with it; None for the nonmortar side's normals.
    """

    X: Floats
    facets: Ints
    displacement: tuple[Table, ...]
    directions: Directions | None


def plane_side(
    point: Sequence[float],
    normal: Sequence[float],
    extent: float,
    displacement: tuple[Table, ...],
) -> RigidSide:
    """A rigid plane as one long facet.

    Args:
        point: A point on it [m].
        normal: Outward from the obstacle [-], not necessarily of unit length.
        extent: Half its length [m].
        displacement: x and y over time [m].

    Returns:
        The side.
    """
    n = np.asarray(normal, float)
    n = n / np.hypot(*n)
    along = extent * np.array((-n[1], n[0]))  # outward normal (dy, -dx) of b - a
    X = np.asarray(point) + np.array((-along, along))
    return RigidSide(X, np.array(((0, 1),)), displacement, OfPlane(tuple(n.tolist())))


def polyline_side(points: Floats, closed: bool, displacement: tuple[Table, ...]) -> RigidSide:
    """A rigid chain of facets.

    Args:
        points: Its points with the solid on the left [m], (n, 2).
        closed: Whether the last point is joined to the first.
        displacement: x and y over time [m].

    Returns:
        The side.
    """
    ends = np.arange(len(points) - (0 if closed else 1))
    facets = np.column_stack((ends, (ends + 1) % len(points)))
    if len(facets) > 1:
        return RigidSide(points, facets, displacement, None)
    along = points[1] - points[0]
    n = np.array((along[1], -along[0])) / np.hypot(*along)
    return RigidSide(points, facets, displacement, OfPlane(tuple(n.tolist())))


def circle_side(
    centre: Sequence[float],
    radius: float,
    inside: bool,
    facets: int,
    displacement: tuple[Table, ...],
) -> RigidSide:
    """A rigid circle as a closed polygon of equal area error on both sides of the arc.

    Args:
        centre: Its centre [m].
        radius: Its radius [m].
        inside: Whether bodies touch it from inside (the obstacle lies around the circle).
        facets: Number of facets.
        displacement: x and y over time [m].

    Returns:
        The side.
    """
    turn = 2 * np.pi * np.arange(facets) / facets * (-1 if inside else 1)
    # Corners outside and midpoints inside the circle, so that chords cross it
    r = radius * (1 + (1 - np.cos(np.pi / facets)) / 3)
    X = np.asarray(centre) + r * np.column_stack((np.cos(turn), np.sin(turn)))
    ends = np.arange(facets)
    pairs = np.column_stack((ends, (ends + 1) % facets))
    return RigidSide(X, pairs, displacement, OfCircle(inside))
