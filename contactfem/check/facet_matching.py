"""Comparison of facet sizes where two surfaces are about to touch."""

from dataclasses import dataclass

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.geometry.facets import line_lengths
from contactfem.meshes.data import Surface

NEAR = 1.0  # facet lengths further apart than at the closest place that still count as touching


@dataclass(frozen=True)
class Match:
    """How the nonmortar facets that are about to touch compare with the mortar ones there.

    Attributes:
        ratio: Length of a mortar facet over that of the nonmortar one before it [-], the median.
        edges: Ends of the mortar side that lie before the middle of the nonmortar side [m], (k, 2).
    """

    ratio: float
    edges: Floats


def match(nonmortar: Surface, mortar: Surface) -> Match | None:
    """Compare the facets of two surfaces where they are closest to each other.

    Args:
        nonmortar: The nonmortar surface.
        mortar: The mortar surface.

    Returns:
        The comparison; None where they nowhere face each other.
    """
    h, h_mortar = (line_lengths(s.X, s.facets) for s in (nonmortar, mortar))
    other, distance = _nearest(_middles(nonmortar), _normals(nonmortar), mortar)
    if not np.isfinite(distance).any():
        return None
    near = distance <= distance.min() + NEAR * np.maximum(h, h_mortar[other])
    ends = np.flatnonzero(np.bincount(mortar.facets.ravel()) == 1)
    return Match(float(np.median(h_mortar[other[near]] / h[near])), _edges(nonmortar, mortar, ends))


def _edges(nonmortar: Surface, mortar: Surface, ends: Ints) -> Floats:
    """Those of some mortar nodes that touch the nonmortar side away from its own ends."""
    h = line_lengths(nonmortar.X, nonmortar.facets)
    a, b = (nonmortar.X[nonmortar.facets[:, k]] for k in (0, 1))
    inner = np.bincount(nonmortar.facets.ravel())[nonmortar.facets] > 1
    along, out = (b - a) / h[:, None], _normals(nonmortar)
    found = []
    for node in ends:
        from_a = mortar.X[node] - a
        place, height = np.sum(from_a * along, 1), np.abs(np.sum(from_a * out, 1))
        first = np.where(inner[:, 0], 0.0, 0.01 * h)  # an end on an end is no edge
        last = np.where(inner[:, 1], h, 0.99 * h)
        if np.any((place >= first) & (place <= last) & (height <= h)):
            found.append(mortar.X[node])
    return np.array(found).reshape(-1, 2)


def _nearest(points: Floats, normals: Floats, mortar: Surface) -> tuple[Ints, Floats]:
    """Nearest mortar facet that faces each point, by its middle, and how far it is [m]."""
    distance = np.linalg.norm(points[:, None] - _middles(mortar), axis=2)
    distance = np.where(normals @ _normals(mortar).T < 0.0, distance, np.inf)
    other = np.argmin(distance, axis=1)
    return other, distance[np.arange(len(points)), other]


def _middles(surface: Surface) -> Floats:
    return np.asarray(surface.X[surface.facets].mean(axis=1))


def _normals(surface: Surface) -> Floats:
    """Unit normals of the facets, out of the body."""
    edge = surface.X[surface.facets[:, 1]] - surface.X[surface.facets[:, 0]]
    return np.asarray(np.stack((edge[:, 1], -edge[:, 0]), 1) / np.hypot(*edge.T)[:, None])
