"""New sizes of one problem's meshes, from the errors of their cells."""

from dataclasses import replace

import numpy as np
import pytest

from contactfem.adaptivity.mesh_decision import BodyCells, CellLimits, Lifetime, choose_meshes
from contactfem.adaptivity.policies import MeshPolicy
from contactfem.adaptivity.sizes import predicted_cells
from contactfem.geometry.cells import cell_sizes
from contactfem.results.relative_error import RelativeError

POLICY = MeshPolicy(tolerance=0.05)
LIMITS = CellLimits(None, None, 0.3, 100_000)
LASTING = Lifetime(0, 100.0, np.inf)


def square(name, n, error, corner=0.0):
    """Unit square of 2 n² triangles, each with the same error."""
    x = np.linspace(0.0, 1.0, n + 1)
    points = np.array([(corner + a, b) for b in x for a in x])
    first = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    lower = np.column_stack((first, first + 1, first + n + 2))
    upper = np.column_stack((first, first + n + 2, first + n + 1))
    cells = np.concatenate((lower, upper))
    errors = np.full(len(cells), error**2 / len(cells))
    return BodyCells(
        name, points, cells, cell_sizes(points, cells), errors, np.full(len(cells), np.inf)
    )


def whole(bodies, norm=1.0):
    return RelativeError(sum(float(body.errors.sum()) for body in bodies), norm**2)


def test_twice_the_error_halves_the_cells_sizes():
    """An even error of 8 % is brought to four fifths of 5 % by cells of half the size."""
    bodies = [square("one", 8, 0.08)]
    choice = choose_meshes(bodies, whole(bodies), LIMITS, POLICY, LASTING)
    assert choice.reason.startswith("an error of 7.97 % exceeds 5 %: 128 to about 50")
    h = cell_sizes(bodies[0].points, bodies[0].cells)[0]
    np.testing.assert_allclose(choice.sizes["one"], 0.5 * h, rtol=5e-3)


def test_a_body_that_may_not_change_leaves_less_to_the_others():
    """3 % of its own leave √(4² - 3²) % of 4 %."""
    free, kept = square("free", 8, 0.08), square("kept", 8, 0.03, 2.0)
    choice = choose_meshes([free], whole([free, kept]), LIMITS, POLICY, LASTING)
    h = cell_sizes(free.points, free.cells)[0]
    assert set(choice.sizes) == {"free"}
    left = np.sqrt(0.04**2 * (1 + 0.08**2 + 0.03**2) - 0.03**2)
    np.testing.assert_allclose(choice.sizes["free"], h * left / 0.08, rtol=1e-3)


def test_the_larger_error_gets_the_smaller_cells():
    bodies = [square("rough", 8, 0.08), square("smooth", 16, 0.005, 2.0)]
    sizes = choose_meshes(bodies, whole(bodies), LIMITS, POLICY, LASTING).sizes
    assert sizes["rough"].max() < 0.07 < sizes["smooth"].min() == 1.0 / 8  # the largest allowed


def test_cells_are_as_small_as_asked_for():
    """Of 0.02 along the lower side, whatever errors want, and growing from there."""
    body = square("one", 8, 0.08)
    lower = body.points[body.cells][:, :, 1].min(axis=1) == 0.0
    body = replace(body, largest=np.where(lower, 0.02, np.inf))
    sizes = choose_meshes([body], whole([body]), LIMITS, POLICY, LASTING).sizes["one"]
    y = body.points[:, 1]
    np.testing.assert_allclose(sizes[y == 0.0], 0.02, rtol=1e-5)
    assert sizes[y >= 0.25].min() > 0.06


def test_the_number_of_cells_is_kept_by_all_meshes_together():
    bodies = [square("one", 8, 0.4), square("two", 8, 0.2, 2.0)]
    limits = CellLimits(None, None, 0.3, 1000)
    sizes = choose_meshes(bodies, whole(bodies), limits, POLICY, LASTING).sizes
    count = sum(predicted_cells(b.points, b.cells, sizes[b.name], limits.of(b)) for b in bodies)
    assert count == pytest.approx(1000, rel=0.01)


@pytest.mark.parametrize(
    "limits", [CellLimits(None, None, 0.3, 140), CellLimits(0.125, None, 0.3, 10**6)]
)
def test_limits_that_bind_keep_a_mesh_that_would_be_a_little_better(limits):
    """An error of 40 % may not become much less with 128 cells of the size 0.134."""
    bodies = [square("one", 8, 0.4)]
    choice = choose_meshes(bodies, whole(bodies), limits, POLICY, LASTING)
    assert not choice.sizes
    assert "the limits allow no mesh with less than 3" in choice.reason


@pytest.mark.parametrize(
    ("error", "lifetime", "reason"),
    [
        (0.045, LASTING, "would save"),  # hardly any cell
        (0.01, Lifetime(0, 5.0, np.inf), "would save"),  # for five steps only
        (0.04, Lifetime(1, 100.0, np.inf), "is within the tolerance"),  # was just made
        (0.08, Lifetime(3, 100.0, np.inf), "after 3 new meshes in this step"),
    ],
)
def test_meshes_that_stay(error, lifetime, reason):
    bodies = [square("one", 16, error)]
    choice = choose_meshes(bodies, whole(bodies), LIMITS, POLICY, lifetime)
    assert not choice.sizes
    assert reason in choice.reason


def test_much_too_fine_a_mesh_is_replaced():
    bodies = [square("one", 32, 0.005)]
    choice = choose_meshes(bodies, whole(bodies), LIMITS, POLICY, LASTING)
    assert choice.sizes
    assert "saves" in choice.reason


def test_no_mesh_may_change():
    choice = choose_meshes([], RelativeError(1.0, 1.0), LIMITS, POLICY, LASTING)
    assert not choice.sizes
    assert choice.reason == "no mesh may change"
