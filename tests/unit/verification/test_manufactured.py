"""Manufactured solutions: known numbers, and the equations they solve, by finite differences."""

import math
from dataclasses import replace

import numpy as np
import pytest

from contactfem.verification.homogeneous import NeoHooke
from contactfem.verification.manufactured import (
    FiniteStrain,
    MovingGaussian,
    SuddenSwitch,
    harmonic_bodies,
)

SOLID = FiniteStrain(333.0, 35.0, 1e-4, 0.2, 2.0, (0.1, 0.08), 50.0)
POINT = np.array([[0.3], [0.4]])
POINTS = np.random.default_rng(1).uniform(0.1, 0.9, (3, 5))


def central(function, x, step=1e-4):
    """Derivatives of a field over x and y by central differences of fourth order (..., 2, n)."""
    found = []
    for j in range(2):
        e = np.zeros((len(x), 1))
        e[j] = step
        near = function(x + e) - function(x - e)
        far = function(x + 2.0 * e) - function(x - 2.0 * e)
        found.append((8.0 * near - far) / (12.0 * step))
    return np.stack(found, axis=-2)


def test_finite_strain():
    P, Q = SOLID.stress(POINT)[:, :, 0], SOLID.heat_flux(POINT)[:, 0]
    np.testing.assert_allclose(P[0], [59.853107, -1.0296119], rtol=0, atol=5.1e-7)
    np.testing.assert_allclose(P[1], [0.0676240, 59.254878], rtol=0, atol=5.1e-7)
    np.testing.assert_allclose(Q, [-17.3932859, -10.5525993], rtol=0, atol=5.1e-8)
    np.testing.assert_allclose(
        SOLID.body_force(POINT)[:, 0], [197.199694, 250.403795], rtol=0, atol=5.1e-7
    )
    assert SOLID.heat_source(POINT)[0] == pytest.approx(128.694200, abs=5.1e-7)


@pytest.mark.parametrize("side", [1.0, 2.5])
def test_finite_strain_is_consistent(side):
    """F, Grad θ, P and Q against differences and against the law of homogeneous states."""
    solid = replace(SOLID, rate=0.7, side=side)
    x, t = side * POINTS, 0.4
    F, grad, theta = (
        solid.deformation_gradient(x),
        solid.temperature_gradient(x, t),
        solid.theta(x, t),
    )
    np.testing.assert_allclose(
        F, central(solid.displacement, x) + np.eye(2)[:, :, None], atol=1e-10
    )
    np.testing.assert_allclose(grad, central(lambda y: solid.theta(y, t), x), rtol=1e-8, atol=1e-8)
    for n in range(x.shape[1]):
        whole = np.eye(3)
        whole[:2, :2] = F[:, :, n]
        J, inverse = np.linalg.det(whole), np.linalg.inv(whole)
        sigma = NeoHooke(333.0, 35.0, 1e-4, theta[n]).cauchy_stress(whole)
        P = J * sigma @ inverse.T
        np.testing.assert_allclose(solid.stress(x, t)[:, :, n], P[:2, :2], rtol=1e-11)
        spatial = -0.2 * inverse.T @ np.append(grad[:, n], 0.0)  # Fourier's law where it has moved
        np.testing.assert_allclose(solid.heat_flux(x, t)[:, n], (J * inverse @ spatial)[:2])


@pytest.mark.parametrize("rate", [0.0, -1.5])
def test_finite_strain_solves_its_equations(rate):
    solid, t = replace(SOLID, rate=rate), 0.3
    div_P = np.einsum("ijjn->in", central(lambda y: solid.stress(y, t), POINTS))
    np.testing.assert_allclose(solid.body_force(POINTS, t), -div_P, rtol=1e-8)
    div_Q = np.einsum("jjn->n", central(lambda y: solid.heat_flux(y, t), POINTS))
    stored = 2.0 * (solid.theta(POINTS, t + 1e-4) - solid.theta(POINTS, t - 1e-4)) / 2e-4
    np.testing.assert_allclose(solid.heat_source(POINTS, t), stored + div_Q, rtol=1e-7, atol=1e-6)


SPOT = MovingGaussian(0.2, 2.0)


def test_moving_gaussian():
    x = np.array([[0.6], [0.55]])
    assert SPOT.theta(x, 0.13)[0] == pytest.approx(10.489002, abs=5.1e-7)
    assert SPOT.source(x, 0.13)[0] == pytest.approx(-1307.81283, abs=5.1e-6)
    gradient = SPOT.gradient(x, 0.13)[:, 0]
    np.testing.assert_allclose(gradient, [149.230759, 277.417651], rtol=0, atol=5.1e-7)


def test_moving_gaussian_goes_round_in_one_second():
    np.testing.assert_allclose(SPOT.spot(0.0), [0.75, 0.5])
    np.testing.assert_allclose(SPOT.spot(0.25), [0.5, 0.75])
    np.testing.assert_allclose(SPOT.theta(SPOT.spot(0.4)[:, None], 0.4), 100.0)


@pytest.mark.parametrize(
    "solution",
    [SPOT, SuddenSwitch(0.2, 2.0, 7.0), SuddenSwitch(0.5, 3.0, duration=0.1, side=1.5)],
    ids=["spot", "switch", "slow switch"],
)
@pytest.mark.parametrize("t", [0.1, 0.49, 0.505])
def test_sources_solve_the_heat_equation(solution, t):
    def theta(x):
        return solution.theta(x, t)

    gradient = central(theta, POINTS)
    size = np.abs(gradient).max()
    np.testing.assert_allclose(solution.gradient(POINTS, t), gradient, rtol=1e-7, atol=1e-8 * size)
    laplacian = np.einsum("jjn->n", central(lambda x: solution.gradient(x, t), POINTS))
    dt = 1e-5
    rate = (solution.theta(POINTS, t + dt) - solution.theta(POINTS, t - dt)) / (2.0 * dt)
    source = solution.heat_capacity * rate - solution.conductivity * laplacian
    tolerance = 1e-6 * np.abs(source).max()
    np.testing.assert_allclose(solution.source(POINTS, t), source, rtol=1e-6, atol=tolerance)


def test_sudden_switch_is_sudden():
    switch = SuddenSwitch(0.2, 2.0)
    middle = np.array([[0.5], [0.5]])
    values = [switch.theta(middle, t)[0] for t in (0.4, 0.5, 0.52, 0.6)]
    assert values == pytest.approx([-1.0, 0.0, math.tanh(1.0), 1.0], abs=1e-4)


def test_harmonic_bodies():
    below, above = harmonic_bodies((0.2, 50.0), 0.5, 3.0)
    x = np.array([[0.2], [-0.1]])
    assert below.theta(x)[0] == pytest.approx(0.78916254, abs=5.1e-9)
    np.testing.assert_allclose(below.flux(x)[:, 0], [0.36025280, -0.49584545], rtol=0, atol=5.1e-9)
    x = np.array([[0.2], [0.1]])
    assert above.theta(x)[0] == pytest.approx(0.00812887, abs=5.1e-9)
    np.testing.assert_allclose(above.flux(x)[:, 0], [0.92770699, 1.27687912], rtol=0, atol=5.1e-9)


@pytest.mark.parametrize("partition", [0.0, 0.5, 0.8])
def test_harmonic_bodies_solve_their_equations(partition):
    below, above = harmonic_bodies((0.3, 2.0), 0.7, 3.0, partition, wave_number=1.7)
    edge = np.array([[0.1, 0.4, 0.9], [0.0, 0.0, 0.0]])
    d = 3.0 * np.cos(1.7 * edge[0])
    through = 0.7 * (below.theta(edge) - above.theta(edge))
    np.testing.assert_allclose(below.flux(edge)[1], through - partition * d)
    np.testing.assert_allclose(above.flux(edge)[1], through + (1.0 - partition) * d)
    for body, x in [(below, POINTS - 1.0), (above, POINTS)]:
        np.testing.assert_allclose(
            body.flux(x), -body.conductivity * central(body.theta, x), rtol=1e-8, atol=1e-9
        )
        divergence = np.einsum("jjn->n", central(body.flux, x))
        np.testing.assert_allclose(divergence, 0.0, atol=1e-8)
