"""Heat through the contact of bars and blocks, steady, alone and coupled: exact on any mesh."""

import re
from pathlib import Path

import numpy as np
import pytest

from contactfem.laws.conductance import Constant, GasGap, PowerLaw, under_pressure
from contactfem.verification.heat_steady import Bar, two_bars
from contactfem.verification.homogeneous import NeoHooke
from contactfem.verification.thermoelastic import ConfinedBlock, Rod, confined_blocks, rods

CASES = Path(__file__).parents[2] / "cases"
LENGTH, WIDTH, CONDUCTIVITY, HOT = 10e-3, 5e-3, 0.2, 100.0
LAW = PowerLaw(150e3, 100e6, 1.5)
TIRE = {"bulk_modulus": 333e6, "shear_modulus": 35e6, "expansion": 1e-4}
GROUND = {"bulk_modulus": 8333e6, "shear_modulus": 3846e6, "expansion": 1e-5}


def bars(h, d=0.0, partition=0.5, length=LENGTH):
    """Closed form of cases/two_bars.toml, the hot bar is nonmortar."""
    hot, cold = (Bar(length, CONDUCTIVITY, end) for end in (HOT, 0.0))
    return two_bars(hot, cold, h, d, partition)


def check(result, expected, width=WIDTH, rel=1e-9):
    """Surface temperatures at all nodes, and the heat that leaves one wall and enters the other."""
    heat, step = result.interfaces[0].heat, result.steps[-1].heat
    scale = rel * HOT
    np.testing.assert_allclose(heat.temperature, expected.nonmortar, rtol=0, atol=scale)
    np.testing.assert_allclose(heat.mortar_temperature, expected.mortar, rtol=0, atol=scale)
    assert step.held["hot.top"] == pytest.approx(expected.out * width, rel=rel)
    assert step.held["cold.bottom"] == pytest.approx(-expected.into * width, rel=rel)
    assert abs(step.defect) < 1e-12 * abs(expected.into) * width


@pytest.mark.parametrize(
    ("variant", "pressure"),
    [("p_01", 0.1e6), ("p_1", 1e6), (None, 4e6), ("p_10", 10e6), ("p_100", 100e6)],
)
def test_conductance_under_pressure(solved, variant, pressure):
    """q = h (θ_nm - θ_m) with h = h_c0 (p / H_v)^ε (15), from barely touching to pressed hard."""
    result = solved("two_bars", variant=variant)
    expected = bars(under_pressure(LAW, pressure)[0])
    check(result, expected)
    np.testing.assert_allclose(result.interfaces[0].heat.flux, expected.out, rtol=1e-9)
    assert result.steps[-1].heat.flow["contact"] == pytest.approx(expected.out * WIDTH, rel=1e-9)


@pytest.mark.parametrize("partition", [0.0, 0.3, 0.5, 1.0])
def test_a_source_in_the_interface(solved, partition):
    """The share f of d enters nonmortar, the rest mortar: q_nm = q - f d, q_m = -q - (1 - f) d."""
    share = f"interfaces.contact.heat.partition={partition}"
    result = solved("two_bars", share, variant="source")
    d = 500.0
    expected = bars(under_pressure(LAW, 4e6)[0], d, partition)
    check(result, expected)
    heat = result.interfaces[0].heat
    np.testing.assert_allclose(heat.dissipation, d, rtol=1e-9)
    np.testing.assert_allclose(heat.flux, expected.out + partition * d, rtol=1e-9)
    assert result.steps[-1].heat.friction == pytest.approx(d * WIDTH, rel=1e-12)


def test_the_other_side_as_nonmortar(solved):
    """Which side the integrals live on does not matter to what is exact."""
    swap = ('interfaces.contact.nonmortar="cold.top"', 'interfaces.contact.mortar="hot.bottom"')
    result = solved("two_bars", *swap)
    expected = bars(under_pressure(LAW, 4e6)[0])
    heat = result.interfaces[0].heat
    np.testing.assert_allclose(heat.temperature, expected.mortar, rtol=1e-9)
    np.testing.assert_allclose(heat.mortar_temperature, expected.nonmortar, rtol=1e-9)
    np.testing.assert_allclose(heat.flux, -expected.out, rtol=1e-9)


@pytest.mark.parametrize("meshes", ["shared", "own"])
def test_stretched_interface(solved, meshes):
    """Conduction and conductance in the deformed configuration: lengths 0.7 L, width λ₂ W."""
    own = [
        f'bodies.{name}.thermal_mesh={{builder = "block", width = "5 mm", height = "10 mm", '
        f'corner = ["0 mm", "{y} mm"], nx = {nx}, ny = {ny}, cell = "triangle"}}'
        for name, y, nx, ny in (("hot", 10, 7, 3), ("cold", 0, 2, 9))
    ]
    result = solved("two_bars", *(own if meshes == "own" else ()), variant="stretched")
    wider, axial, _ = NeoHooke(333e6, 35e6).plane_strain_block(0.7)
    expected = bars(under_pressure(LAW, -axial)[0], length=0.7 * LENGTH)
    check(result, expected, WIDTH * wider, rel=1e-6)


APART = (
    'conditions=[{{on = "cold.bottom", displacement.y = "0 mm"}},'
    '{{on = "cold.left", displacement.x = "0 mm"}}, {{on = "hot.left", displacement.x = "0 mm"}},'
    '{{on = "hot.top", displacement.y = "{} m"}},'
    '{{on = "hot.top", temperature = "100 K"}}, {{on = "cold.bottom", temperature = "0 K"}}]'
)
CONSTANT = 'law = "constant", conductance = "3e3 W/m^2/K"'
PRESSURE = 'law = "pressure", conductance = "3e3 W/m^2/K", hardness = "1 MPa", exponent = 0.5'


def with_law(law):
    """Text of cases/two_bars.toml with another law."""
    text = (CASES / "two_bars.toml").read_text()
    changed = re.sub(r"heat = \{ law = .*\}", f"heat = {{ {law} }}", text)
    assert changed != text
    return changed


def test_constant_conductance(written):
    """A constant law: h wherever there is contact, whatever the pressure."""
    check(written(with_law(CONSTANT)), bars(under_pressure(Constant(3e3), 4e6)[0]))


@pytest.mark.parametrize("gap", [1e-6, 0.5e-3])
def test_gas_across_an_open_gap(written, gap):
    """h = k_gas / (g + g_0) where nothing touches."""
    law = 'law = "gas", gas_conductivity = "0.03 W/m/K", gas_distance = "0.1 mm"'
    result = written(with_law(law), APART.format(gap))
    assert result.steps[-1].open == len(result.interfaces[0].X)
    check(result, bars(GasGap(0.03, 0.1e-3)(np.zeros(1), np.array([gap])).h[0]))


@pytest.mark.parametrize("law", [PRESSURE, CONSTANT])
def test_an_open_gap_conducts_nothing(written, law):
    """Each bar takes the temperature of its wall, and no heat flows."""
    result = written(with_law(law), APART.format(1e-6))
    heat = result.interfaces[0].heat
    np.testing.assert_allclose(heat.temperature, HOT, rtol=1e-12)
    np.testing.assert_allclose(heat.mortar_temperature, 0.0, atol=1e-12 * HOT)
    assert np.all(heat.flux == 0.0)


def test_a_users_conductance(written, tmp_path):
    """A function h(p, g) in a file of its own sees the contact pressure and a closed gap."""
    (tmp_path / "mine.py").write_text(
        "def law(p, g):\n    assert abs(g).max() < 1e-12\n    return 2e3 * (p / 4e6) ** 2 + 1e3\n"
    )
    check(written(with_law('law = "mine.py:law"')), bars(3e3))


OBSTACLE = """
title = "Bar on a warm plane"
strain = "small"
time = { end = "1 s", step = "1 s" }
heat = { scheme = "steady" }
solver = { tolerance = 1e-12 }
[materials.solid]
youngs_modulus = "1000 MPa"
poisson_ratio = 0.0
conductivity = "0.2 W/m/K"
[bodies.hot]
material = "solid"
mesh = { builder = "block", width = "5 mm", height = "10 mm", nx = 4, ny = 7 }
[obstacles.plane]
shape = "plane"
point = ["0 mm", "0 mm"]
normal = [0.0, 1.0]
temperature = "20 K"
[interfaces.contact]
nonmortar = "hot.bottom"
mortar = "plane"
heat = { law = "pressure", conductance = "1.5e5 W/m^2/K", hardness = "100 MPa", exponent = 1.5 }
[[conditions]]
on = "hot.left"
displacement.x = "0 mm"
[[conditions]]
on = "hot.top"
traction.y = "-4 MPa"
[[conditions]]
on = "hot.top"
temperature = "100 K"
"""


def test_an_obstacle_with_a_temperature(written):
    """A bar between a wall and a rigid plane: q (L/k + 1/h) = Δθ, and the plane takes it."""
    result = written(OBSTACLE)
    h = under_pressure(LAW, 4e6)[0]
    expected = two_bars(Bar(LENGTH, CONDUCTIVITY, HOT), Bar(0.0, CONDUCTIVITY, 20.0), h)
    heat, step = result.interfaces[0].heat, result.steps[-1].heat
    np.testing.assert_allclose(heat.temperature, expected.nonmortar, rtol=1e-9)
    np.testing.assert_allclose(heat.mortar_temperature, 20.0, rtol=1e-12)
    assert step.obstacles == pytest.approx(-expected.out * WIDTH, rel=1e-9)
    assert step.held["hot.top"] == pytest.approx(expected.out * WIDTH, rel=1e-9)


def test_an_obstacle_without_a_temperature(written):
    """It conducts nothing, but takes its share of frictional heat."""
    result = written(
        OBSTACLE.replace('temperature = "20 K"\n', ""),
        'interfaces.contact.heat.dissipation="500 W/m^2"',
        "interfaces.contact.heat.partition=0.3",
    )
    rise = 0.3 * 500.0 * LENGTH / CONDUCTIVITY
    heat = result.interfaces[0].heat
    np.testing.assert_allclose(heat.temperature, HOT + rise, rtol=1e-9)
    assert result.steps[-1].heat.friction == pytest.approx(0.3 * 500.0 * WIDTH, rel=1e-12)


@pytest.mark.parametrize(
    ("variant", "gap"),
    [(None, -0.02e-3), ("touching", 0.0), ("gap_10", 0.01e-3), ("gap_40", 0.04e-3)],
)
def test_rods_that_heat_presses_together(solved, variant, gap):
    """p, h(p) and temperatures at the fixed point of the passes, small strain (D20)."""
    result = solved("gap_closure", variant=variant)
    hot = Rod(Bar(10e-3, 0.2, 100.0), 1000e6, 1e-4)
    cold = Rod(Bar(5e-3, 0.4, 0.0), 2000e6, 5e-5)
    expected = rods(hot, cold, gap, LAW)
    table = result.interfaces[0]
    np.testing.assert_allclose(table.pressure, expected.pressure, rtol=1e-6)
    np.testing.assert_allclose(table.heat.temperature, expected.nonmortar, rtol=1e-6)
    np.testing.assert_allclose(table.heat.mortar_temperature, expected.mortar, rtol=1e-6)
    np.testing.assert_allclose(table.heat.flux, expected.flux, rtol=1e-6)
    assert result.steps[-1].heat.passes > 1


def confined(variant):
    """Closed form of the blocks of a variant of cases/gap_closure.toml."""
    second = GROUND if variant == "blocks_ground" else TIRE
    blocks = [
        ConfinedBlock(NeoHooke(**solid), Bar(10e-3, 0.2, end))
        for solid, end in ((TIRE, 100.0), (second, 0.0))
    ]
    return confined_blocks(*blocks, 18e-3 if variant == "blocks_18" else 19e-3, LAW)


def deviations(result, expected):
    """Relative errors of pressure, flux, both surfaces and the deformed length."""
    table = result.interfaces[0]
    found = {
        "pressure": table.pressure,
        "flux": table.heat.flux,
        "nonmortar": table.heat.temperature,
        "mortar": table.heat.mortar_temperature,
        "length": table.x[:, 1],
    }
    return np.array(
        [np.abs(values / getattr(expected, name) - 1.0).max() for name, values in found.items()]
    )


@pytest.mark.parametrize("variant", ["blocks_19", "blocks_18", "blocks_ground"])
def test_confined_blocks_at_finite_strain(solved, variant):
    """Neo-Hooke with thermal split, h(p), conduction on the deformed body, passes: order 2.

    Richardson's extrapolation of two meshes is at the closed form to 1e-6 (D20).
    """
    expected = confined(variant)
    errors, signed = [], []
    for n in (8, 16, 32):
        meshes = [f"bodies.{name}.mesh.ny={n * k // 4}" for name, k in (("hot", 4), ("cold", 3))]
        result = solved("gap_closure", *meshes, variant=variant)
        errors.append(deviations(result, expected))
        table = result.interfaces[0]
        signed.append((table.pressure.mean(), table.heat.temperature.mean()))
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert (rates > 1.9).all(), rates
    limit = (4.0 * np.array(signed[2]) - np.array(signed[1])) / 3.0
    np.testing.assert_allclose(limit, (expected.pressure, expected.nonmortar), rtol=1e-6)
