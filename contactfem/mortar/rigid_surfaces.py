"""Rigid obstacles in space as facets: plane, sphere, cylinder, triangulated surface."""

from collections.abc import Sequence

import numpy as np

from contactfem.common.time_table import Table
from contactfem.common.typing import Floats, Ints
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
    displacement: tuple[Table, ...],
) -> RigidSide:
    """A rigid sphere as a polyhedron that encloses as much as the sphere.

    Args:
        centre: Its centre [m].
        radius: Its radius [m].
        inside: Whether bodies touch it from inside (the obstacle lies around the sphere).
        size: Largest length of an edge [m].
        displacement: x, y and z over time [m].

    Returns:
        The side.
    """
    halvings = max(2, int(np.ceil(np.log2(2.45 * radius / size))))
    X, facets = _refined(OCTAHEDRON, SIDES_OF_OCTAHEDRON, halvings)
    volume = np.einsum("ki,ki->", X[facets[:, 0]], np.cross(X[facets[:, 1]], X[facets[:, 2]])) / 6.0
    X = X * (4.0 * np.pi / 3.0 / volume) ** (1.0 / 3.0)
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


def _refined(X: Floats, facets: Ints, halvings: int) -> tuple[Floats, Ints]:
    """Triangles of the unit sphere with every edge halved some times."""
    for _ in range(halvings):
        pairs = [facets[:, ends] for ends in ([0, 1], [1, 2], [2, 0])]
        edges = np.sort(np.concatenate(pairs), axis=1)
        unique, at = np.unique(edges, axis=0, return_inverse=True)
        middle = X[unique].sum(axis=1)
        middle /= np.linalg.norm(middle, axis=1)[:, None]
        m = len(X) + at.reshape(3, -1)
        a, b, c = facets.T
        facets = np.concatenate(
            [
                np.column_stack(corner)
                for corner in ((a, m[0], m[2]), (b, m[1], m[0]), (c, m[2], m[1]), tuple(m))
            ]
        )
        X = np.concatenate((X, middle))
    return X, facets
