"""Resultants of loads on facets and cells."""

import numpy as np

from contactfem.audit.shapes import BodyShape
from contactfem.common.typing import Floats, Ints
from contactfem.geometry.facets import around


def on_surface(x: Floats, facets: Ints, density: Floats, *, axisymmetric: bool) -> Floats:
    """∫ t dA of a traction over facets [N/m], around an axis [N], (dim,).

    Args:
        x: Positions of the vertices [m], (n, dim).
        facets: The facets, (k, 2), (k, 3), or (k, 4) in tensor order.
        density: Traction [Pa], (dim,), or of each facet, (k, dim).
        axisymmetric: Whether the integral runs around the axis x = 0.
    """
    size = np.linalg.norm(_areas(x, facets, axisymmetric), axis=1)
    return np.asarray((np.atleast_2d(density) * size[:, None]).sum(0))


def of_pressure(x: Floats, facets: Ints, pressure: Floats | float, *, axisymmetric: bool) -> Floats:
    """-∫ p n dA of a pressure over facets [N/m], one or of each facet, as for `on_surface`."""
    areas = _areas(x, facets, axisymmetric)
    return np.asarray(-(np.reshape(pressure, (-1, 1)) * areas).sum(0))


def means(values: Floats, X: Floats, cells: Ints, *, axisymmetric: bool) -> Floats:
    """Mean of a linear function over facets or simplices, by volume around an axis, (k,).

    Args:
        values: At the corners, (k, m).
        X: Points [m], (n, dim).
        cells: Corners of facets or simplices, (k, m).
        axisymmetric: Whether they run around the axis x = 0.
    """
    if not axisymmetric:
        return np.asarray(values.mean(axis=1))
    r = X[cells][:, :, 0]
    product = values.sum(1) * r.sum(1) + (values * r).sum(1)
    return np.asarray(product / ((cells.shape[1] + 1) * r.sum(1)))


def in_volume(body: BodyShape, density: Floats, *, axisymmetric: bool) -> Floats:
    """∫ b dV of a force per reference volume [N/m], (dim,).

    Args:
        body: The body.
        density: Force density [N/m³], (dim,), or of each simplex, (k, dim).
        axisymmetric: Whether the integral runs around the axis x = 0.
    """
    corners = body.X[body.simplices]
    edges = corners[:, 1:] - corners[:, :1]
    volume = np.abs(np.linalg.det(edges)) / (2.0 if edges.shape[1] == 2 else 6.0)
    if axisymmetric:
        volume = volume * 2.0 * np.pi * corners[:, :, 0].mean(1)
    return np.asarray((np.atleast_2d(density) * volume[:, None]).sum(0))


def _areas(x: Floats, facets: Ints, axisymmetric: bool) -> Floats:
    """Outward normals times area of facets [m], or around an axis [m²], (k, dim)."""
    if x.shape[1] == 3:
        a, b, c, d = x[around(facets)].swapaxes(0, 1)
        return np.asarray(0.5 * np.cross(c - a, d - b))
    corners = x[facets]
    edges = corners[:, 1:] - corners[:, :1]
    area = np.column_stack((edges[:, 0, 1], -edges[:, 0, 0]))
    if axisymmetric:
        area = area * (2.0 * np.pi * corners[:, :, 0].mean(1))[:, None]
    return np.asarray(area)
