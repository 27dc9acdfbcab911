"""Smallest distance between the two sides of an interface before anything moves."""

import numpy as np

from contactfem.case.obstacles import Circle, Plane, Polyline
from contactfem.common.typing import Floats
from contactfem.geometry.thickness import thickness

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


def surface_gap(
    nonmortar: Floats,
    mortar: Floats,
    outlines: tuple[Floats | None, Floats | None] = (None, None),
) -> float | None:
    """The gap of `nearest_place` alone [m]; None if the lines nowhere face each other."""
    found = nearest_place(nonmortar, mortar, outlines)
    return None if found is None else found[0]


def nearest_place(
    nonmortar: Floats,
    mortar: Floats,
    outlines: tuple[Floats | None, Floats | None] = (None, None),
) -> tuple[float, Floats] | None:
    """Smallest gap between two polylines, each with its body on the left, and where it is.

    Every point looks for the nearest piece of the other line that faces it, from either side. What
    is further behind a point than its own body's far side is no overlap.

    Args:
        nonmortar: (k, 2) [m]; rows of NaN keep chains apart.
        mortar: (l, 2) [m], likewise.
        outlines: Ends of the facets around the two bodies [m], (b, 2, 2) each; None for lines that
            may be behind each other by any depth.

    Returns:
        The gap, negative where the bodies overlap [m], and a point of one line there (2,) [m]; None
        if the lines nowhere face each other.
    """
    found = [_gaps(chain, mortar, outlines[0]) for chain in chains(nonmortar)]
    found += [_gaps(chain, nonmortar, outlines[1]) for chain in chains(mortar)]
    gaps, points = (np.concatenate(part) for part in zip(*found, strict=True))
    if not len(gaps):
        return None
    k = int(np.argmin(gaps))
    return float(gaps[k]), points[k]


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


def _gaps(line: Floats, other: Floats, outline: Floats | None) -> tuple[Floats, Floats]:
    """Signed distances from points of a line to the nearest piece of another facing them; these."""
    points = refined(line)
    normals = np.repeat(_normals(line), REFINE, axis=0)
    normals = np.concatenate([normals, normals[-1:]])
    start, along = other[:-1], np.diff(other, axis=0)
    share = np.einsum("pmd,md->pm", points[:, None] - start[None], along) / np.sum(along**2, axis=1)
    inside = (share >= -1e-9) & (share <= 1.0 + 1e-9)
    facing = normals @ _normals(other).T < 0.0
    distance = np.einsum("pmd,md->pm", points[:, None] - start[None], _normals(other))
    distance = np.where(inside & facing, distance, np.inf)
    found = _visible(points, distance, _normals(other), outline)
    seen = np.isfinite(found)
    return found[seen], points[seen]


def _visible(points: Floats, distance: Floats, normals: Floats, outline: Floats | None) -> Floats:
    """Nearest of the distances to pieces (p, m), overlaps only through the points' own body."""
    distance, todo = distance.copy(), np.arange(len(points))
    while True:
        nearest = np.argmin(np.abs(distance), axis=1)
        found: Floats = distance[np.arange(len(points)), nearest]
        todo = todo[(found[todo] < 0.0) & np.isfinite(found[todo])]
        if outline is None or not len(todo):
            return found
        depth = thickness(points[todo], -normals[nearest[todo]], outline)[0]
        outside = np.isinf(depth)  # starts at a corner, away from the body
        todo = todo[outside | (depth < -found[todo] * (1.0 - 1e-9))]
        distance[todo, nearest[todo]] = np.inf
