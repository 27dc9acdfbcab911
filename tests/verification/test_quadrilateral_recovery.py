"""Recovered heat fluxes on bilinear quadrilaterals, whose discrete fluxes vary within the cells."""

import numpy as np
import pytest
import scipy.sparse as sp
from verification.p1_conduction import solve

from contactfem.adaptivity.recovery.norms import quadrature, squared_errors, squared_norms
from contactfem.adaptivity.recovery.patches import patches

GAUSS = (0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0))


def grid(n, distortion):
    """Smoothly distorted unit square: the same map on all refinements."""
    i, j = np.meshgrid(np.arange(n + 1) / n, np.arange(n + 1) / n)
    bump = distortion * np.sin(np.pi * i) * np.sin(np.pi * j)
    points = np.stack((i + bump, j - 0.7 * bump), -1).reshape(-1, 2)
    first = (np.arange(n) + (n + 1) * np.arange(n)[:, None]).ravel()
    return points, first[:, None] + [0, 1, n + 1, n + 2]


def slopes(points, cells, s, t):
    """Gradients of the shape functions at a point of all cells, (m, 4, 2), and Jacobians (m,)."""
    local = np.array([[t - 1, s - 1], [1 - t, -s], [-t, 1 - s], [t, s]])
    jacobian = np.einsum("mai,aj->mij", points[cells], local)
    return local @ np.linalg.inv(jacobian), np.linalg.det(jacobian)


def heated(points, cells):
    """T_h of T = e^x sin y with exact values on the boundary."""
    n = len(points)
    matrix = sp.csr_matrix((n, n))
    for s in GAUSS:
        for t in GAUSS:
            B, J = slopes(points, cells, s, t)
            local = 0.25 * J[:, None, None] * B @ B.transpose(0, 2, 1)
            entries = (cells.repeat(4, 1).ravel(), np.tile(cells, (1, 4)).ravel())
            matrix = matrix + sp.csr_matrix((local.ravel(), entries), (n, n))
    x, y = points.T
    outside = np.flatnonzero((np.minimum(points, 1 - points) < 1e-9).any(1))
    exact = np.exp(x) * np.sin(y)
    return solve(matrix, np.zeros(n), outside, exact[outside])


def flux(x):
    return -np.exp(x[..., :1]) * np.stack((np.sin(x[..., 1]), np.cos(x[..., 1])), -1)


@pytest.mark.parametrize("distortion", [0.0, 0.1])
def test_effectivity_and_order(distortion):
    errors = []
    for n in (8, 16, 32):
        points, cells = grid(n, distortion)
        T = heated(points, cells)[cells]
        middle = -np.einsum("mai,ma->mi", slopes(points, cells, 0.5, 0.5)[0], T)
        at_points = np.stack(
            [
                -np.einsum("mai,ma->mi", slopes(points, cells, s, t)[0], T)
                for s in GAUSS
                for t in GAUSS
            ],
            axis=1,
        )
        rule = quadrature(points, cells)
        nodal = patches(points, cells).fit(middle)[:, 0]
        estimated = squared_errors(rule, cells, nodal, at_points).sum()
        true = squared_norms(rule, flux(rule.x) - at_points).sum()
        inner = (np.abs(points - 0.5) < 0.3).all(1)
        off = np.abs(nodal - flux(points))[inner].max()
        assert 0.9 < np.sqrt(estimated / true) < 1.1
        errors.append([off, np.sqrt(true)])
    orders = np.log2(np.array(errors[0]) / errors[-1]) / 2
    assert orders[0] > 1.8
    assert orders[1] == pytest.approx(1.0, abs=0.05)
