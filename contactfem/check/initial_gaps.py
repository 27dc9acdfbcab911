"""Smallest distance between the two sides of an interface before anything moves."""

import numpy as np

from contactfem.case.obstacles import Circle, Plane, Polyline
from contactfem.common.typing import Floats

REFINE = 16  # points per straight piece, for a smallest gap in its middle


def obstacle_gap(line: Floats, obstacle: Plane | Circle | Polyline) -> float | None:
    """Smallest gap to an obstacle, negative where the body reaches into it.

    Args:
        line: polyline of the nonmortar side (k, 2) [m]; rows of NaN keep chains apart.
        obstacle: the obstacle at rest.

    Returns:
        The gap [m]; None if a polyline nowhere faces the body.
    """
    if isinstance(obstacle, Polyline):
        return surface_gap(line, obstacle.chain)
    points = np.concatenate([refined(chain) for chain in chains(line)])
    if isinstance(obstacle, Plane):
        return float(np.min((points - obstacle.point) @ np.array(obstacle.normal)))
    distance = np.linalg.norm(points - obstacle.center, axis=1) - obstacle.radius
    return float(np.min(-distance if obstacle.inside else distance))


def surface_gap(nonmortar: Floats, mortar: Floats) -> float | None:
    """Smallest gap between two polylines, each with its body on the left.

    Every point looks for the nearest piece of the other line that faces it, from either side.

    Args:
        nonmortar: (k, 2) [m]; rows of NaN keep chains apart.
        mortar: (l, 2) [m], likewise.

    Returns:
        The gap, negative where the bodies overlap [m]; None if the lines nowhere face each other.
    """
    found = [_gaps(chain, mortar) for chain in chains(nonmortar)]
    found += [_gaps(chain, nonmortar) for chain in chains(mortar)]
    gaps = np.concatenate(found)
    return float(np.min(gaps)) if len(gaps) else None


def chains(line: Floats) -> list[Floats]:
    """Polylines that rows of NaN keep apart in one."""
    first, *rest = np.split(line, np.flatnonzero(np.isnan(line[:, 0])))
    return [first, *(chain[1:] for chain in rest)]


def refined(line: Floats) -> Floats:
    """Polyline with more points on it."""
    share = np.linspace(0.0, 1.0, REFINE, endpoint=False)[None, :, None]
    pieces = line[:-1, None] * (1.0 - share) + line[1:, None] * share
    return np.concatenate([pieces.reshape(-1, 2), line[-1:]])


def _normals(line: Floats) -> Floats:
    """Unit normals of the pieces, pointing out of the body."""
    along = np.diff(line, axis=0)
    length = np.linalg.norm(along, axis=1, keepdims=True)
    return np.asarray(np.stack([along[:, 1], -along[:, 0]], axis=1) / length)


def _gaps(line: Floats, other: Floats) -> Floats:
    """Signed distances from the points of a line to the nearest piece of another facing them."""
    points = refined(line)
    normals = np.repeat(_normals(line), REFINE, axis=0)
    normals = np.concatenate([normals, normals[-1:]])
    start, along = other[:-1], np.diff(other, axis=0)
    share = np.einsum("pmd,md->pm", points[:, None] - start[None], along) / np.sum(along**2, axis=1)
    inside = (share >= -1e-9) & (share <= 1.0 + 1e-9)
    facing = normals @ _normals(other).T < 0.0
    distance = np.einsum("pmd,md->pm", points[:, None] - start[None], _normals(other))
    distance = np.where(inside & facing, distance, np.inf)
    nearest = np.argmin(np.abs(distance), axis=1)
    found = distance[np.arange(len(points)), nearest]
    return np.asarray(found[np.isfinite(found)])
