"""Norms over cells, exact for what they claim."""

import math

import numpy as np
import pytest
from verification.p1_conduction import jittered

from contactfem.adaptivity.recovery.norms import (
    around_axis,
    elastic_compliance,
    quadrature,
    relative_error,
    squared_errors,
    squared_norms,
)
from contactfem.results.relative_error import RelativeError, error_ratio

SQUARE = np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 3.0], [2.0, 3.0]])
QUAD, TRIANGLES = np.array([[0, 1, 2, 3]]), np.array([[0, 1, 2], [1, 3, 2]])


@pytest.mark.parametrize("cells", [QUAD, TRIANGLES], ids=["quadrilateral", "triangles"])
def test_linear_minus_constant_is_integrated_exactly(cells):
    """∫ (x - 1/2)² + (2 y + x - 1)² over (0, 2) x (0, 3), by hand: 3.5 + 74."""
    x, y = SQUARE.T
    recovered = np.column_stack((x, 2 * y + x))
    discrete = np.tile([0.5, 1.0], (len(cells), 1))
    rule = quadrature(SQUARE, cells)
    assert rule.weights.sum() == pytest.approx(6.0, rel=1e-14)
    total = squared_errors(rule, cells, recovered, discrete).sum()
    assert total == pytest.approx(3.5 + 74.0, rel=1e-14)


def test_bilinear_fields_and_values_at_points():
    """∫ (x y)² over (0, 2) x (0, 3) = 8/3 · 9, as error against 0 and as norm."""
    rule = quadrature(SQUARE, QUAD)
    x, y = SQUARE.T
    error = squared_errors(rule, QUAD, (x * y)[:, None], np.zeros((1, 1)))
    assert error[0] == pytest.approx(24.0, rel=1e-14)
    at_points = (rule.x[..., :1] * rule.x[..., 1:]) * 1.0
    assert squared_norms(rule, at_points)[0] == pytest.approx(24.0, rel=1e-14)
    nothing = squared_errors(rule, QUAD, (x * y)[:, None], at_points)
    assert nothing[0] == pytest.approx(0.0, abs=1e-25)


def test_a_distorted_quadrilateral_has_its_area_and_centroid():
    points = np.array([[0.0, 0.0], [2.0, 0.2], [0.1, 1.0], [1.5, 1.8]])
    rule = quadrature(points, QUAD)
    triangles = quadrature(points, TRIANGLES)
    assert rule.weights.sum() == pytest.approx(triangles.weights.sum(), rel=1e-14)
    moment = [(r.weights[..., None] * r.x).sum((0, 1)) for r in (rule, triangles)]
    np.testing.assert_allclose(*moment, rtol=1e-14)


def test_revolution_has_the_volume_of_pappus():
    rule = around_axis(quadrature(SQUARE + np.array([1.0, 0.0]), TRIANGLES))
    assert rule.weights.sum() == pytest.approx(2 * math.pi * 2.0 * 6.0, rel=1e-14)


def test_metrics_of_the_whole_and_of_cells_agree():
    plate = jittered((4, 4))
    rng = np.random.default_rng(0)
    field = rng.normal(size=(len(plate.cells), 2))
    rule = quadrature(plate.points, plate.cells)
    metric = np.array([[2.0, 0.5], [0.5, 1.0]])
    by_cell = np.broadcast_to(metric, (len(plate.cells), 2, 2))
    one, two = squared_norms(rule, field, metric), squared_norms(rule, field, by_cell)
    np.testing.assert_allclose(one, two, rtol=1e-14)
    expected = np.einsum("mi,ij,mj->m", field, metric, field) * plate.shapes()[1]
    np.testing.assert_allclose(one, expected, rtol=1e-13)


def test_compliance_gives_the_energy_of_hookes_law():
    """σ:ε with σ = 2 μ ε + λ tr ε, for a strain with shear."""
    E, nu = 210.0, 0.3
    mu, lame = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
    strain = np.array([[1.0, 0.4, 0], [0.4, -0.3, 0], [0, 0, 0.2]]) * 1e-3
    sigma = 2 * mu * strain + lame * np.trace(strain) * np.eye(3)
    tau = np.array([sigma[0, 0], sigma[1, 1], sigma[2, 2], sigma[0, 1]])
    assert tau @ elastic_compliance(E, nu) @ tau == pytest.approx((sigma * strain).sum(), rel=1e-13)


def test_relative_errors_with_and_without_the_root():
    """15 % of squares are 38.7 % of norms."""
    found = RelativeError(0.15, 0.85)
    assert found.eta_printed == pytest.approx(0.15, rel=1e-14)
    assert found.eta == pytest.approx(0.3872983346, rel=1e-9)
    assert error_ratio(found.eta) == pytest.approx(math.sqrt(0.15 / 0.85), rel=1e-14)
    assert error_ratio(1.0) == math.inf
    assert RelativeError(0.0, 0.0).eta == 0.0


def test_squares_of_bodies_add_up():
    parts = [relative_error(np.array([1.0, 2.0]), np.array([5.0])), RelativeError(1.0, 3.0)]
    total = parts[0] + parts[1]
    assert (total.error_square, total.norm_square, total.error) == (4.0, 8.0, 2.0)
