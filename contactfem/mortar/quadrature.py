"""Integration points on segments."""

from dataclasses import dataclass

import numpy as np

from contactfem.common.typing import Bools, Floats, Ints
from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.normals import NormalField
from contactfem.mortar.segments import Segments

FLAT = 1e-6  # gap over the length of a facet that is round-off of a mesh
LARGEST = 10.0  # ratio of areas, beyond which the surfaces hardly face each other
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(3)  # of each segment


@dataclass(frozen=True)
class IntegrationPoints:
    """Integration points of segments.

    Attributes:
        nonmortar: Nodes of each segment's nonmortar facet, (s, 2).
        mortar: Nodes of its mortar facet, (s, 2).
        N: Nonmortar shape functions [-], (s, q, 2).
        zeta: Mortar facet coordinate in [0, 1], (s, q).
        gap: g [m], (s, q).
        weight: Of the integration over the current surface [m], (s, q).
        ratio: Area of the mortar side over that of the nonmortar side, both seen along the normal,
            positive [-], (s, q).
        touching: Whether the gap is closed as far as straight facets on curved surfaces tell,
            (s, q).
    """

    nonmortar: Ints
    mortar: Ints
    N: Floats
    zeta: Floats
    gap: Floats
    weight: Floats
    ratio: Floats
    touching: Bools

    def values(self, nodal: Floats) -> Floats:
        """Nonmortar nodal values at the points, (s, q)."""
        return np.asarray(np.einsum("sqi,si->sq", self.N, nodal[self.nonmortar]))

    def vectors(self, nodal: Floats) -> Floats:
        """Nonmortar nodal vectors (n, dim) at the points, (s, q, dim)."""
        return np.asarray(np.einsum("sqi,sik->sqk", self.N, nodal[self.nonmortar]))

    def jump(self) -> tuple[Ints, Floats]:
        """Nodes (s, 4), and the weights (s, q, 4) that make ϑ_nm - ϑ_m of their temperatures."""
        z = self.zeta[:, :, None]
        weights = np.concatenate((self.N, z - 1.0, -z), axis=2)
        return np.hstack((self.nonmortar, self.mortar)), weights


def integration_points(
    mesh: InterfaceMesh, x: Floats, normals: NormalField, segments: Segments
) -> IntegrationPoints:
    """Three Gauss points in each segment.

    Args:
        mesh: The interface.
        x: Current positions [m], (n, 2).
        normals: Normal field that the segments were cut with.
        segments: The segments.

    Returns:
        The points.
    """
    nonmortar = mesh.nonmortar[segments.facets[:, 0]]
    mortar = mesh.mortar[segments.facets[:, 1]]
    lo, hi = segments.span.T
    xi = 0.5 * (lo + hi)[:, None] + 0.5 * (hi - lo)[:, None] * POINTS
    N = np.stack((0.5 * (1.0 - xi), 0.5 * (1.0 + xi)), axis=2)
    at = np.einsum("sqi,sik->sqk", N, x[nonmortar])
    n = np.einsum("sqi,sik->sqk", N, normals.n[nonmortar])
    c, edge = x[mortar[:, 0]][:, None], (x[mortar[:, 1]] - x[mortar[:, 0]])[:, None]
    zeta = _cross(at - c, n) / _cross(edge, n)
    gap = np.einsum("sqk,sqk->sq", c + zeta[:, :, None] * edge - at, n) / np.hypot(*n.T).T
    own = x[nonmortar[:, 1]] - x[nonmortar[:, 0]]
    turn = normals.n[nonmortar[:, 1]] - normals.n[nonmortar[:, 0]]
    length = np.hypot(*own.T)
    weight = WEIGHTS * (0.25 * (hi - lo) * length)[:, None]
    ratio = _area_ratio(n, own[:, None], turn[:, None], gap)
    if mesh.axisymmetric:
        weight = weight * 2.0 * np.pi * at[:, :, 0]
        r = np.maximum(np.stack((at[:, :, 0], (c + zeta[:, :, None] * edge)[:, :, 0])), 0.0)
        ratio = np.where(r[0] > 0.0, ratio * r[1] / np.where(r[0] > 0.0, r[0], 1.0), 1.0)
    sagitta = np.hypot(*turn.T) * (length + np.hypot(*edge[:, 0].T) ** 2 / length) / 4.0
    touching = gap <= (sagitta + FLAT * length)[:, None]
    return IntegrationPoints(nonmortar, mortar, N, zeta, gap, weight, ratio, touching)


def _area_ratio(n: Floats, own: Floats, turn: Floats, gap: Floats) -> Floats:
    """How much longer than the nonmortar side the mortar side is, both across the normal (s, q).

    Opposite x lies x + g n/|n|, which moves across n by (x' + g n'/|n|) x n along the facet.
    """
    size = np.hypot(n[..., 0], n[..., 1])
    ratio = 1.0 + gap / size * _cross(turn, n) / _cross(own, n)
    return np.asarray(np.clip(ratio, 1.0 / LARGEST, LARGEST))


def logarithmic_mean(ratio: Floats) -> Floats:
    """Logarithmic mean of 1 and a ratio, (r - 1) / ln r: the mean area between two cylinders."""
    near = np.abs(ratio - 1.0) < 1e-4
    other = np.where(near, 2.0, ratio)
    d = ratio - 1.0
    return np.where(near, 1.0 + d / 2.0 - d**2 / 12.0, (other - 1.0) / np.log(other))


def _cross(a: Floats, b: Floats) -> Floats:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
