"""Heat that spreads in time: slabs and half spaces that touch, and the order of the schemes."""

import math

import numpy as np
import pytest

from contactfem.verification.heat_transient import EqualSlabs, HalfSpace, HalfSpaces, HeatedSlab

POOR = {"conductivity": 0.2, "heat_capacity": 2e6}  # of cases/half_spaces.toml
GOOD = {"conductivity": 50.0, "heat_capacity": 3.6e6}


def order(errors):
    """Rates between successive errors of steps and cells that are halved."""
    errors = np.abs(np.array(errors))
    return np.log2(errors[:-1] / errors[1:])


def along(result, name):
    """Distances from the interface and temperatures of a body of one column of cells, sorted."""
    picture = next(p for p in result.heat if p.name == name)
    column = np.flatnonzero(picture.points[:, 0] == picture.points[:, 0].min())
    depth = np.abs(picture.points[column, 1])
    sort = np.argsort(depth)
    return depth[sort], picture.fields["temperature"][column[sort], 0]


@pytest.mark.parametrize("end", [10.0, 100.0])
def test_slabs_become_equal(solved, end):
    """Jump and mean of two slabs: order 2 in time and space together, 1e-3 on the finest (D21)."""
    exact = EqualSlabs(10e-3, **POOR, conductance=150.0, difference=100.0)
    jumps, means = [], []
    for n, dt in ((10, 1.0), (20, 0.5), (40, 0.25)):
        changes = [f"bodies.{name}.mesh.ny={n}" for name in ("rubber", "steel")]
        changes += [f'time.{key}="{dt} s"' for key in ("step", "step_max")]
        changes += [f'time.end="{end} s"', 'heat.scheme="cG(1)"']
        result = solved("half_spaces", *changes, variant="slabs")
        depth, theta = along(result, "rubber")
        other = along(result, "steel")[1]
        jumps.append((theta[0] - other[0]) / exact.jump(end) - 1.0)
        means.append(np.trapezoid(theta, depth) / 10e-3 / exact.mean(end) - 1.0)
        assert result.steps[-1].heat.flow["contact"] == pytest.approx(
            150.0 * (theta[0] - other[0]) * 1e-3, rel=1e-9
        )
    assert (order(jumps) > 1.9).all(), jumps
    assert (order(means) > 1.9).all(), means
    assert abs(jumps[-1]) < 1e-3
    assert abs(means[-1]) < 2e-4


@pytest.mark.parametrize(("variant", "end"), [("early", 1.0), (None, 10.0), ("equal", 1.0)])
def test_half_spaces(solved, variant, end):
    """Different and equal bodies that touch and rub: surfaces and profiles to 1e-3 (D22)."""
    result = solved("half_spaces", variant=variant)
    if variant == "equal":
        exact = HalfSpaces(HalfSpace(**POOR), HalfSpace(**POOR), 500.0, 2e3)
    else:
        exact = HalfSpaces(HalfSpace(**POOR, start=30.0), HalfSpace(**GOOD), 500.0, 3e3)
    for name, profile in (("rubber", exact.theta_nonmortar), ("steel", exact.theta_mortar)):
        depth, theta = along(result, name)
        expected = profile(depth, end)
        assert theta[0] == pytest.approx(expected[0], rel=1e-3)
        largest = np.abs(expected - expected[-1]).max()
        np.testing.assert_allclose(theta, expected, rtol=0, atol=1e-3 * largest)
    out, _ = exact.fluxes(end)
    assert result.steps[-1].heat.flow["contact"] == pytest.approx(
        (0.5 * exact.dissipation - out) * 1e-3, rel=2e-3, abs=1e-9
    )
    stored = sum(step.heat.stored for step in result.steps)
    assert stored == pytest.approx(exact.dissipation * end * 1e-3, rel=1e-9)


@pytest.mark.parametrize("scheme", ["cG(1)", "dG(1)"])
def test_half_spaces_order(solved, scheme):
    """Second order in cells and steps, surfaces to 1e-3 on the finest (D22)."""
    exact = HalfSpaces(HalfSpace(**POOR, start=30.0), HalfSpace(**GOOD), 500.0, 3e3)
    expected = exact.theta_nonmortar(0.0, 1.0), exact.theta_mortar(0.0, 1.0)
    errors = []
    for n, dt in ((15, 0.02), (30, 0.01), (60, 0.005)):
        changes = [f"bodies.{name}.mesh.ny={n}" for name in ("rubber", "steel")]
        changes += [f'time.{key}="{dt} s"' for key in ("step", "step_max")]
        result = solved("half_spaces", *changes, f'heat.scheme="{scheme}"', variant="early")
        errors.append(
            [
                along(result, name)[1][0] / surface - 1.0
                for name, surface in zip(("rubber", "steel"), expected, strict=True)
            ]
        )
    rates = order(errors)
    assert (rates > 1.8).all(), rates
    assert np.abs(errors[-1]).max() < 1e-3


SLAB = """
title = "Slab"
dimension = "plane strain"
strain = "small"
mechanics = false
heat = {{ scheme = "{scheme}" }}
time = {{ end = "{end} s", step = "{step} s" }}
[materials.slab]
youngs_modulus = "100 N/mm^2"
poisson_ratio = 0.45
density = "1000 kg/m^3"
heat_capacity = "2000 J/kg/K"
conductivity = "0.2 W/m/K"
[bodies.slab]
material = "slab"
mesh = {{ builder = "block", width = "1 mm", height = "10 mm", nx = 1, ny = {n} }}
"""
FLUX = """
[[conditions]]
on = "slab.top"
heat_flux = "100 W/m^2"
"""


@pytest.mark.parametrize(
    ("scheme", "end"), [("cG(1)", 100.0), ("dG(1)", 100.0), ("dG(1)", 500.0), ("dG(1)", 2000.0)]
)
def test_heated_slab(written, scheme, end):
    """Constant flux into one side: order 2 and the profile to 1e-3 (D22).

    cG(1) needs steps that resolve the cell at the surface, or the jump of the flux rings.
    """
    exact = HeatedSlab(100.0, **POOR, length=10e-3)
    errors = []
    for n, steps in ((10, 20), (20, 40), (40, 80)):
        text = SLAB.format(scheme=scheme, end=end, step=end / steps, n=n) + FLUX
        y, theta = along(written(text), "slab")
        errors.append(np.abs(theta - exact.theta(y, end)).max() / exact.theta(10e-3, end)[0])
    assert (order(errors) > 1.8).all(), errors
    assert errors[-1] < 1e-3


WAVE = """
import numpy as np
def wave(x, t):
    return np.cos(np.pi * x[1] / 10e-3)
"""


def wave_decay(n):
    """Rates of decay of cos(πy/L) on n cells and without discretisation [1/s]."""
    kappa, length = 0.1e-6, 10e-3
    h = length / n
    c = math.cos(math.pi / n)
    return 6.0 * kappa / h**2 * (1.0 - c) / (2.0 + c), kappa * (math.pi / length) ** 2


def amplitude(written, tmp_path, scheme, steps, n, end=500.0):
    """What is left of a wave of amplitude 1."""
    (tmp_path / "wave.py").write_text(WAVE)
    text = SLAB.format(scheme=scheme, end=end, step=end / steps, n=n).replace(
        'material = "slab"', 'material = "slab"\ninitial_temperature = "wave.py:wave"'
    )
    y, theta = along(written(text), "slab")
    left = theta[0]
    np.testing.assert_allclose(theta, left * np.cos(np.pi * y / 10e-3), rtol=0, atol=1e-9)
    return left


@pytest.mark.parametrize(
    ("scheme", "expected"),
    [("dG(0)", 1), ("cG(1)", 2), ("dG(1)", 3), ("cG(2)", 4), ("dG(2)", 5), ("cG(3)", 6)],
)
def test_order_in_time(written, tmp_path, scheme, expected):
    """A nodal cosine stays one: against the decay on the same mesh only time makes an error."""
    exact = math.exp(-wave_decay(8)[0] * 500.0)
    errors = [
        amplitude(written, tmp_path, scheme, steps, 8) - exact
        for steps in ((2, 4, 8) if expected > 3 else (4, 8, 16, 32))
    ]
    rates = order(errors)
    assert abs(rates[-1] - expected) < 0.15, rates


def test_order_in_space(written, tmp_path):
    """The same wave with steps so accurate that only space makes an error: order 2."""
    exact = math.exp(-wave_decay(1)[1] * 500.0)
    errors = [amplitude(written, tmp_path, "cG(3)", 4, n) - exact for n in (8, 16, 32)]
    assert (np.abs(order(errors) - 2.0) < 0.1).all(), errors


LED = """
import numpy as np
RATE = 0.02
def held(x, t):
    return 1e3 * x[1] * np.exp(-RATE * t)
def source(x, t):
    return -2e6 * RATE * held(x, t)
"""


@pytest.mark.parametrize(("scheme", "expected"), [("cG(1)", 2), ("dG(1)", 3), ("cG(2)", 4)])
def test_order_with_prescribed_temperature_and_source(written, tmp_path, scheme, expected):
    """θ = x exp(-γt) through prescribed ends and a source: linear in space, only time errs.

    Boundary values at the stages of the scheme, and sources at its points.
    """
    (tmp_path / "led.py").write_text(LED)
    conditions = "".join(
        f'[[conditions]]\non = "{on}"\n{kind} = "led.py:{name}"\n'
        for on, kind, name in (
            ("slab.top", "temperature", "held"),
            ("slab.bottom", "temperature", "held"),
            ("slab", "heat_source", "source"),
        )
    )
    errors = []
    for steps in (4, 8, 16):
        text = SLAB.format(scheme=scheme, end=100.0, step=100.0 / steps, n=6) + conditions
        text = text.replace(
            'material = "slab"', 'material = "slab"\ninitial_temperature = "led.py:held"'
        )
        result = written(text)
        y, theta = along(result, "slab")
        errors.append(np.abs(theta - 1e3 * y * math.exp(-2.0)).max())
    rates = order(errors)
    assert rates[-1] > expected - 0.2, (rates, errors)
    assert {step.heat.rings for step in result.steps} == {""}  # steps resolve what is led


@pytest.mark.parametrize("scheme", ["dG(0)", "dG(1)", "dG(2)"])
def test_stiff_bar(solved, scheme):
    """ρc = 2e-13: an L-stable scheme is at the steady profile to 1e-6, and nothing is said."""
    result = solved("stiff_bar", f'heat.scheme="{scheme}"')
    picture = result.heat[0]
    expected = 100.0 * (1.0 - picture.points[:, 0] / 10e-3)
    found = picture.fields["temperature"][:, 0]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * 100.0)
    assert {step.heat.rings for step in result.steps} == {""}


@pytest.mark.parametrize("scheme", ["cG(1)", "cG(3)"])
def test_ringing_is_said(solved, scheme):
    """The same bar with a scheme that does not damp: from the third step on the run says so."""
    result = solved("stiff_bar", f'heat.scheme="{scheme}"')
    said = [step.heat.rings for step in result.steps]
    assert not any(said[:2])
    assert all("rings" in text and scheme in text for text in said[3:]), said


def test_ringing_of_single_nodes_is_said(solved):
    """Half spaces that meet at a jump: the first nodes ring under a large smooth change."""
    result = solved("half_spaces", 'heat.scheme="cG(1)"', variant="early")
    assert "at some nodes" in result.steps[-1].heat.rings


@pytest.mark.parametrize("variant", ["early", "slabs"])
def test_silence_where_nothing_rings(solved, variant):
    """The same with a scheme that damps it, and slabs."""
    result = solved("half_spaces", 'heat.scheme="dG(1)"', variant=variant)
    assert {step.heat.rings for step in result.steps} == {""}
