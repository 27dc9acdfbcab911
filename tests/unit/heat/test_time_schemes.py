"""Schemes in time: orders, amplification of single modes, and the equations they stand for."""

import math

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from contactfem.heat.time_schemes import NAMES, scheme

TRANSIENT = [name for name in NAMES if name != "steady"]


def step(of, theta, t, dt, source, slope):
    """Solve the equations of one step of θ' + H(t, θ) = 0; return the stages."""
    stages = np.full(len(of.nodes), float(theta))
    for _ in range(50):
        inside = of.trial_start * theta + of.trial @ stages
        times = t + of.points * dt
        residual = of.rate @ stages + of.rate_start * theta + dt * of.test @ source(times, inside)
        tangent = of.rate + dt * (of.test * slope(times, inside)) @ of.trial
        change = np.linalg.solve(tangent, residual)
        stages = stages - change
        if np.abs(change).max() < 1e-15:
            return stages
    raise AssertionError("Newton's method did not converge")


def march(of, theta, end, steps, source, slope):
    dt = end / steps
    for n in range(steps):
        theta = float(of.end @ step(of, theta, n * dt, dt, source, slope))
    return theta


def cubic(t, z):
    return z**3


def cubic_slope(t, z):
    return 3.0 * z**2


def driven(t, z):
    return 2.0 * (z - np.sin(3.0 * t))


def driven_slope(t, z):
    return np.full_like(z, 2.0)


def driven_exact(t):
    """z' = -2 (z - sin 3t), z(0) = 1."""
    return (4.0 * np.sin(3.0 * t) - 6.0 * np.cos(3.0 * t) + 19.0 * np.exp(-2.0 * t)) / 13.0


CUBIC = (cubic, cubic_slope, 1.0 / math.sqrt(1.0 + 2.0 * 2.0))
DRIVEN = (driven, driven_slope, driven_exact(2.0))


@pytest.mark.parametrize("name", TRANSIENT)
@pytest.mark.parametrize("problem", [CUBIC, DRIVEN], ids=["nonlinear", "driven"])
def test_order_at_the_ends_of_steps(name, problem):
    of = scheme(name)
    source, slope, exact = problem
    coarse = 64 if of.order == 1 else 8 if of.order >= 6 else 16
    errors = [
        abs(march(of, 1.0, 2.0, steps, source, slope) - exact) for steps in (coarse, 2 * coarse)
    ]
    assert errors[1] > 5e-14  # above round-off, so that the rate means something
    assert math.log2(errors[0] / errors[1]) == pytest.approx(of.order, abs=0.5)


def amplification(of, z):
    """Factor of one step for θ' = λθ, z = λ dt."""
    system = of.rate - z * of.test @ of.trial
    return float(of.end @ np.linalg.solve(system, z * of.test @ of.trial_start - of.rate_start))


def pade(numerator, denominator, z):
    """Padé approximation of e^z with polynomials of the given degrees."""
    m, n = numerator, denominator

    def polynomial(a, b, sign):
        terms = [math.comb(a, j) * math.factorial(a + b - j) * sign**j for j in range(a + 1)]
        return Polynomial(np.array(terms) / math.factorial(a + b))(z)

    return polynomial(m, n, 1.0) / polynomial(n, m, -1.0)


@pytest.mark.parametrize("z", [-0.1, -3.0, -40.0, 0.5])
@pytest.mark.parametrize("name", TRANSIENT)
def test_amplification_is_a_pade_approximation(name, z):
    of = scheme(name)
    degree = int(name[3])
    numerator, denominator = (degree, degree + 1) if of.l_stable else (degree, degree)
    assert amplification(of, z) == pytest.approx(pade(numerator, denominator, z), rel=1e-12)


def test_pade_by_hand():
    assert pade(1, 1, -3.0) == pytest.approx((1.0 - 1.5) / (1.0 + 1.5))
    assert pade(1, 2, -3.0) == pytest.approx((1.0 - 1.0) / (1.0 + 2.0 + 1.5))
    assert pade(0, 1, -3.0) == pytest.approx(0.25)


@pytest.mark.parametrize("name", TRANSIENT)
def test_infinitely_fast_modes(name):
    of = scheme(name)
    limit = 0.0 if of.l_stable else (-1.0) ** int(name[3])
    assert amplification(of, -1e9) == pytest.approx(limit, abs=1e-6)
    decaying = [abs(amplification(of, -(10.0**e))) for e in np.linspace(-3, 6, 200)]
    assert max(decaying) < 1.0


def test_one_step_of_equation_27():
    """Linear decay z' = -3z with dt = 0.1: (1 - 0.15)/(1 + 0.15)."""
    of = scheme("cG(1)")
    after = march(of, 1.0, 0.1, 1, lambda t, z: 3.0 * z, lambda t, z: np.full_like(z, 3.0))
    assert after == pytest.approx(0.7391304348, abs=5e-11)
    third = 0.5 / math.sqrt(3.0)
    np.testing.assert_allclose(of.points, [0.5 - third, 0.5 + third], rtol=1e-15)
    np.testing.assert_allclose(of.test, [[0.5, 0.5]], rtol=1e-15)
    np.testing.assert_allclose(of.trial[:, 0], of.points, rtol=1e-15)
    np.testing.assert_allclose(of.trial_start, 1.0 - of.points, rtol=1e-15)


def test_dg0_is_backward_euler_and_dg1_has_radau_points():
    euler = scheme("dG(0)")
    assert (euler.points.tolist(), euler.test.tolist()) == ([1.0], [[1.0]])
    radau = scheme("dG(1)")
    np.testing.assert_allclose(radau.points, [1.0 / 3.0, 1.0], rtol=1e-15)
    np.testing.assert_allclose(radau.test, [[5 / 12, -1 / 12], [3 / 4, 1 / 4]], rtol=1e-14)


@pytest.mark.parametrize("name", TRANSIENT)
def test_equations_are_those_of_the_weak_form(name):
    """∫ ψ (θ' + dt H) dα (and the jump of dG) vanishes for every test function, H a polynomial."""
    of = scheme(name)
    continuous = name.startswith("c")
    degree = int(name[3]) - (1 if continuous else 0)  # of the tests
    rng = np.random.default_rng(7)
    h = Polynomial(rng.standard_normal(degree + 1))
    stages = np.linalg.solve(of.rate, -of.rate_start * 1.3 - of.test @ h(of.points))
    xs, ys = of.nodes, stages
    if continuous:
        xs, ys = np.insert(xs, 0, 0.0), np.insert(ys, 0, 1.3)
    theta = Polynomial(np.linalg.solve(np.vander(xs, increasing=True), ys))
    jump = theta(0.0) - 1.3
    for power in range(degree + 1):
        psi = Polynomial([0.0] * power + [1.0])
        weak = (psi * (theta.deriv() + h)).integ()(1.0) + psi(0.0) * jump
        assert weak == pytest.approx(0.0, abs=1e-11)


@pytest.mark.parametrize("name", TRANSIENT)
def test_last_equation_is_the_balance_of_the_step(name):
    of = scheme(name)
    assert of.nodes[-1] == 1.0
    assert of.end.tolist() == [0.0] * (len(of.nodes) - 1) + [1.0]
    exact_degree = len(of.points) * 2 - (1 if name.startswith("c") else 2)
    for power in range(exact_degree + 1):
        assert of.test[-1] @ of.points**power == pytest.approx(1.0 / (power + 1), rel=1e-13)


@pytest.mark.parametrize("name", TRANSIENT)
def test_values_and_slopes_inside_a_step(name):
    of = scheme(name)
    curve = Polynomial(np.arange(1.0, len(of.nodes) + 2.0))
    alpha = np.array([0.0, 0.37, 1.0])
    start, stages = of.values(alpha)
    np.testing.assert_allclose(
        start * curve(0.0) + stages @ curve(of.nodes), curve(alpha), rtol=1e-12
    )
    start, stages = of.slopes(alpha)
    slope = start * curve(0.0) + stages @ curve(of.nodes)
    np.testing.assert_allclose(slope, curve.deriv()(alpha), rtol=1e-11)


def test_slope_of_dg_is_the_rate_that_the_equation_says():
    """At the points of Radau's rule θ' = -H."""
    of = scheme("dG(2)")
    stages = step(of, 1.0, 0.2, 0.3, driven, driven_slope)
    start, weights = of.slopes(of.points)
    rate = (start * 1.0 + weights @ stages) / 0.3
    np.testing.assert_allclose(rate, -driven(0.2 + 0.3 * of.points, stages), rtol=1e-12)


def test_steady_forgets():
    of = scheme("steady")
    assert of.steady
    [found] = step(of, 17.0, 0.0, 0.5, driven, driven_slope)
    assert found == pytest.approx(math.sin(1.5), rel=1e-14)


def test_weights_cannot_be_changed_and_names_are_known():
    with pytest.raises(ValueError, match="read-only"):
        scheme("cG(1)").test[0, 0] = 1.0
    with pytest.raises(ValueError, match=r"no scheme 'cG\(9\)'; there are cG\(1\)"):
        scheme("cG(9)")
