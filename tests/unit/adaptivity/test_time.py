"""Time error indicator: its published numbers, and its effectivity on exp(-2t)."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from contactfem.adaptivity.recovery.time import recovered_rate, time_error


def crank_nicolson(rate, steps):
    """cG(1) for ż = -rate z from 1 on: values at the ends of steps."""
    factors = (1 - 0.5 * rate * steps) / (1 + 0.5 * rate * steps)
    return np.concatenate(([1.0], np.cumprod(factors)))


def indicated(z, steps, n):
    """Error of step n."""
    rates = np.diff(z) / steps
    return time_error((rates[n] - rates[n - 1]) ** 2, rates[n] ** 2, steps[n - 1], steps[n])


def true_error(z, steps, n, rate=2.0):
    start = steps[:n].sum()
    slope = (z[n + 1] - z[n]) / steps[n]
    square = quad(lambda t: (-rate * math.exp(-rate * t) - slope) ** 2, start, start + steps[n])
    return math.sqrt(square[0])


def test_unequal_steps():
    """h = 1, 2 and ż = 1, 2: √(2³/12)/1.5."""
    assert time_error(1.0, 4.0, 1.0, 2.0).error == pytest.approx(0.5443311, rel=1e-6)
    assert time_error(1.0, 4.0, 1.0, 2.0).norm_square == 8.0


def test_the_integral_of_the_recovered_rate():
    """Against quadrature of |ż* - ż_h|² over the newer and, exchanged, over the older step."""
    older, newer, rates = 0.3, 0.7, (1.5, -0.4)

    def square(start, end, rate):
        def integrand(t):
            a, b = recovered_rate(t, older, newer)
            return (a * rates[0] + b * rates[1] - rate) ** 2

        return quad(integrand, start, end)[0]

    change = (rates[1] - rates[0]) ** 2
    found = time_error(change, rates[1] ** 2, older, newer).error_square
    assert found == pytest.approx(square(0.0, newer, rates[1]), rel=1e-12)
    found = time_error(change, rates[0] ** 2, newer, older).error_square
    assert found == pytest.approx(square(-older, 0.0, rates[0]), rel=1e-12)


def test_recovered_rate_is_exact_for_parabolas():
    """z = t²: rates over (-a, 0) and (0, b) are -a and b, and ż* = 2 t."""
    for since in (-0.3, 0.0, 0.5):
        a, b = recovered_rate(since, 0.3, 0.5)
        assert a * -0.3 + b * 0.5 == pytest.approx(2 * since, abs=1e-15)


@pytest.mark.parametrize("h", [0.005, 0.002])
def test_effectivity_on_a_decay(h):
    steps = np.full(round(0.5 / h), h)
    z = crank_nicolson(2.0, steps)
    n = len(steps) - 1
    assert indicated(z, steps, n).error / true_error(z, steps, n) == pytest.approx(1.0, abs=0.01)


def test_effectivity_converges_and_is_not_that_of_integrals():
    """The defect of the effectivity falls as h; integrals (39) would leave 0.866."""
    defects = []
    for h in (0.02, 0.01, 0.005):
        steps = np.full(round(0.5 / h), h)
        z, n = crank_nicolson(2.0, steps), round(0.5 / h) - 1
        defects.append(abs(indicated(z, steps, n).error / true_error(z, steps, n) - 1.0))
    orders = np.log2(np.array(defects[:-1]) / defects[1:])
    assert orders.min() > 0.9


def test_effectivity_with_unequal_steps():
    h = 0.01 * np.array([1.0, 1.5, 0.7, 1.2, 1.0, 0.5])
    z = crank_nicolson(2.0, h)
    for n in range(1, len(h)):
        ratio = indicated(z, h, n).error / true_error(z, h, n)
        assert ratio == pytest.approx(1.0, abs=0.03)


def test_relative_error_falls_with_the_step():
    """‖e‖/‖v‖ is of order 1 in h: its exponent for step control."""
    etas = []
    for h in (0.02, 0.01):
        steps = np.full(round(0.5 / h), h)
        etas.append(indicated(crank_nicolson(2.0, steps), steps, len(steps) - 1).eta)
    assert math.log2(etas[0] / etas[1]) == pytest.approx(1.0, abs=0.02)


def test_a_body_at_rest_is_not_resolved():
    moving = time_error(1e-8, 1e-6, 0.1, 0.1)
    resting = time_error(1e-8, 1e-6, 0.1, 0.1, least_rate_square=1.0)
    assert moving.eta > 0.02
    assert resting.eta < 1e-3 * moving.eta * 1.1
    assert resting.error_square == moving.error_square
