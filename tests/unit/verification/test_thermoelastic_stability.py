"""Barber's rod and the isothermal split: known numbers, and what independent computations say."""

import math

import numpy as np
import pytest
from scipy.linalg import solve

from contactfem.laws.conductance import Constant, PowerLaw
from contactfem.verification.thermoelastic_stability import (
    BarberRod,
    IsothermalSplit,
    barber_growth,
)


def test_barber_growth_of_the_linear_rod():
    assert barber_growth(1.0, 4.0 * 0.96) == pytest.approx(-0.16014357, abs=5.1e-9)
    assert barber_growth(1.0, 4.0 * 1.02) == pytest.approx(0.07996461, abs=5.1e-9)
    assert barber_growth(1.0, 4.0) == 0.0
    with pytest.raises(ValueError, match="it must be >= 0"):
        barber_growth(1.0, -1.0)


def test_barber_growth_without_coupling():
    """Rod with a fixed temperature at one end: insulated or cooled at the other."""
    assert barber_growth(0.0, 0.0) == pytest.approx(-0.25 * math.pi**2, rel=1e-12)
    assert barber_growth(1e9, 0.0) == pytest.approx(-(math.pi**2), rel=1e-8)


def largest_eigenvalue(biot, coupling, cells):
    """The same from linear finite elements."""
    h = 1.0 / cells
    mass = h / 6.0 * (4.0 * np.eye(cells) + np.eye(cells, k=1) + np.eye(cells, k=-1))
    conduction = (2.0 * np.eye(cells) - np.eye(cells, k=1) - np.eye(cells, k=-1)) / h
    mass[-1, -1], conduction[-1, -1] = h / 3.0, 1.0 / h + biot
    conduction[-1] -= coupling * np.append(np.full(cells - 1, h), 0.5 * h)
    return np.linalg.eigvals(solve(mass, -conduction)).real.max()


@pytest.mark.parametrize(
    ("biot", "coupling"), [(0.4, 8.6), (7.0, 3.9), (0.3, 0.0), (2.0, 6.0001), (1.0, 60.0)]
)
def test_barber_growth_against_finite_elements(biot, coupling):
    coarse, fine = (largest_eigenvalue(biot, coupling, cells) for cells in (100, 200))
    extrapolated = fine + (fine - coarse) / 3.0
    assert barber_growth(biot, coupling) == pytest.approx(extrapolated, rel=1e-5, abs=1e-8)


ROD = BarberRod(10.0, 1000.0, 1e-4, 1.0, 2.0, 200.0, -2.0, PowerLaw(40.0, 100.0, 1.5))


def test_steady_states_of_barbers_rod():
    free, unstable, stable = ROD.steady_states()
    assert (free.pressure, free.surface) == (0.0, 0.0)
    assert free.growth == pytest.approx(-0.25 * math.pi**2 * 0.005)
    assert unstable.pressure == pytest.approx(1.07066619, abs=5.1e-9)
    assert unstable.surface == pytest.approx(61.413324, abs=5.1e-7)
    assert unstable.biot == pytest.approx(0.443140, abs=5.1e-7)
    assert unstable.coupling == pytest.approx(8.6040, abs=5.1e-5)
    assert 2.0 * (1.0 + unstable.biot) == pytest.approx(2.8863, abs=5.1e-5)
    assert unstable.growth / ROD.rate == pytest.approx(6.0747, abs=5.1e-5)
    assert unstable.growth == pytest.approx(0.030373, abs=5.1e-7)
    assert stable.pressure == pytest.approx(6.75304857, abs=5.1e-9)
    assert stable.surface == pytest.approx(175.060971, abs=5.1e-7)
    assert stable.biot == pytest.approx(7.01956, abs=5.1e-6)
    assert stable.coupling == pytest.approx(3.8885, abs=5.1e-5)
    assert stable.growth / ROD.rate == pytest.approx(-5.8609, abs=5.1e-5)


def test_steady_states_of_barbers_rod_balance():
    for state in ROD.steady_states()[1:]:
        h = 40.0 * (state.pressure / 100.0) ** 1.5
        assert h * (200.0 - state.surface) == pytest.approx(state.surface / 10.0, rel=1e-12)
        assert -2.0 + 0.1 * 0.5 * state.surface == pytest.approx(state.pressure, rel=1e-12)


def test_a_pressed_rod_with_a_constant_conductance_has_one_state():
    rod = BarberRod(10.0, 1000.0, 1e-4, 1.0, 2.0, 200.0, 3.0, Constant(0.1))
    [only] = rod.steady_states()
    assert (only.surface, only.pressure) == pytest.approx((100.0, 8.0))
    assert only.coupling == 0.0


def march(delta, D, steps):
    """Amplitudes of strain and temperature under the split, scaled such that e = θ at rest."""
    old_strain, theta = 0.0, 1.0
    for _ in range(steps):
        strain = theta  # mechanics at the old temperature
        theta = (theta - delta * (strain - old_strain)) / (1.0 + D)
        old_strain = strain
    return abs(theta)


@pytest.mark.parametrize("D", [0.0, 0.02, 0.5, 3.0])
@pytest.mark.parametrize("delta", [0.00385, 0.0101, 0.5, 0.99, 1.02, 1.3, 2.0, 2.49, 2.51])
def test_isothermal_split(delta, D):
    split = IsothermalSplit(delta, D)
    assert split.stable() == (split.amplification() <= 1.0 + 1e-12)
    assert split.stable() == (delta <= 1.0 + 0.5 * D)
    growth = (march(delta, D, 400) / march(delta, D, 300)) ** 0.01
    assert growth == pytest.approx(split.amplification(), rel=1e-3)


def test_small_steps_are_the_dangerous_ones():
    assert not IsothermalSplit(1.5, 0.9).stable()
    assert IsothermalSplit(1.5, 1.1).stable()
    assert IsothermalSplit(1.5, 1.0).amplification() == pytest.approx(1.0)
