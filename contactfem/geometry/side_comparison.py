"""Comparison of two surfaces: facet sizes, and which one overhangs."""

from dataclasses import dataclass

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.geometry.facets import around, facet_sizes

SHARP = np.cos(np.radians(45.0))  # between normals: a convex corner that ends a surface
BESIDE = 0.05  # of a facet: an end so close to an end lies upon it
NEAR = 1.0  # facet sizes further apart than at the closest place that still count as near
PAIRS = 2_000_000  # pairs of facets that are looked at in one go
MOST = 5  # goes, beyond which only every so many-th facet is asked
WIDE = {2: 0.5, 3: 0.71}  # distance from the middle to the rim of a facet, over its size


@dataclass(frozen=True)
class Facets:
    """A surface by its facets.

    Attributes:
        X: Positions of nodes [m], (n, dim).
        nodes: Nodes of the facets, (k, 2), (k, 3), or (k, 4) in tensor order.
    """

    X: Floats
    nodes: Ints

    @property
    def middles(self) -> Floats:
        """Middles of the facets [m], (k, dim)."""
        return np.asarray(self.X[self.nodes].mean(axis=1))

    @property
    def normals(self) -> Floats:
        """Unit normals of the facets, out of the body, (k, dim)."""
        if self.X.shape[1] == 2:
            edge = self.X[self.nodes[:, 1]] - self.X[self.nodes[:, 0]]
            out = np.column_stack((edge[:, 1], -edge[:, 0]))
        else:
            a, b, c, d = self.X[around(self.nodes)].swapaxes(0, 1)
            out = np.cross(c - a, d - b)
        return np.asarray(out / np.linalg.norm(out, axis=1)[:, None])


@dataclass(frozen=True)
class Comparison:
    """How two surfaces differ where they are closest.

    Attributes:
        ratio: Size of the second one's facets over that of the first one's [-], the median.
        first_overhangs: Number of end nodes of the second before the middle of the first.
        second_overhangs: Number of end nodes of the first before the middle of the second.
    """

    ratio: float
    first_overhangs: int
    second_overhangs: int


def compare(first: Facets, second: Facets) -> Comparison:
    """Compare two surfaces, in the plane or in space.

    Args:
        first: One surface.
        second: The other one.
    """
    ratio, reach = _ratio_and_distance(first, second)
    if not np.isfinite(reach):
        return Comparison(ratio, 0, 0)
    return Comparison(ratio, _overhang(first, second, reach), _overhang(second, first, reach))


def size_ratio(first: Facets, second: Facets) -> float:
    """Size of the second one's facets over that of the first one's [-], where they are closest."""
    return _ratio_and_distance(first, second)[0]


def _ratio_and_distance(first: Facets, second: Facets) -> tuple[float, float]:
    """Ratio of sizes [-], and distance of the two [m]; infinite where they nowhere face."""
    sizes = [facet_sizes(side.X, side.nodes) for side in (first, second)]
    asked, other, distance = _nearest(first, second)
    reach = float(distance.min())
    if not np.isfinite(reach):
        return float(np.median(sizes[1]) / np.median(sizes[0])), reach
    own, opposite = sizes[0][asked], sizes[1][other]
    near = distance <= reach + NEAR * np.maximum(own, opposite)
    return float(np.median(opposite[near] / own[near])), reach


def surface_ends(side: Facets) -> Ints:
    """Where a surface ends: its border and its sharp convex corners.

    Args:
        side: The surface.

    Returns:
        Nodes in the plane (r, 1), edges in space (r, 2).
    """
    ridges, owner = _ridges(side.nodes)
    keys, first, inverse, count = np.unique(
        np.sort(ridges, axis=1), axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    last = np.empty(len(keys), dtype=np.int64)
    last[inverse.ravel()] = np.arange(len(ridges))
    f, g = owner[first], owner[last]
    normals, middles = side.normals, side.middles
    sharp = np.sum(normals[f] * normals[g], axis=1) < SHARP
    convex = np.sum(normals[f] * (middles[g] - middles[f]), axis=1) < 0.0
    return np.asarray(keys[(count == 1) | ((count == 2) & sharp & convex)])


def _ridges(nodes: Ints) -> tuple[Ints, Ints]:
    """Ends or edges of facets, and the facets that they are of."""
    if nodes.shape[1] == 2:
        return nodes.reshape(-1, 1), np.repeat(np.arange(len(nodes)), 2)
    loop = around(nodes)
    edges = np.stack((loop, np.roll(loop, -1, axis=1)), axis=2).reshape(-1, 2)
    real = edges[:, 0] != edges[:, 1]
    return edges[real], np.repeat(np.arange(len(nodes)), 4)[real]


def _nearest(first: Facets, second: Facets) -> tuple[Ints, Ints, Floats]:
    """Facets of the first, the nearest of the second that each faces, and how far it is [m]."""
    middles, normals = second.middles, second.normals
    step = max(1, -(-len(first.nodes) * len(middles) // (MOST * PAIRS)))
    asked = np.arange(0, len(first.nodes), step)
    parts = np.array_split(asked, -(-len(asked) * len(middles) // PAIRS))
    other, distance = [], []
    for part in parts:
        away = np.linalg.norm(first.middles[part][:, None] - middles, axis=2)
        away[first.normals[part] @ normals.T >= 0.0] = np.inf
        other.append(np.argmin(away, axis=1))
        distance.append(away[np.arange(len(part)), other[-1]])
    return asked, np.concatenate(other), np.concatenate(distance)


def _overhang(side: Facets, other: Facets, reach: float) -> int:
    """Number of end nodes of the other surface before the middle of a surface.

    Args:
        side: The surface.
        other: The other surface.
        reach: Smallest distance of the two [m].
    """
    points = other.X[np.unique(surface_ends(other))]
    ends = side.X[surface_ends(side)]
    sizes, middles, normals = facet_sizes(side.X, side.nodes), side.middles, side.normals
    wide = WIDE[side.X.shape[1]] + 1e-9
    count = 0
    for point in points:
        offset = point - middles
        height = np.sum(offset * normals, axis=1)
        along = np.linalg.norm(offset - height[:, None] * normals, axis=1)
        before = (along <= wide * sizes) & (height >= -sizes) & (height <= reach + sizes)
        feet = point - height[before, None] * normals[before]
        away = _distance_to_ends(feet, ends)
        count += bool(np.any(away > BESIDE * sizes[before]))
    return count


def _distance_to_ends(points: Floats, ends: Floats) -> Floats:
    """Distance of points (p, dim) from the nearest of some nodes or edges (r, 1 or 2, dim) [m]."""
    if not len(ends):
        return np.full(len(points), np.inf)
    a, edge = ends[:, 0], ends[:, -1] - ends[:, 0]
    from_a = points[:, None] - a
    length = np.sum(edge**2, axis=1)
    share = np.sum(from_a * edge, axis=2) / np.where(length > 0.0, length, 1.0)
    foot = np.clip(share, 0.0, 1.0)[:, :, None] * edge
    return np.asarray(np.linalg.norm(from_a - foot, axis=2).min(axis=1))
