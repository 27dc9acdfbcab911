"""Resultants of loads on facets and cells."""

import numpy as np

from contactfem.audit.shapes import BodyShape
from contactfem.common.typing import Floats, Ints


def on_surface(x: Floats, facets: Ints, density: Floats, *, axisymmetric: bool) -> Floats:
    """∫ t dA of a traction over facets [N/m], around an axis [N], (dim,).

    Args:
        x: Positions of the vertices [m], (n, dim).
        facets: The facets, (k, dim).
        density: Traction [Pa], (dim,).
        axisymmetric: Whether the integral runs around the axis x = 0.
    """
    return np.asarray(density * np.linalg.norm(_areas(x, facets, axisymmetric), axis=1).sum())


def of_pressure(x: Floats, facets: Ints, pressure: float, *, axisymmetric: bool) -> Floats:
    """-∫ p n dA of a pressure over facets [N/m], arguments as for `on_surface`."""
    return np.asarray(-pressure * _areas(x, facets, axisymmetric).sum(0))


def in_volume(body: BodyShape, density: Floats, *, axisymmetric: bool) -> Floats:
    """∫ b dV of a force per reference volume [N/m], (dim,).

    Args:
        body: The body.
        density: Force density [N/m³], (dim,).
        axisymmetric: Whether the integral runs around the axis x = 0.
    """
    corners = body.X[body.simplices]
    edges = corners[:, 1:] - corners[:, :1]
    volume = np.abs(np.linalg.det(edges)) / (2.0 if edges.shape[1] == 2 else 6.0)
    if axisymmetric:
        volume = volume * 2.0 * np.pi * corners[:, :, 0].mean(1)
    return np.asarray(density * volume.sum())


def _areas(x: Floats, facets: Ints, axisymmetric: bool) -> Floats:
    """Outward normals times area of facets [m], or around an axis [m²], (k, dim)."""
    corners = x[facets]
    edges = corners[:, 1:] - corners[:, :1]
    if x.shape[1] == 3:
        return np.asarray(0.5 * np.cross(edges[:, 0], edges[:, 1]))
    area = np.column_stack((edges[:, 0, 1], -edges[:, 0, 0]))
    if axisymmetric:
        area = area * (2.0 * np.pi * corners[:, :, 0].mean(1))[:, None]
    return np.asarray(area)
