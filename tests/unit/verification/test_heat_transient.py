"""Closed forms of heat that spreads in time: known numbers, and the equations they solve."""

import math

import numpy as np
import pytest

from contactfem.verification.heat_transient import EqualSlabs, HalfSpace, HalfSpaces, HeatedSlab


def heat_equation(theta, x, t, diffusivity, dx, dt):
    """Residual of θ_t = κ θ_xx by central differences, and the size of its terms."""
    rate = (theta(x, t + dt) - theta(x, t - dt)) / (2.0 * dt)
    second = (theta(x + dx, t) - 2.0 * theta(x, t) + theta(x - dx, t)) / dx**2
    return rate - diffusivity * second, np.abs(rate).max()


def slope(theta, x, t, dx):
    """One-sided derivative at x into the direction of dx, of third order."""
    values = [theta(np.array([x + n * dx]), t)[0] for n in range(4)]
    return (-11.0 * values[0] + 18.0 * values[1] - 9.0 * values[2] + 2.0 * values[3]) / (6.0 * dx)


SLABS = EqualSlabs(10.0, 0.2, 2.0, 0.15, 100.0)


@pytest.mark.parametrize(
    ("t", "jump", "mean"),
    [
        (10.0, 32.158542, 46.619486),
        (100.0, 11.645385, 35.103923),
        (500.0, 4.187666, 14.474980),
    ],
)
def test_equal_slabs(t, jump, mean):
    assert SLABS.jump(t) == pytest.approx(jump, abs=5.1e-7)
    assert SLABS.mean(t) == pytest.approx(mean, abs=5.1e-7)


def test_equal_slabs_solve_their_equations():
    x, t = np.array([1.0, 5.0, 9.0]), 60.0
    residual, size = heat_equation(SLABS.theta, x, t, 0.1, 1e-2, 1e-2)
    assert np.abs(residual).max() < 1e-5 * size
    assert slope(SLABS.theta, 0.0, t, 1e-2) == pytest.approx(0.0, abs=1e-6)
    out = -0.2 * slope(SLABS.theta, 10.0, t, -1e-2)
    assert out == pytest.approx(0.15 * SLABS.jump(t), rel=1e-5)
    lost = -2.0 * 10.0 * (SLABS.mean(t + 0.1) - SLABS.mean(t - 0.1)) / 0.2
    assert lost == pytest.approx(0.15 * SLABS.jump(t), rel=1e-6)
    early = EqualSlabs(10.0, 0.2, 2.0, 0.15, 100.0, terms=2000).theta([0.0, 5.0, 9.9], 1e-3)
    np.testing.assert_allclose(early, 50.0, atol=1e-3)


def test_equal_slabs_start_as_half_spaces():
    spaces = HalfSpaces(HalfSpace(0.2, 2.0, 50.0), HalfSpace(0.2, 2.0, -50.0), 0.15)
    depth = np.array([0.0, 0.3, 1.5])
    np.testing.assert_allclose(SLABS.theta(10.0 - depth, 5.0), spaces.theta_nonmortar(depth, 5.0))


RUBBER_ON_STEEL = HalfSpaces(HalfSpace(0.2, 2.0, 30.0), HalfSpace(50.0, 3.6), 0.5, 3.0)
OTHER_SHARE = HalfSpaces(HalfSpace(0.2, 2.0, -3.0), HalfSpace(0.6, 3.0, 8.0), 0.3, 1.2, 0.3)


@pytest.mark.parametrize(
    ("t", "nonmortar", "mortar"),
    [
        (0.1, 23.869454, 0.368785),
        (1.0, 16.689400, 0.879781),
        (10.0, 9.989933, 1.741168),
    ],
)
def test_half_spaces_of_different_bodies(t, nonmortar, mortar):
    assert RUBBER_ON_STEEL.theta_nonmortar(0.0, t) == pytest.approx(nonmortar, abs=5.1e-7)
    assert RUBBER_ON_STEEL.theta_mortar(0.0, t) == pytest.approx(mortar, abs=5.1e-7)


def test_fluxes_between_half_spaces():
    assert RUBBER_ON_STEEL.fluxes(1.0) == pytest.approx((-6.404810, 9.404810), abs=5.1e-7)


@pytest.mark.parametrize("h", [1e-3, 0.5, 100.0])
def test_equal_half_spaces_share_equally(h):
    spaces = HalfSpaces(HalfSpace(0.2, 2.0), HalfSpace(0.2, 2.0), h, 2.0)
    assert spaces.theta_nonmortar(0.0, 1.0) == pytest.approx(1.78412412, abs=5.1e-9)
    assert spaces.theta_mortar(0.0, 1.0) == pytest.approx(1.78412412, abs=5.1e-9)


def test_half_spaces_share_by_effusivity_in_the_end():
    first, second = RUBBER_ON_STEEL.nonmortar.effusivity, RUBBER_ON_STEEL.mortar.effusivity
    share = RUBBER_ON_STEEL.fluxes(1e14)[0] / 3.0
    assert share == pytest.approx(first / (first + second), rel=1e-4)
    assert round(share, 4) == 0.0450


@pytest.mark.parametrize("spaces", [RUBBER_ON_STEEL, OTHER_SHARE], ids=["halves", "shares"])
def test_half_spaces_solve_their_equations(spaces):
    t, dx = 2.0, 1e-3
    sides = [(spaces.nonmortar, spaces.theta_nonmortar), (spaces.mortar, spaces.theta_mortar)]
    for (body, theta), into in zip(sides, spaces.fluxes(t), strict=True):
        kappa = body.conductivity / body.heat_capacity
        x = np.array([0.1, 0.5, 2.0]) * math.sqrt(kappa * t)
        residual, size = heat_equation(theta, x, t, kappa, 1e-2 * math.sqrt(kappa), 1e-3)
        assert np.abs(residual).max() < 2e-5 * size
        flux = -body.conductivity * slope(theta, 0.0, t, dx * math.sqrt(kappa))
        assert flux == pytest.approx(into, rel=1e-5)
        assert theta(1e3 * math.sqrt(kappa), t) == pytest.approx(body.start)
        assert theta(1e-2 * math.sqrt(kappa), 1e-9) == pytest.approx(body.start)
    jump = spaces.theta_nonmortar(0.0, t) - spaces.theta_mortar(0.0, t)
    assert jump == pytest.approx(spaces.jump(t), rel=1e-12)
    through = spaces.conductance * spaces.jump(t)
    own = spaces.partition * spaces.dissipation
    assert spaces.fluxes(t) == pytest.approx((own - through, spaces.dissipation - own + through))


def test_heated_half_space():
    body = HalfSpace(0.2, 2.0, 5.0)
    surface = 5.0 + 2.0 * 0.7 * math.sqrt(3.0 / math.pi) / math.sqrt(0.4)
    assert body.heated(0.7, 0.0, 3.0) == pytest.approx(surface, rel=1e-14)
    depth = np.linspace(0.0, 8.0, 20001)
    stored = np.trapezoid(body.heated(0.7, depth, 3.0) - 5.0, depth) * 2.0
    assert stored == pytest.approx(0.7 * 3.0, rel=1e-6)


HEATED = HeatedSlab(0.1, 0.2, 2.0, 10.0)


@pytest.mark.parametrize(
    ("t", "surface", "back"),
    [
        (100.0, 1.78413123, 0.03942646),
        (500.0, 4.15937976, 1.67395357),
        (2000.0, 11.66666666, 9.16666667),
    ],
)
def test_heated_slab(t, surface, back):
    # the last of the printed numbers is cut off
    np.testing.assert_allclose(HEATED.theta([10.0, 0.0], t), [surface, back], rtol=0, atol=1e-8)


def test_heated_slab_solves_its_equations():
    x, t = np.array([1.0, 5.0, 9.0]), 150.0
    residual, size = heat_equation(HEATED.theta, x, t, 0.1, 1e-2, 1e-1)
    assert np.abs(residual).max() < 1e-5 * size
    assert 0.2 * slope(HEATED.theta, 10.0, t, -1e-2) == pytest.approx(0.1, rel=1e-5)
    assert slope(HEATED.theta, 0.0, t, 1e-2) == pytest.approx(0.0, abs=1e-8)
    np.testing.assert_allclose(HEATED.theta(x, 0.5)[0], 0.0, atol=1e-7)
    assert HEATED.theta(10.0, 1.0)[0] == pytest.approx(HalfSpace(0.2, 2.0).heated(0.1, 0.0, 1.0))
