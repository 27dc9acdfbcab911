"""Smallest distance between two surfaces in space before anything moves."""

import numpy as np

from contactfem.case.obstacles import Obstacle, Plane, RigidCylinder, RigidSurface, Sphere
from contactfem.common.typing import Floats, Ints
from contactfem.geometry.facets import around
from contactfem.meshes.data import Surface
from contactfem.meshes.triangles import read_triangles

CANDIDATES = 16  # facets whose middles are nearest to a point, that are looked at


def spatial_gap(nonmortar: Surface, mortar: Surface) -> float | None:
    """Smallest gap between two surfaces in space.

    Nodes and middles of the facets of either side look for the nearest place of the other one that
    faces them.

    Args:
        nonmortar: The nonmortar surface.
        mortar: The mortar surface.

    Returns:
        The gap, negative where the bodies overlap [m]; None if they nowhere face each other.
    """
    found = np.concatenate((_gaps(nonmortar, mortar), _gaps(mortar, nonmortar)))
    return float(found.min()) if len(found) else None


def gap_to_obstacle(nonmortar: Surface, obstacle: Obstacle) -> float | None:
    """Smallest gap to a rigid obstacle, negative where the body reaches into it [m].

    Args:
        nonmortar: The nonmortar surface.
        obstacle: The obstacle at rest.

    Returns:
        The gap [m]; None if a surface from a file nowhere faces the body.
    """
    if isinstance(obstacle, RigidSurface):
        points, triangles = read_triangles(obstacle.file)
        used, facets = np.unique(triangles, return_inverse=True)
        shape = Surface(used, facets.reshape(triangles.shape), points[used] * obstacle.unit)
        return spatial_gap(nonmortar, shape)
    points = np.concatenate((nonmortar.X, nonmortar.X[nonmortar.facets].mean(axis=1)))
    if isinstance(obstacle, Plane):
        return float(np.min((points - obstacle.point) @ np.array(obstacle.normal)))
    if isinstance(obstacle, RigidCylinder):
        axis = np.array(obstacle.axis)
        away = points - obstacle.point
        r = np.linalg.norm(away - np.outer(away @ axis, axis), axis=1)
    else:
        assert isinstance(obstacle, Sphere)
        r = np.linalg.norm(points - obstacle.center, axis=1)
    distance = r - obstacle.radius
    return float(np.min(-distance if obstacle.inside else distance))


def _gaps(surface: Surface, other: Surface) -> Floats:
    """Signed distances from the points of a surface to the nearest place of another one."""
    from scipy.spatial import cKDTree

    corners = surface.X[around(surface.facets)]
    vectors = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    at_nodes = np.zeros_like(surface.X)
    np.add.at(at_nodes, surface.facets, vectors[:, None, :])
    points = np.concatenate((surface.X, surface.X[surface.facets].mean(axis=1)))
    normals = np.concatenate((at_nodes, vectors))
    middles = other.X[other.facets].mean(axis=1)
    count = min(CANDIDATES, len(middles))
    near: Ints = np.asarray(cKDTree(middles).query(points, count)[1]).reshape(len(points), count)
    distance = _distances(points, normals, other.X[around(other.facets)], near)
    nearest = np.argmin(np.abs(distance), axis=1)
    gaps = distance[np.arange(len(points)), nearest]
    return np.asarray(gaps[np.isfinite(gaps)])


def _distances(points: Floats, normals: Floats, corners: Floats, near: Ints) -> Floats:
    """Distances along the normals of some facets of those that a point is above or below, (p, k).

    A facet is four triangles around its middle; one of a triangle has no area. Infinite where the
    point is beside the facet or looks away from it.
    """
    result = np.full(near.shape, np.inf)
    for k in range(4):
        a, b = corners[near, k], corners[near, (k + 1) % 4]
        c = corners[near].mean(axis=2)
        n = np.cross(b - a, c - a)
        size = np.einsum("pkc,pkc->pk", n, n)
        r = points[:, None] - a
        u = np.einsum("pkc,pkc->pk", np.cross(r, c - a), n)
        v = np.einsum("pkc,pkc->pk", np.cross(b - a, r), n)
        room = 1e-9 * size
        inside = (u >= -room) & (v >= -room) & (u + v <= size + room) & (size > 0.0)
        inside &= np.einsum("pc,pkc->pk", normals, n) < 0.0
        height = np.einsum("pkc,pkc->pk", r, n) / np.sqrt(np.where(size > 0.0, size, 1.0))
        better = inside & (np.abs(height) < np.abs(result))
        result = np.where(better, height, result)
    return result
