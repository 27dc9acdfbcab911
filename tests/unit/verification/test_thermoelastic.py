"""Coupled closed forms: known numbers, and the equations they solve."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from contactfem.laws.conductance import PowerLaw
from contactfem.verification.heat_steady import Bar
from contactfem.verification.homogeneous import NeoHooke, confined_stack
from contactfem.verification.thermoelastic import ConfinedBlock, Rod, confined_blocks, rods

PAPER = PowerLaw(150.0, 100.0, 1.5)
SOFT = Rod(Bar(10.0, 0.2, 100.0), 1000.0, 1e-4)
STIFF = Rod(Bar(5.0, 0.4, 0.0), 2000.0, 5e-5)


@pytest.mark.parametrize(
    ("gap", "pressure", "temperatures", "flux"),
    [
        (-0.02, 6.6186759, (20.4980237, 19.8754941), 1.5900395),
        (0.0, 5.0281159, None, None),
        (0.01, 4.2362573, (20.9668619, 19.7582845), None),
        (0.04, 1.9159936, (23.0931616, 19.2267096), 1.5381368),
    ],
)
def test_rods(gap, pressure, temperatures, flux):
    found = rods(SOFT, STIFF, gap, PAPER)
    assert found.pressure == pytest.approx(pressure, abs=5.1e-8)
    if temperatures:
        assert (found.nonmortar, found.mortar) == pytest.approx(temperatures, abs=5.1e-8)
    if flux:
        assert found.flux == pytest.approx(flux, abs=5.1e-8)


@pytest.mark.parametrize("gap", [-0.02, 0.03])
def test_rods_fill_the_space_between_the_walls(gap):
    """Lengths seen from either side add up to the distance of the walls."""
    one, other = rods(SOFT, STIFF, gap, PAPER), rods(STIFF, SOFT, gap, PAPER)
    assert other.pressure == pytest.approx(one.pressure, rel=1e-12)
    assert other.flux == pytest.approx(-one.flux, rel=1e-12)
    assert one.length + other.length == pytest.approx(15.0 + gap, rel=1e-13)


def test_rods_that_do_not_touch():
    found = rods(SOFT, STIFF, 0.2, PAPER)
    assert (found.pressure, found.flux, found.nonmortar, found.mortar) == (0.0, 0.0, 100.0, 0.0)
    assert found.length == pytest.approx(10.1)


RUBBER, GROUND = NeoHooke(333.0, 35.0, 1e-4), NeoHooke(8333.0, 3846.0, 1e-5)
HOT = ConfinedBlock(RUBBER, Bar(10.0, 0.2, 100.0))


@pytest.mark.parametrize(
    ("other", "distance", "pressure", "flux", "surfaces", "length"),
    [
        (RUBBER, 19.0, 25.70330848, 1.05206502, (49.71672477, 49.66290179), 9.55896721),
        (RUBBER, 18.0, 49.80498692, 1.11087700, (None, None), 9.05333158),
        (GROUND, 19.0, 51.01471132, 1.05242889, (52.46776757, None), 9.03286350),
    ],
)
def test_confined_blocks(other, distance, pressure, flux, surfaces, length):
    found = confined_blocks(HOT, ConfinedBlock(other, Bar(10.0, 0.2, 0.0)), distance, PAPER)
    digits = 5.1e-9
    assert (found.pressure, found.flux) == pytest.approx((pressure, flux), abs=digits)
    assert found.length == pytest.approx(length, abs=digits)
    for value, printed in zip((found.nonmortar, found.mortar), surfaces, strict=True):
        assert printed is None or value == pytest.approx(printed, abs=digits)


def test_confined_blocks_at_one_temperature():
    """Without a difference of temperature it is the stack of two homogeneous blocks."""
    set_temperature = NeoHooke(333.0, 35.0, 1e-4, 70.0)
    hard = NeoHooke(8333.0, 3846.0, 1e-5, 70.0)
    stack = confined_stack(set_temperature, hard, 10.0, 5.0, -1.0)
    blocks = (
        ConfinedBlock(RUBBER, Bar(10.0, 0.2, 70.0)),
        ConfinedBlock(GROUND, Bar(5.0, 9.0, 70.0)),
    )
    found = confined_blocks(*blocks, 14.0, PAPER)
    assert found.pressure == pytest.approx(stack.pressure, rel=1e-11)
    assert found.length == pytest.approx(10.0 * stack.stretch_lower, rel=1e-12)
    assert found.flux == pytest.approx(0.0, abs=1e-9)


def test_confined_blocks_shot_through():
    """Integrate dX/dx = 1/J, dθ/dx = -q/k from the hot wall over the deformed blocks."""
    cold = ConfinedBlock(GROUND, Bar(10.0, 0.2, 0.0))
    found = confined_blocks(HOT, cold, 19.0, PAPER)

    def through(block, theta, length):
        def rates(x, y):
            return [1.0 / block.volume_ratio(found.pressure, y[1:])[0], -found.flux / 0.2]

        return solve_ivp(rates, (0.0, length), [0.0, theta], rtol=1e-11, atol=1e-11).y[:, -1]

    X, theta = through(HOT, 100.0, found.length)
    assert (X, theta) == pytest.approx((10.0, found.nonmortar), rel=1e-9)
    X, theta = through(cold, found.mortar, 19.0 - found.length)
    assert X == pytest.approx(10.0, rel=1e-9)
    assert theta == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize(("p", "theta"), [(0.0, 50.0), (30.0, 0.0), (80.0, 100.0)])
def test_volume_ratio_gives_the_stress(p, theta):
    J = HOT.volume_ratio(p, np.array([theta]))[0]
    set_temperature = NeoHooke(333.0, 35.0, 1e-4, theta)
    assert set_temperature.uniaxial_strain(J)[0] == pytest.approx(-p, abs=1e-11)
