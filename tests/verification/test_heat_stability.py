"""What heat makes unstable must become so in steps, and what is stable must stay (E1, E2, E4)."""

import re
from pathlib import Path

import numpy as np
import pytest

from contactfem.laws.conductance import PowerLaw
from contactfem.verification.thermoelastic_stability import (
    BarberRod,
    IsothermalSplit,
    barber_growth,
)

CASES = Path(__file__).parents[2] / "cases"
ROD = {
    "length": 10e-3,
    "youngs_modulus": 1e9,
    "expansion": 1e-4,
    "conductivity": 1.0,
    "heat_capacity": 2e6,
    "wall": 200.0,
}
BARBER = BarberRod(**ROD, start=-2e6, law=PowerLaw(40e3, 100e6, 1.5))
PASSES = pytest.mark.parametrize("passes", [(), ("heat.max_passes=20",)])


def disturbed(tmp_path, state, share):
    """Text of cases/barber.toml from a steady state whose temperatures are raised by a share."""
    slope = state.surface * (1.0 + share) / ROD["length"]
    (tmp_path / "start.py").write_text(f"def start(x, t):\n    return {slope!r} * x[1]\n")
    text = (CASES / "barber.toml").read_text()
    return text.replace("fields.py:barber_warm", "start.py:start")


def growth(written, text, state, times, dt, passes, rows=16):
    """Rate at which the surface temperature leaves a state between two times [1/s]."""
    changes = [f'time.{key}="{dt} s"' for key in ("step", "step_max")]
    changes += [f'time.end="{times[1]} s"', *passes, "heat.tolerance=1e-9"]
    steps = written(text, *changes, f"bodies.rod.mesh.ny={rows}", "solver.tolerance=1e-12").steps
    away = {round(step.t / dt): step.heat.temperature_max - state.surface for step in steps}
    first, last = (away[round(t / dt)] for t in times)
    return np.log(last / first) / (times[1] - times[0])


@PASSES
@pytest.mark.parametrize("number", [1, 2])
def test_growth_of_barbers_rod(written, tmp_path, number, passes):
    """A small disturbance of the closed states grows or fades at its rate to 3 % (E2)."""
    state = BARBER.steady_states()[number]
    assert (state.growth > 0.0) == (number == 1)
    text = disturbed(tmp_path, state, 1e-4)
    rate = growth(written, text, state, (30.0, 60.0), 0.5, passes)
    assert rate == pytest.approx(state.growth, rel=0.03)


@PASSES
def test_the_coupled_scheme_is_of_second_order(written, tmp_path, passes):
    """Growth of the unstable state at halved steps, with one predicted pass or the fixed point."""
    state = BARBER.steady_states()[1]
    text = disturbed(tmp_path, state, 1e-4).replace("cG(1)", "dG(1)")
    rates = [growth(written, text, state, (32.0, 64.0), dt, passes) for dt in (4.0, 2.0, 1.0)]
    changes = np.abs(np.diff(rates)) / state.growth
    assert changes[1] < 0.005
    assert 1.8 < np.log2(changes[0] / changes[1]) < 2.3


@PASSES
@pytest.mark.parametrize("coupling", [3.84, 4.08])
def test_growth_on_either_side_of_the_limit(written, tmp_path, coupling, passes):
    """h = h_c0 p / H_v with Bi = 1 and C around 2 (1 + Bi) = 4: the stable is told apart (E1)."""
    stiffness = ROD["youngs_modulus"] * ROD["expansion"]
    p = stiffness * 100.0 / coupling  # C = Bi E α (θ_wall - θ_L) / p at θ_L = 100 K
    law = PowerLaw(ROD["conductivity"] / ROD["length"] * 1e6 / p, 1e6, 1.0)
    rod = BarberRod(**ROD, start=p - stiffness * 50.0, law=law)
    state = rod.state(p)
    assert (state.biot, state.coupling) == pytest.approx((1.0, coupling))
    assert state.growth == pytest.approx(barber_growth(1.0, coupling) * rod.rate)
    gap = -rod.start / ROD["youngs_modulus"] * ROD["length"]
    text = disturbed(tmp_path, state, 1e-4).replace('"10.02 mm"', f'"{10e-3 + gap!r} m"')
    new = f'conductance = "{law.coefficient!r} W/m^2/K", hardness = "1 MPa", exponent = 1.0'
    text = re.sub(r'conductance = "40 .*, exponent = 1.5', new, text)
    assert new in text
    rate = growth(written, text, state, (100.0, 300.0), 2.0, passes)
    assert rate == pytest.approx(state.growth, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("iterated", [False, True])
@pytest.mark.parametrize("share", [0.01, -0.01])
def test_the_right_branch(written, tmp_path, share, iterated):
    """From 1 % above the unstable state the rod closes, from 1 % below it opens (E2)."""
    opened, middle, closed = BARBER.steady_states()
    passes = "heat.max_passes=30" if iterated else "heat.max_passes=1"
    result = written(disturbed(tmp_path, middle, share), passes)
    expected = closed if share > 0.0 else opened
    assert result.probes["face"] == pytest.approx(expected.surface, abs=0.5)
    assert result.interfaces[0].pressure.max() == pytest.approx(expected.pressure, rel=2e-3)


@pytest.mark.parametrize(("share", "sign"), [(0.01, 1), (-0.01, -1)])
def test_the_branch_is_chosen_early(written, tmp_path, share, sign):
    """After 100 s the disturbance of 1 % has become about twenty of the same sign."""
    middle = BARBER.steady_states()[1]
    changes = ('time.end="100 s"', 'time.step="2 s"')
    result = written(disturbed(tmp_path, middle, share), *changes)
    assert sign * (result.probes["face"] / middle.surface - 1.0) > 0.1


COLUMN = """
title = "One mode of thermoelasticity"
strain = "{strain}"
time = {{ end = "{steps} s", step = "1 s" }}
heat = {{ scheme = "dG(0)", thermoelastic = true, max_passes = 1 }}
solver = {{ tolerance = 1e-13 }}
output = {{ times = [] }}
[materials.solid]
bulk_modulus = "333 MPa"
shear_modulus = "35 MPa"
expansion = "1e-4 1/K"
density = "1 kg/m^3"
heat_capacity = "{capacity!r} J/kg/K"
conductivity = "{conductivity!r} W/m/K"
reference_temperature = "293 K"
[bodies.column]
material = "solid"
initial_temperature = "mode.py:mode"
mesh = {{ builder = "block", width = "1 mm", height = "10 mm", nx = 1, ny = 64 }}
"""
CONFINED = "".join(
    f'[[conditions]]\non = "column.{side}"\ndisplacement.{axis} = "0 mm"\n'
    for side, axis in (("left", "x"), ("right", "x"), ("bottom", "y"), ("top", "y"))
)


@pytest.mark.parametrize("strain", ["small", "finite"])
@pytest.mark.parametrize(
    ("delta", "D"),
    [(0.5, 0.05), (0.99, 0.02), (1.2, 0.1), (1.2, 0.8), (2.0, 1.0), (2.0, 3.0)],
)
def test_limit_of_the_isothermal_split(written, tmp_path, delta, D, strain):
    """With the heat of straining a step multiplies a mode by z, stable for δ <= 1 + D/2 (E4)."""
    split = IsothermalSplit(delta, D)
    K, shear, alpha = 333e6, 35e6, 1e-4
    capacity = (3 * K * alpha) ** 2 * 293.0 / (delta * (K + 4 * shear / 3))
    conductivity = D * capacity * (10e-3 / np.pi) ** 2
    size = 1e-4  # [K]
    (tmp_path / "mode.py").write_text(
        "import numpy as np\n"
        f"def mode(x, t):\n    return 293.0 + {size} * np.cos(np.pi * x[1] / 10e-3)\n"
    )
    steps = 24
    text = COLUMN.format(strain=strain, steps=steps, capacity=capacity, conductivity=conductivity)
    result = written(text + CONFINED)
    amplitude = np.array([step.heat.temperature_max for step in result.steps]) - 293.0
    # θ_n = c_1 z_1^n + c_2 z_2^n from θ_0 and θ_1 = (1 - δ) θ_0 / (1 + D)
    roots = np.roots([1.0 + D, delta - 1.0, -delta])
    first = (1.0 - delta) / (1.0 + D)
    c = np.linalg.solve([[1.0, 1.0], roots], [1.0, first])
    expected = size * np.abs(c @ roots[:, None] ** np.arange(1, steps + 1))
    np.testing.assert_allclose(amplitude, expected, rtol=0.02)
    grows = amplitude[-1] > amplitude[-9]
    assert grows == (not split.stable())
    assert np.abs(roots).max() == pytest.approx(split.amplification())
