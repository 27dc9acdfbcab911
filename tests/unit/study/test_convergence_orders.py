"""Observed orders and slopes of known curves."""

import math

import numpy as np
import pytest

from contactfem.study.convergence_orders import observed_orders, relative_distance, slope

NAN = math.nan


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0])
def test_orders_of_a_power(order: float) -> None:
    factors = [1.0, 2.0, 4.0, 12.0]
    errors = [3.0 * f**-order for f in factors]
    found = observed_orders(factors, errors)
    assert math.isnan(found[0])
    assert found[1:] == pytest.approx([order] * 3, rel=1e-13)
    assert slope(factors, errors) == pytest.approx(-order, rel=1e-13)


def test_orders_skip_what_is_not_known() -> None:
    found = observed_orders([1, 2, 4, 8, 16], [1.0, NAN, 1 / 16, 0.0, 1 / 64])
    assert [math.isnan(order) for order in found] == [True, True, False, True, False]
    assert found[2] == pytest.approx(2.0)
    assert found[4] == pytest.approx(1.0)


def test_slope_is_that_of_least_squares() -> None:
    rng = np.random.default_rng(0)
    costs = np.exp(rng.uniform(0, 5, 9))
    errors = np.exp(rng.uniform(-5, 0, 9))
    expected = np.polyfit(np.log(costs), np.log(errors), 1)[0]
    assert slope([*costs, 5.0, 0.0], [*errors, NAN, 1.0]) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("errors", [[], [1.0], [NAN, 1.0], [0.0, 1.0]])
def test_no_slope_through_one_point(errors: list[float]) -> None:
    assert math.isnan(slope([2.0, 3.0][: len(errors)], errors))


def test_no_slope_over_one_cost() -> None:
    assert math.isnan(slope([2.0, 2.0], [1.0, 0.5]))


def test_relative_distance() -> None:
    assert relative_distance(9.0, -10.0) == pytest.approx(1.9)
    assert relative_distance(-0.5, 0.0) == 0.5
