"""Recovery under conditions, against the minimisation problem that it solves."""

import numpy as np
import pytest
from verification.p1_conduction import jittered

from contactfem.adaptivity.recovery.constraints import (
    ConstraintRows,
    constrained,
    expansion,
    heat_flow_rows,
    traction_rows,
    with_conditions,
)
from contactfem.adaptivity.recovery.patches import patches


@pytest.fixture
def plate():
    return jittered((9, 7))


def around(plate, vertex, size):
    """P of the samples around a vertex, and the cells."""
    cells = np.flatnonzero((plate.cells == vertex).any(1))
    offset = plate.points[plate.cells[cells]].mean(1) - plate.points[vertex]
    return np.column_stack((np.ones(len(cells)), offset / size)), cells


@pytest.mark.parametrize("penalty", [0.3, 10.0])
def test_two_patches_are_the_minimum_of_the_penalised_sum(plate, penalty):
    """Dense least squares of all samples and of the condition with the root of its weight."""
    samples = np.random.default_rng(0).normal(size=(len(plate.cells), 2))
    fits = patches(plate.points, plate.cells)
    a = fits.fit(samples)
    inner = np.flatnonzero((np.abs(plate.points - 0.5) < 0.3).all(1))
    pair = inner[[0, -1]]
    x = plate.points[pair[:1]] + 0.01
    A, B, target = (np.array([[[0.6, 0.8]]]), np.array([[[-1.0, 0.5]]]), np.array([[0.7]]))
    sides = [expansion(fits, a, pair[i : i + 1], x) for i in (0, 1)]
    found = constrained(sides, (A, B), target, penalty)
    rows, right = [], []
    for i, vertex in enumerate(pair):
        P, cells = around(plate, vertex, fits.sizes[vertex])
        for c in (0, 1):
            block = np.zeros((len(cells), 12))
            block[:, 6 * i + np.array([c, c + 2, c + 4])] = P
            rows.append(block)
            right.append(samples[cells, c])
    condition = np.concatenate(
        [np.outer(side.basis[0], M[0, 0]).ravel() for side, M in zip(sides, (A, B), strict=True)]
    )
    rows.append(np.sqrt(penalty) * condition[None])
    right.append(np.sqrt(penalty) * target[0])
    expected = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0]
    result = np.concatenate([side.coefficients[0].ravel() for side in found])
    np.testing.assert_allclose(result, expected, atol=1e-12)


def test_known_heat_flow_is_met_and_right_polynomials_stay(plate):
    fits = patches(plate.points, plate.cells)
    edge = plate.at_edge(1, 0.0)
    normals = np.tile([0.0, -1.0], (len(edge), 1))
    slopes = np.array([[1.0, 2.0], [-3.0, 0.5]])
    samples = plate.points[plate.cells].mean(1) @ slopes
    exact = plate.points @ slopes
    flow = (exact[edge] * normals).sum(1)
    known = ConstraintRows(edge, heat_flow_rows(normals)[:, 0], flow)
    a = with_conditions(fits, fits.fit(samples), known)
    assert np.abs(a[:, 0] - exact).max() < 1e-12
    noisy = samples + 0.1 * np.random.default_rng(2).normal(size=samples.shape)
    before = fits.fit(noisy)
    after = with_conditions(fits, before, known)
    assert np.abs((before[edge, 0] * normals).sum(1) - flow).max() > 0.01
    assert np.abs((after[edge, 0] * normals).sum(1) - flow).max() < 1e-7
    others = np.setdiff1d(np.arange(len(exact)), edge)
    np.testing.assert_array_equal(after[others], before[others])


def test_both_edges_of_a_corner_count(plate):
    """A corner free of traction on two sides has no stress but zz, whatever the order of rows."""
    some = np.random.default_rng(1).permutation(len(plate.points))
    fits = patches(plate.points, plate.cells, some)
    corner = int(np.argmin(plate.points.sum(1)))
    other = int(plate.at_edge(1, 0.0)[3])
    normals = np.array([[0.0, -1.0], [0.0, -1.0], [-1.0, 0.0]])
    rows = traction_rows(normals).reshape(-1, 4)
    known = ConstraintRows(np.repeat([corner, other, corner], 2), rows, np.zeros(6))
    a = fits.fit(np.random.default_rng(2).normal(size=(len(plate.cells), 4)))
    values = with_conditions(fits, a, known)[:, 0]
    at = {vertex: values[np.flatnonzero(some == vertex)[0]] for vertex in (corner, other)}
    assert np.abs(at[corner][[0, 1, 3]]).max() < 1e-6
    assert np.abs(at[other][[1, 3]]).max() < 1e-6
    assert abs(at[other][0]) > 1e-3


def test_conditions_at_other_vertices_are_left_out(plate):
    fits = patches(plate.points, plate.cells, np.array([3, 11]))
    a = fits.fit(np.ones((len(plate.cells), 2)))
    known = ConstraintRows(
        np.array([5, 11]), np.array([[1.0, 0.0], [1.0, 0.0]]), np.array([9.0, 4.0])
    )
    values = with_conditions(fits, a, known)[:, 0]
    np.testing.assert_allclose(values, [[1.0, 1.0], [4.0, 1.0]], atol=1e-6)


def test_traction_rows_are_those_of_the_stress_tensor():
    rng = np.random.default_rng(5)
    angle, stress = rng.uniform(0, 6, 4), rng.normal(size=(4, 4))
    n = np.column_stack((np.cos(angle), np.sin(angle)))
    t = np.column_stack((n[:, 1], -n[:, 0]))
    sigma = stress[:, [0, 3, 3, 1]].reshape(4, 2, 2)
    traction = np.einsum("kij,kj->ki", sigma, n)
    expected = np.column_stack(((traction * n).sum(1), (traction * t).sum(1)))
    found = np.einsum("krc,kc->kr", traction_rows(n), stress)
    np.testing.assert_allclose(found, expected, atol=1e-14)
