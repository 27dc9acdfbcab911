"""New sizes: what they minimise and keep, and their limits."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize
from verification.p1_conduction import jittered

from contactfem.adaptivity.sizes import (
    SizeLimits,
    equal_error_sizes,
    goal,
    graded,
    predicted_cells,
    predicted_error,
    printed_sizes,
    size_field,
)
from contactfem.geometry.cells import cell_sizes, thicknesses
from contactfem.results.relative_error import RelativeError

FREE = SizeLimits(smallest=1e-9, largest=1e9, growth=1e9, cells=10**9, coarsening=1e9)


@pytest.fixture
def plate():
    return jittered((10, 10))


def spread(plate, seed=0):
    """Errors squared that vary by orders of magnitude."""
    return 10.0 ** np.random.default_rng(seed).uniform(-6, 0, len(plate.cells))


def test_sizes_of_regular_cells():
    triangle = np.array([[0.0, 0.0], [2.0, 0.0], [1.0, np.sqrt(3.0)]])
    assert cell_sizes(triangle, np.array([[0, 1, 2]]))[0] == pytest.approx(2.0, rel=1e-14)
    square = 3.0 * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    assert cell_sizes(square, np.array([[0, 1, 2, 3]]))[0] == pytest.approx(3.0, rel=1e-14)


def test_the_goal_is_the_tolerance():
    found = RelativeError(9.0, 91.0)
    square = goal(found, 0.1)
    assert RelativeError(square, 100.0 - square).eta == pytest.approx(0.1, rel=1e-14)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("rule", [equal_error_sizes, printed_sizes])
def test_both_rules_meet_the_goal(plate, rule, order):
    """Σ e² (h/h_K)^(2p) is the error of the new mesh."""
    h, errors = cell_sizes(plate.points, plate.cells), spread(plate)
    new = rule(h, errors, 1e-3, order)
    assert errors @ (new / h) ** (2 * order) == pytest.approx(1e-3, rel=1e-12)


@pytest.mark.parametrize("order", [1, 2])
def test_new_cells_have_equal_errors(plate, order):
    """Each of the (h_K/h)² cells in the place of K has the same share of what K has left."""
    h, errors = cell_sizes(plate.points, plate.cells), spread(plate)
    ratio = equal_error_sizes(h, errors, 1e-3, order) / h
    of_a_cell = errors * ratio ** (2 * order) / ratio**-2.0
    np.testing.assert_allclose(of_a_cell, of_a_cell[0], rtol=1e-11)
    printed = printed_sizes(h, errors, 1e-3, order) / h
    np.testing.assert_allclose(errors * printed ** (2 * order), 1e-3 / len(h), rtol=1e-11)
    assert (printed**-2.0).sum() > 1.2 * (ratio**-2.0).sum()


def test_no_other_sizes_have_fewer_cells():
    """Against a minimiser that knows nothing of the formula."""
    h, errors = np.array([1.0, 2.0, 0.5, 1.0]), np.array([1.0, 0.01, 0.2, 1e-3])
    found = equal_error_sizes(h, errors, 0.1, 1)
    best = minimize(
        lambda log: np.exp(-2.0 * log).sum(),
        np.zeros(4),
        constraints={"type": "eq", "fun": lambda log: errors @ np.exp(2.0 * log) - 0.1},
        options={"ftol": 1e-14, "maxiter": 500},
    )
    np.testing.assert_allclose(np.exp(best.x), found / h, rtol=1e-4)


def test_equal_errors_make_both_rules_agree(plate):
    h = cell_sizes(plate.points, plate.cells)
    errors = np.full(len(h), 1e-4)
    both = [rule(h, errors, 1e-3, 1) for rule in (equal_error_sizes, printed_sizes)]
    np.testing.assert_allclose(*both, rtol=1e-12)


def test_meshes_without_error_take_the_largest_size(plate):
    h = cell_sizes(plate.points, plate.cells)
    new = equal_error_sizes(h, np.zeros(len(h)), 1, 1)
    limits = SizeLimits(0.01, 0.3, 0.5, 10**6, coarsening=100.0)
    np.testing.assert_allclose(size_field(plate.points, plate.cells, h, new, limits), 0.3)


def test_the_field_keeps_sizes_and_the_number_of_cells(plate):
    """A uniform size is kept; present sizes give about the present number of cells."""
    h = cell_sizes(plate.points, plate.cells)
    field = size_field(plate.points, plate.cells, h, np.full(len(h), 0.07), FREE)
    np.testing.assert_allclose(field, 0.07, rtol=1e-14)
    assert predicted_cells(plate.points, plate.cells, field, FREE) == pytest.approx(
        4 / np.sqrt(3) / 0.07**2, rel=1e-12
    )
    field = size_field(plate.points, plate.cells, h, h, FREE)
    assert predicted_cells(plate.points, plate.cells, field, FREE) == pytest.approx(
        len(h), rel=0.05
    )


def test_flat_cells_count_by_their_length(plate):
    """Of the size 0.01 and ten times as long, but not longer than 0.05."""
    field = np.full(len(plate.points), 0.01)
    limits = replace(FREE, aspect=np.full(len(field), 10.0), longest=0.05)
    assert predicted_cells(plate.points, plate.cells, field, limits) == pytest.approx(
        4 / np.sqrt(3) / 0.01 / 0.05, rel=1e-12
    )
    assert limits.lengths(np.full(len(field), 0.2))[0] == 0.2


@pytest.mark.parametrize("length", [1.0, 7.0, 100.0])
def test_thicknesses_of_flat_cells(length):
    """An equilateral triangle of the edge h, drawn out along an edge, stays as thick."""
    triangle = np.array([[0.0, 0.0], [2.0, 0.0], [1.0, np.sqrt(3.0)]]) * [length, 1.0]
    assert thicknesses(triangle, np.array([[0, 1, 2]]))[0] == pytest.approx(2.0, rel=1e-13)
    square = 3.0 * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]) * [length, 1.0]
    assert thicknesses(square, np.array([[0, 1, 2, 3]]))[0] == pytest.approx(3.0, rel=1e-13)


def test_predictions_of_halved_sizes(plate):
    """Four times the cells, a quarter of the squared error, where sizes are uniform."""
    errors, h = spread(plate), cell_sizes(plate.points, plate.cells)
    fields = [np.full(len(plate.points), size) for size in (0.02, 0.01)]
    whole, half = (predicted_cells(plate.points, plate.cells, f, FREE) for f in fields)
    assert half == pytest.approx(4 * whole, rel=1e-13)
    whole, half = (predicted_error(plate.cells, h, f, errors, 1) for f in fields)
    assert half == pytest.approx(whole / 4, rel=1e-13)
    assert whole == pytest.approx(errors @ (0.02 / h) ** 2, rel=1e-13)


def test_gradation_is_the_largest_lipschitz_field_below(plate):
    """Against relaxation along the edges until nothing changes."""
    sizes = np.random.default_rng(2).uniform(0.01, 1.0, len(plate.points))
    found = graded(plate.points, plate.cells, sizes, 0.4)
    expected = sizes.copy()
    pairs = np.concatenate([plate.cells[:, [i, j]] for i in range(3) for j in range(3) if i != j])
    length = np.linalg.norm(plate.points[pairs[:, 0]] - plate.points[pairs[:, 1]], axis=1)
    for _ in range(100):
        np.minimum.at(expected, pairs[:, 0], expected[pairs[:, 1]] + 0.4 * length)
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    assert (found <= sizes).all()
    assert (found < 0.99 * sizes).any()
    steepest = ((found[pairs[:, 0]] - found[pairs[:, 1]]) / length).max()
    assert steepest == pytest.approx(0.4, rel=1e-9)


def test_limits_of_sizes(plate):
    h = cell_sizes(plate.points, plate.cells)
    limits = SizeLimits(0.02, 0.2, 5.0, 10**6, coarsening=1.5)
    wanted = np.where(np.arange(len(h)) % 2 == 0, 1e-6, 10.0)
    field = size_field(plate.points, plate.cells, h, wanted, limits)
    assert field.min() >= 0.02 * (1 - 1e-12)
    coarse = size_field(plate.points, plate.cells, h, np.full(len(h), 10.0), limits)
    assert coarse.max() <= min(0.2, 1.5 * h.max()) * (1 + 1e-12)
    assert coarse.max() > h.max()


def test_the_limit_of_cells_yields_to_nothing(plate):
    h = cell_sizes(plate.points, plate.cells)
    limits = SizeLimits(1e-4, 0.05, 0.3, 300)
    wanted = np.where(plate.points[plate.cells].mean(1)[:, 0] < 0.2, 1e-3, 1.0)
    field = size_field(plate.points, plate.cells, h, wanted, limits)
    count = predicted_cells(plate.points, plate.cells, field, limits)
    assert 200 < count <= 300
    pairs = plate.cells[:, :2]
    slope = np.abs(np.diff(field[pairs])[:, 0]) / np.linalg.norm(
        np.diff(plate.points[pairs], axis=1)[:, 0], axis=1
    )
    assert slope.max() <= 0.3 * (1 + 1e-9)
    left = plate.points[:, 0] < 0.1
    assert field[left].mean() < 0.7 * field[plate.points[:, 0] > 0.8].mean()
