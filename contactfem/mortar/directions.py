"""Normals given by a rigid obstacle.

A polyline with corners has none that is smooth, and one that turns over a facet's length is worse
than the averaged normals of the nonmortar side, which the body's own stiffness keeps smooth.
"""

from dataclasses import dataclass

import numpy as np

from contactfem.common.typing import Floats
from contactfem.mortar.interface_mesh import InterfaceMesh


@dataclass(frozen=True)
class OfPlane:
    """Against the normal of a plane.

    Attributes:
        normal: Unit normal, outward from the obstacle [-].
    """

    normal: tuple[float, ...]

    def __call__(self, mesh: InterfaceMesh, x: Floats) -> tuple[Floats, Floats]:
        """Find the normals of the nonmortar nodes.

        Args:
            mesh: The interface.
            x: Current positions [m], shape (n_nodes, dim).

        Returns:
            Unit normals of the nonmortar nodes [-], (n, dim), and their derivatives with respect to
            the position of each [1/m], (n, dim, dim).
        """
        n, dim = mesh.n_nonmortar, mesh.dim
        return np.tile(-np.array(self.normal), (n, 1)), np.zeros((n, dim, dim))


@dataclass(frozen=True)
class OfCircle:
    """Along the radius of a circle, or of a sphere.

    Attributes:
        inside: Whether bodies touch it from inside.
    """

    inside: bool

    def __call__(self, mesh: InterfaceMesh, x: Floats) -> tuple[Floats, Floats]:
        """Find normals and derivatives, as `OfPlane`: n = ∓ r/|r|, dn/dx = ∓ (1 - n nᵀ) / |r|."""
        centre = x[mesh.n_nonmortar :].mean(0)
        return _radial(x[: mesh.n_nonmortar] - centre, np.eye(mesh.dim), self.inside)


@dataclass(frozen=True)
class OfAxis:
    """Away from the axis of a cylinder.

    Attributes:
        axis: Unit vector along it [-].
        inside: Whether bodies touch the cylinder from inside.
    """

    axis: tuple[float, ...]
    inside: bool

    def __call__(self, mesh: InterfaceMesh, x: Floats) -> tuple[Floats, Floats]:
        """Find normals and derivatives, as `OfCircle`, with r the part across the axis."""
        across = np.eye(mesh.dim) - np.outer(self.axis, self.axis)
        centre = x[mesh.n_nonmortar :].mean(0)
        return _radial((x[: mesh.n_nonmortar] - centre) @ across, across, self.inside)


def _radial(radius: Floats, across: Floats, inside: bool) -> tuple[Floats, Floats]:
    """Directions of radii (n, dim), and their derivatives within the space that radii span.

    There is no direction in the centre, and no contact: any one stands for it there.
    """
    size = np.linalg.norm(radius, axis=1)
    centre = size == 0.0
    size[centre] = np.inf
    sign = 1.0 if inside else -1.0
    n = sign * radius / size[:, None]
    slopes = (across - np.einsum("ji,jk->jik", n, n)) * (sign / size)[:, None, None]
    some = np.argmax(np.diag(across))
    n[centre] = across[some] / np.linalg.norm(across[some])
    return n, slopes
