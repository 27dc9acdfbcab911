"""Closed forms of steady heat conduction: known numbers, and the equations they solve."""

import math

import pytest

from contactfem.laws.conductance import PowerLaw, under_pressure
from contactfem.verification.heat_steady import Bar, RodInRing, rise_by_sliding, two_bars
from contactfem.verification.homogeneous import NeoHooke

PAPER = PowerLaw(150.0, 100.0, 1.5)
HOT, COLD = Bar(10.0, 0.2, 100.0), Bar(10.0, 0.2, 0.0)


@pytest.mark.parametrize(
    ("pressure", "source", "expected"),
    [
        (1.0, 0.0, (53.125, 46.875, 0.9375, 0.9375)),
        (4.0, 0.0, (50.41322314, 49.58677686, 0.99173554, 0.99173554)),
        (4.0, 0.5, (62.91322314, 62.08677686, 0.74173554, 1.24173554)),
    ],
)
def test_two_bars(pressure, source, expected):
    found = two_bars(HOT, COLD, under_pressure(PAPER, pressure)[0], source)
    assert (found.nonmortar, found.mortar) == pytest.approx(expected[:2], abs=5.1e-9)
    assert (found.out, found.into) == pytest.approx(expected[2:], abs=5.1e-9)


def test_two_bars_of_different_metals():
    """Against what another finite element program computed."""
    h = 2.0 * 16.2 * 210.0 / (16.2 + 210.0) * 100.0 / 26.875
    assert h == pytest.approx(111.924, abs=5e-4)
    found = two_bars(Bar(1.0, 16.2, 800.0), Bar(1.0, 210.0, 250.0), h)
    assert found.out == pytest.approx(7292.0187, rel=1e-7)
    assert found.nonmortar == pytest.approx(349.875418, rel=1e-7)


@pytest.mark.parametrize("partition", [0.0, 0.3, 1.0])
def test_two_bars_balance(partition):
    set_temperature, cool = Bar(3.0, 0.5, 40.0), Bar(7.0, 2.0, -5.0)
    found = two_bars(set_temperature, cool, 0.8, 6.0, partition)
    through = 0.8 * (found.nonmortar - found.mortar)
    assert found.out == pytest.approx(0.5 * (40.0 - found.nonmortar) / 3.0)
    assert found.into == pytest.approx(2.0 * (found.mortar + 5.0) / 7.0)
    assert found.out == pytest.approx(through - partition * 6.0)
    assert found.into == pytest.approx(through + (1.0 - partition) * 6.0)


def test_two_bars_that_do_not_conduct():
    found = two_bars(HOT, COLD, 0.0, 0.1, 0.25)
    assert (found.nonmortar, found.mortar) == pytest.approx((101.25, 3.75))


def test_heat_flow_through_stretched_blocks():
    """Two blocks compressed to 0.7: conduction and conductance per current area."""
    lateral, stress, _ = NeoHooke(333.0, 35.0).plane_strain_block(0.7)
    h = under_pressure(PAPER, -stress)[0]
    assert h == pytest.approx(53.437445, rel=1e-7)
    found = two_bars(Bar(7.0, 0.2, 100.0), Bar(7.0, 0.2, 0.0), h)
    assert lateral * found.out == pytest.approx(1.8936102, abs=5e-8)


def test_rise_by_sliding():
    """A block of 1.25 mm with half of the heat, and two blocks of 10 mm with all of it."""
    assert rise_by_sliding(0.5 * 0.2 * 10.0 * 3.75, 2.43 * 1.25) == pytest.approx(1.2346, abs=5e-5)
    assert rise_by_sliding(0.4 * 1.0 * 50.0, 20.0, 20.0) == pytest.approx(0.5)


ROD = RodInRing(10.0, 20.0, 0.2, 0.2, 5.0, 0.15)


def test_rod_in_ring():
    assert ROD.ring(10.0) == pytest.approx(2.757945, abs=5.1e-7)
    assert ROD.rod(10.0) == pytest.approx(3.288461, abs=5.1e-7)
    assert ROD.rod(0.0) == pytest.approx(5.277898, abs=5.1e-7)


def test_rod_in_ring_solves_its_equations():
    rod = RodInRing(3.0, 7.0, 0.5, 2.0, 11.0, 0.4, 6.0)
    dr = 1e-3
    for theta, source, k, r in [
        (rod.rod, 11.0 / (9.0 * math.pi), 0.5, 1.7),
        (rod.ring, 0, 2.0, 5.0),
    ]:
        flux = [-k * (theta(s + dr) - theta(s - dr)) / (2 * dr) * s for s in (r - dr, r + dr)]
        assert (flux[1] - flux[0]) / (2.0 * dr * r) == pytest.approx(source, abs=1e-6)
    out = 11.0 / (2.0 * math.pi * 3.0)
    assert 0.4 * (rod.rod(3.0) - rod.ring(3.0)) == pytest.approx(out)
    assert -2.0 * (rod.ring(3.0 + dr) - rod.ring(3.0 - dr)) / (2.0 * dr) == pytest.approx(
        out, rel=1e-6
    )
    assert rod.ring(7.0) == 6.0
