"""Rigid obstacles in space as facets: plane, sphere, cylinder, triangulated surface."""

from collections.abc import Sequence

import numpy as np

from contactfem.common.time_table import Table
from contactfem.common.typing import Bools, Floats, Ints
from contactfem.mortar.directions import OfAxis, OfCircle, OfPlane
from contactfem.mortar.sides import RigidSide

# An octahedron: every edge is halved as often as needed, and corners are put on the sphere.
OCTAHEDRON = np.array(
    [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], dtype=np.float64
)
SIDES_OF_OCTAHEDRON = np.array(
    [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
)


def tangents(normal: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors that make a right-handed basis with a unit normal, in this order after it.

    Args:
        normal: Unit normal [-], (3,).
    """
    other = np.eye(3)[np.argmin(np.abs(normal))]
    first = np.cross(normal, other)
    first /= np.linalg.norm(first)
    return first, np.cross(normal, first)


def spatial_plane(
    point: Sequence[float],
    normal: Sequence[float],
    extent: float,
    displacement: tuple[Table, ...],
) -> RigidSide:
    """A rigid plane as one large square.

    Args:
        point: A point on it [m].
        normal: Outward from the obstacle [-], not necessarily of unit length.
        extent: Half its width [m].
        displacement: x, y and z over time [m].

    Returns:
        The side.
    """
    n = np.asarray(normal, float)
    n = n / np.linalg.norm(n)
    a, b = tangents(n)
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    X = np.array([np.asarray(point) + extent * (i * a + j * b) for i, j in corners])
    return RigidSide(X, np.array(((0, 1, 3, 2),)), displacement, OfPlane(tuple(n.tolist())))


def sphere_side(
    centre: Sequence[float],
    radius: float,
    inside: bool,
    size: float,
    near: Floats,
    displacement: tuple[Table, ...],
) -> RigidSide:
    """The part of a rigid sphere near a body, as triangles that enclose as much as the sphere.

    Args:
        centre: Its centre [m].
        radius: Its radius [m].
        inside: Whether bodies touch it from inside (the obstacle lies around the sphere).
        size: Largest length of an edge [m].
        near: Smallest and largest coordinates that the body may reach [m], (2, 3).
        displacement: x, y and z over time [m].

    Returns:
        The side.
    """
    halvings = max(2, int(np.ceil(np.log2(2.45 * radius / size))))
    X, facets = _refined(halvings, (near - np.asarray(centre)) / radius)
    X = X * _swelling(*X[facets].swapaxes(0, 1))
    facets = facets[:, ::-1] if inside else facets
    return RigidSide(np.asarray(centre) + radius * X, facets, displacement, OfCircle(inside))


def cylinder_side(
    point: Sequence[float],
    axis: Sequence[float],
    radius: float,
    inside: bool,
    facets: int,
    extent: float,
    displacement: tuple[Table, ...],
) -> RigidSide:
    """A long rigid cylinder as a prism that encloses as much as the cylinder.

    Args:
        point: A point on its axis [m].
        axis: Direction of the axis [-].
        radius: Its radius [m].
        inside: Whether bodies touch it from inside (the obstacle lies around the cylinder).
        facets: Number of facets around.
        extent: Half its length [m].
        displacement: x, y and z over time [m].

    Returns:
        The side.
    """
    along = np.asarray(axis, float)
    along = along / np.linalg.norm(along)
    a, b = tangents(along)
    turn = 2.0 * np.pi * np.arange(facets) / facets
    r = radius * np.sqrt(2.0 * np.pi / facets / np.sin(2.0 * np.pi / facets))
    ring = r * (np.cos(turn)[:, None] * a + np.sin(turn)[:, None] * b)
    ends = [np.asarray(point) + ring + sign * extent * along for sign in (-1.0, 1.0)]
    k = np.arange(facets)
    after = (k + 1) % facets
    quads = np.column_stack((k, after, facets + k, facets + after))
    quads = quads[:, [1, 0, 3, 2]] if inside else quads
    return RigidSide(
        np.concatenate(ends), quads, displacement, OfAxis(tuple(along.tolist()), inside)
    )


def triangulated_side(X: Floats, triangles: Ints, displacement: tuple[Table, ...]) -> RigidSide:
    """A rigid surface of triangles, counter-clockwise seen from outside of the obstacle.

    Args:
        X: Its points [m], (n, 3).
        triangles: Its facets, (k, 3).
        displacement: x, y and z over time [m].

    Returns:
        The side.
    """
    return RigidSide(X, triangles, displacement, None)


def _swelling(a: Floats, b: Floats, c: Floats) -> float:
    """Factor on triangles with corners on the unit sphere, that then enclose as much as it.

    The volume of a triangle with the centre is a·(b × c)/6, that of the sphere Ω/3 with the solid
    angle tan Ω/2 = a·(b × c) / (1 + a·b + b·c + c·a).
    """
    triple = np.einsum("ki,ki->k", a, np.cross(b, c))
    dots = sum(np.einsum("ki,ki->k", x, y) for x, y in ((a, b), (b, c), (c, a)))
    angle = 2.0 * np.arctan2(triple, 1.0 + dots)
    return float((2.0 * angle.sum() / triple.sum()) ** (1.0 / 3.0))


def _refined(halvings: int, near: Floats) -> tuple[Floats, Ints]:
    """Triangles of the unit sphere that reach into a box, every edge halved some times."""
    X, facets = OCTAHEDRON, SIDES_OF_OCTAHEDRON
    for _ in range(halvings):
        pairs = [facets[:, ends] for ends in ([0, 1], [1, 2], [2, 0])]
        edges = np.sort(np.concatenate(pairs), axis=1)
        unique, at = np.unique(edges, axis=0, return_inverse=True)
        middle = X[unique].sum(axis=1)
        middle /= np.linalg.norm(middle, axis=1)[:, None]
        m = len(X) + at.reshape(3, -1)
        a, b, c = facets.T
        corners = ((a, m[0], m[2]), (b, m[1], m[0]), (c, m[2], m[1]), tuple(m))
        facets = np.concatenate([np.column_stack(corner) for corner in corners])
        X = np.concatenate((X, middle))
        facets = facets[_reaches(X[facets], near)]
        used, number = np.unique(facets, return_inverse=True)
        X, facets = X[used], number.reshape(facets.shape)
    return X, facets


def _reaches(corners: Floats, near: Floats) -> Bools:
    """Which triangles (k, 3, 3) may reach into a box; the nearest ones where none does."""
    middle = corners.mean(axis=1)
    radius = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
    away = np.linalg.norm(middle - np.clip(middle, near[0], near[1]), axis=1)
    inside = away <= 2.0 * radius
    return inside if inside.any() else np.asarray(away <= away.min() + 2.0 * radius)
