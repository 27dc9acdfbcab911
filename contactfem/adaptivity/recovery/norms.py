"""Estimated error: the norm of recovered minus discrete field (32)."""

from dataclasses import dataclass, replace

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.results.relative_error import RelativeError
from contactfem.transfer.shape_functions import shape_functions

TRIANGLE = np.array([[4.0, 1.0, 1.0], [1.0, 4.0, 1.0], [1.0, 1.0, 4.0]]) / 6.0
GAUSS = np.array([-1.0, 1.0]) / np.sqrt(3.0)
SQUARE = 0.5 + 0.5 * np.column_stack((np.repeat(GAUSS, 2), np.tile(GAUSS, 2)))


@dataclass(frozen=True)
class Quadrature:
    """A rule for all cells of a mesh, exact for products of two linear (bilinear) functions.

    Attributes:
        shapes: Shape functions at the points, shape (q, nv).
        weights: Weights [m²], shape (m, q).
        x: Points [m], shape (m, q, 2).
    """

    shapes: Floats
    weights: Floats
    x: Floats


def sample_points(n_vertices: int) -> Floats:
    """Where to take a discrete field in the reference cell: in its middle, where it converges best.

    In quadrilaterals also at the points of `quadrature`, where the field differs from that.

    Args:
        n_vertices: 3 or 4.

    Returns:
        Points, shape (1, 2) or (5, 2).
    """
    if n_vertices == 3:
        return np.full((1, 2), 1.0 / 3.0)
    return np.vstack((np.full((1, 2), 0.5), SQUARE))


def quadrature(points: Floats, cells: Ints) -> Quadrature:
    """Three points in a triangle, 2 x 2 Gauss points in a quadrilateral.

    Args:
        points: Vertices of the mesh [m], shape (n, 2).
        cells: Triangles or quadrilaterals (in dolfinx's order), shape (m, 3 or 4).

    Returns:
        The rule.
    """
    corners = points[cells]
    if cells.shape[1] == 3:
        a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        area = 0.5 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
        return Quadrature(TRIANGLE, np.repeat(area[:, None] / 3.0, 3, axis=1), TRIANGLE @ corners)
    shapes, slopes = shape_functions("quadrilateral", SQUARE)
    ds, dt = (slopes[:, :, axis] @ corners for axis in (0, 1))
    weights = 0.25 * np.abs(ds[..., 0] * dt[..., 1] - ds[..., 1] * dt[..., 0])
    return Quadrature(shapes, weights, shapes @ corners)


def around_axis(rule: Quadrature) -> Quadrature:
    """The rule for a body of revolution about x = 0, with the weight 2πx; weights are in [m³] then.

    Args:
        rule: The rule for the section.

    Returns:
        The rule for the body.
    """
    return replace(rule, weights=2.0 * np.pi * rule.x[..., 0] * rule.weights)


def squared_norms(rule: Quadrature, field: Floats, metric: Floats | None = None) -> Floats:
    """∫ τ·M τ over each cell.

    Args:
        rule: The quadrature.
        field: τ in each cell, shape (m, c), or at its points, shape (m, q, c).
        metric: M, shape (c, c) or, cell by cell, (m, c, c); the identity without.

    Returns:
        Squares of the norms, shape (m,).
    """
    field = field[:, None, :] if field.ndim == 2 else field
    weighted = field if metric is None else _times(field, metric)
    densities = np.einsum("mqc,mqc->mq", weighted, field)
    if densities.shape[1] == 1:
        return np.asarray(rule.weights.sum(axis=1) * densities[:, 0])
    return np.asarray((rule.weights * densities).sum(axis=1))


def squared_errors(
    rule: Quadrature, cells: Ints, recovered: Floats, discrete: Floats, metric: Floats | None = None
) -> Floats:
    """‖τ* - τ_h‖² over each cell, (32).

    Args:
        rule: The quadrature.
        cells: The cells, shape (m, nv).
        recovered: τ* at the vertices, shape (n, c).
        discrete: τ_h in each cell, shape (m, c), or at its points, shape (m, q, c).
        metric: M of the norm, shape (c, c) or (m, c, c); the identity without.

    Returns:
        Squares of the errors, shape (m,).
    """
    discrete = discrete[:, None, :] if discrete.ndim == 2 else discrete
    if metric is not None and metric.ndim == 3:
        return squared_norms(rule, rule.shapes @ recovered[cells] - discrete, metric)
    if metric is not None:  # M = L Lᵀ: |Lᵀτ|² costs less than τ·Mτ
        root: Floats = np.linalg.cholesky(metric).astype(np.float64)
        recovered, discrete = recovered @ root, _times(discrete, root)
    # cells last: long loops
    error = np.tensordot(rule.shapes, recovered.T[:, cells.T], axes=(1, 1))
    error -= discrete.transpose(1, 2, 0)
    densities = np.einsum("qcm,qcm->qm", error, error)
    return np.asarray((rule.weights.T * densities).sum(axis=0))


def relative_error(errors: Floats, norms: Floats) -> RelativeError:
    """Sum up the squares of the errors and norms of cells.

    Args:
        errors: Squares of the errors, shape (m,).
        norms: Squares of the norms of the discrete field, shape (m,).

    Returns:
        The relative error (40).
    """
    return RelativeError(float(errors.sum()), float(norms.sum()))


def _times(field: Floats, matrix: Floats) -> Floats:
    """Field (m, q, c) times a matrix (c, c), or one for each cell."""
    if matrix.ndim == 3:
        return field @ matrix
    return (field.reshape(-1, len(matrix)) @ matrix).reshape(field.shape)


def elastic_compliance(youngs_modulus: float, poisson_ratio: float) -> Floats:
    """M of the complementary energy norm, σ·Mσ = ((1+ν) σ:σ - ν (tr σ)²)/E with xy counted twice.

    Args:
        youngs_modulus: E [Pa].
        poisson_ratio: ν [-].

    Returns:
        M for (xx, yy, zz, xy) [1/Pa], shape (4, 4).
    """
    trace = np.array([1.0, 1.0, 1.0, 0.0])
    double = np.diag([1.0, 1.0, 1.0, 2.0])
    E, nu = youngs_modulus, poisson_ratio
    return np.asarray(((1.0 + nu) * double - nu * np.outer(trace, trace)) / E)
