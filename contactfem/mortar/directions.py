"""Normals given by a rigid obstacle.

A polyline with corners has none that is smooth, and one that turns over a facet's length is worse
than the averaged normals of the nonmortar side, which the body's own stiffness keeps smooth.
"""

from dataclasses import dataclass

import numpy as np

from contactfem.common.typing import Floats
from contactfem.mortar.interface_mesh import InterfaceMesh, averaged_normals


def of_plane(mesh: InterfaceMesh, x: Floats) -> tuple[Floats, Floats]:
    """Against the normal of a mortar side that is one facet.

    Args:
        mesh: The interface.
        x: Current positions [m], shape (n_nodes, 2).

    Returns:
        Unit normals of the nonmortar nodes [-], (n, 2), and their derivatives with respect to the
        position of each [1/m], (n, 2, 2).
    """
    a, b = x[mesh.mortar[0]]
    n = np.array((a[1] - b[1], b[0] - a[0])) / np.hypot(*(b - a))
    return np.tile(n, (mesh.n_nonmortar, 1)), np.zeros((mesh.n_nonmortar, 2, 2))


@dataclass(frozen=True)
class OfCircle:
    """Along the radius of a mortar side that is a regular polygon.

    Attributes:
        inside: Whether bodies touch the circle from inside.
    """

    inside: bool

    def __call__(self, mesh: InterfaceMesh, x: Floats) -> tuple[Floats, Floats]:
        """Find normals and derivatives, as `of_plane`: n = ∓ r/|r|, dn/dx = ∓ (1 - n nᵀ) / |r|."""
        radius = x[: mesh.n_nonmortar] - x[mesh.n_nonmortar :].mean(0)
        size = np.hypot(*radius.T)
        centre = size == 0.0  # no direction there, and no contact
        sign = 1.0 if self.inside else -1.0
        size[centre] = np.inf
        n = sign * radius / size[:, None]
        slopes = (np.eye(2) - np.einsum("ji,jk->jik", n, n)) * (sign / size)[:, None, None]
        n[centre] = averaged_normals(mesh, x)[0][centre]
        return n, slopes
