"""Integration points on segments."""

from dataclasses import dataclass

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.normals import NormalField
from contactfem.mortar.segments import Segments

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
    """

    nonmortar: Ints
    mortar: Ints
    N: Floats
    zeta: Floats
    gap: Floats
    weight: Floats

    def values(self, nodal: Floats) -> Floats:
        """Nonmortar nodal values at the points, (s, q)."""
        return np.asarray(np.einsum("sqi,si->sq", self.N, nodal[self.nonmortar]))

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
    length = np.hypot(*(x[nonmortar[:, 1]] - x[nonmortar[:, 0]]).T)
    weight = WEIGHTS * (0.25 * (hi - lo) * length)[:, None]
    if mesh.axisymmetric:
        weight = weight * 2.0 * np.pi * at[:, :, 0]
    return IntegrationPoints(nonmortar, mortar, N, zeta, gap, weight)


def _cross(a: Floats, b: Floats) -> Floats:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
