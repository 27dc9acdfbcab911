"""Conductance laws, their derivatives, and the balance of heat at an interface."""

import numpy as np
import pytest

from contactfem.laws.conductance import TINY, Constant, GasGap, Parallel, PowerLaw, under_pressure
from contactfem.laws.frictional_heat import conducted, outflow

PAPER = PowerLaw(150.0, 100.0, 1.5)
GAS = GasGap(0.025, 1e-6)
EXPONENTS = [0.3, 0.95, 1.0, 1.5, 2.0, 3.0]
LAWS = [*(PowerLaw(150.0, 100.0, e) for e in EXPONENTS), Constant(7.0), GAS, Parallel((PAPER, GAS))]
NO_GAP = np.zeros(1)


def test_power_law_of_the_paper():
    p = np.array([0.1, 1.0, 4.0, 10.0, 100.0, 0.0, -3.0])
    exact = [0.00474341649, 0.15, 1.2, 4.74341649, 150.0, 0.0, 0.0]
    np.testing.assert_allclose(PAPER(p, np.zeros(7)).h, exact, rtol=1e-9)


@pytest.mark.parametrize("law", LAWS, ids=str)
def test_derivatives(law):
    """Against central differences, with steps that stay on one side of every kink."""
    p = np.array([1e-12, 1e-9, 0.5e-6, 0.999e-6, 1.001e-6, 1e-5, 1e-3, 1.0, 30.0, 500.0, -1.0])
    g = np.array([2e-6, -1e-6, 1e-9, 1e-3, -1.0, 5e-7, 1e-6, 2e-6, 1e-5, 1e-4, 1e-6])
    found = law(p, g)
    dp, dg = 1e-5 * np.abs(p), 1e-5 * np.abs(g)
    by_pressure = (law(p + dp, g).h - law(p - dp, g).h) / (2.0 * dp)
    by_gap = (law(p, g + dg).h - law(p, g - dg).h) / (2.0 * dg)
    # a difference of two values h is not known better than round-off in h
    noise = 4.0 * np.finfo(float).eps * found.h
    assert (np.abs(found.dh_dp - by_pressure) <= 1e-8 * np.abs(by_pressure) + noise / dp).all()
    assert (np.abs(found.dh_dgap - by_gap) <= 1e-8 * np.abs(by_gap) + noise / dg).all()


@pytest.mark.parametrize("exponent", [1e-3, *EXPONENTS])
def test_power_law_is_defined_at_and_near_zero_pressure(exponent):
    law = PowerLaw(150.0, 100.0, exponent)
    p = np.array([-1.0, -1e-300, -0.0, 0.0, 5e-324, 1e-300, 1e-30])
    with np.errstate(all="raise", under="ignore"):
        found = law(p, np.zeros(7))
    assert np.isfinite(found).all()
    assert (found.h[:4] == 0.0).all()
    assert (found.dh_dp[:4] == 0.0).all()
    assert found.h[-1] < 1e-15
    assert (found.dh_dp <= (2.0 - min(exponent, 1.0)) * 150.0 / 100.0 / TINY).all()


@pytest.mark.parametrize("exponent", [0.3, 0.95])
def test_smooth_start_of_the_power_law(exponent):
    """Value and slope are continuous at p_t, and h grows with p."""
    law = PowerLaw(150.0, 100.0, exponent)
    p_t = TINY * 100.0
    sides = law(p_t * np.array([1.0 - 1e-12, 1.0 + 1e-12]), np.zeros(2))
    assert sides.h[0] == pytest.approx(sides.h[1], rel=1e-11)
    assert sides.dh_dp[0] == pytest.approx(sides.dh_dp[1], rel=1e-11)
    assert sides.h[0] == pytest.approx(150.0 * TINY**exponent, rel=1e-11)
    p = np.linspace(0.0, 2.0 * p_t, 101)
    assert (np.diff(law(p, np.zeros(101)).h) > 0.0).all()


def test_constant_conducts_in_contact_only():
    found = Constant(7.0)(np.array([0.0, 1e-9, 5.0, -1.0]), np.array([1.0, 0.0, -1.0, 1.0]))
    assert found.h.tolist() == [0.0, 7.0, 7.0, 0.0]


def test_gas_conducts_across_open_gaps():
    gap = np.array([-1e-6, 0.0, 1e-6, 9e-6])
    np.testing.assert_allclose(GAS(np.zeros(4), gap).h, [25e3, 25e3, 12.5e3, 2.5e3])


def test_parallel_laws_add_up():
    p, g = np.array([4.0]), np.array([1e-6])
    found = Parallel((PAPER, GAS))(p, g)
    assert found.h == pytest.approx(1.2 + 12500.0)
    assert found.dh_dp == pytest.approx(PAPER(p, g).dh_dp)
    assert found.dh_dgap == pytest.approx(-12500.0 / 2e-6)
    assert str(Parallel((PAPER, Constant(2.0)))) == (
        "power law 150 W/m²/K (p / 100 Pa)^1.5 + constant 2 W/m²/K"
    )


@pytest.mark.parametrize("law", LAWS, ids=str)
def test_derivatives_of_the_flux(law):
    p, g, jump = np.array([2.0, 30.0]), np.array([1e-6, 3e-6]), np.array([-40.0, 3.0])

    def q(p, g, jump):
        return conducted(law(p, g), jump).q

    found = conducted(law(p, g), jump)
    by_pressure = (q(p + 1e-4, g, jump) - q(p - 1e-4, g, jump)) / 2e-4
    by_gap = (q(p, g + 1e-10, jump) - q(p, g - 1e-10, jump)) / 2e-10
    by_jump = (q(p, g, jump + 1e-2) - q(p, g, jump - 1e-2)) / 2e-2
    for exact, difference in [
        (found.by_pressure, by_pressure),
        (found.by_gap, by_gap),
        (found.by_jump, by_jump),
    ]:
        np.testing.assert_allclose(exact, difference, rtol=1e-6, atol=1e-5 * abs(difference).max())


@pytest.mark.parametrize("partition", [0.0, 0.3, 0.5, 1.0])
def test_what_leaves_the_bodies_is_what_friction_makes(partition):
    q, d = np.array([3.0, -1.0]), np.array([2.0, 8.0])
    found = outflow(q, d, partition)
    np.testing.assert_allclose(found.nonmortar + found.mortar, -d)
    np.testing.assert_allclose(found.nonmortar, q - partition * d)


def test_frictional_heat_is_halved_by_default():
    found = outflow(np.zeros(1), np.array([2.0]))
    assert (found.nonmortar[0], found.mortar[0]) == (-1.0, -1.0)


def test_conductance_under_one_pressure():
    assert under_pressure(PAPER, 4.0) == pytest.approx((1.2, 0.45))
