"""Prescribed flux, convection, sources and temperatures of a bar, against its closed form."""

import numpy as np
import pytest

from contactfem.verification.heat_steady import Bar, two_bars
from contactfem.verification.homogeneous import NeoHooke

LENGTH, WIDTH, K = 10e-3, 4e-3, 0.2

BAR = """
title = "Bar"
strain = "{strain}"
mechanics = {mechanics}
heat = {{ scheme = "steady" }}
time = {{ end = "1 s", step = "1 s" }}
solver = {{ tolerance = 1e-12 }}
[materials.solid]
bulk_modulus = "333 MPa"
shear_modulus = "35 MPa"
conductivity = "0.2 W/m/K"
[bodies.bar]
material = "solid"
mesh = {{ builder = "block", width = "4 mm", height = "10 mm", nx = 2, ny = 3, cell = "{cell}" }}
"""
STRETCH = """
[[conditions]]
on = "bar.bottom"
displacement.y = "0 mm"
[[conditions]]
on = "bar.left"
displacement.x = "0 mm"
[[conditions]]
on = "bar.top"
displacement.y = "-3 mm"
"""
CELLS = pytest.mark.parametrize("cell", ["quadrilateral", "triangle"])


def bar(cell="quadrilateral", strain="small", *, mechanics=False):
    return BAR.format(strain=strain, mechanics=str(mechanics).lower(), cell=cell)


def condition(on, kind, value):
    return f'[[conditions]]\non = "{on}"\n{kind} = {value}\n'


def temperatures(result):
    """Heights and temperatures at the vertices."""
    picture = result.heat[0]
    return picture.points[:, 1], picture.fields["temperature"][:, 0]


@CELLS
def test_flux(written, cell):
    """θ = θ_0 + q y / k."""
    text = bar(cell) + condition("bar.bottom", "temperature", '"20 K"')
    result = written(text + condition("bar.top", "heat_flux", '"300 W/m^2"'))
    y, theta = temperatures(result)
    np.testing.assert_allclose(theta, 20.0 + 300.0 * y / K, rtol=1e-12)
    assert result.steps[-1].heat.loads == pytest.approx(300.0 * WIDTH, rel=1e-12)
    assert result.steps[-1].heat.held["bar.bottom"] == pytest.approx(-300.0 * WIDTH, rel=1e-12)


@CELLS
def test_convection(written, cell):
    """Convection at one end is the bar's contact with surroundings through the coefficient."""
    text = bar(cell) + condition("bar.bottom", "temperature", '"100 K"')
    value = '{ coefficient = "50 W/m^2/K", ambient = "20 K" }'
    result = written(text + condition("bar.top", "convection", value))
    exact = two_bars(Bar(LENGTH, K, 100.0), Bar(0.0, 1.0, 20.0), 50.0)
    y, theta = temperatures(result)
    np.testing.assert_allclose(theta, 100.0 - exact.out * y / K, rtol=1e-12)
    assert result.steps[-1].heat.loads == pytest.approx(-exact.out * WIDTH, rel=1e-12)


@pytest.mark.parametrize("kind", ["heat_flux", "convection"])
@CELLS
def test_on_a_stretched_surface(written, cell, kind):
    """A bar pressed to 0.7 of its length: heat enters per current area of its wider end."""
    wider = NeoHooke(333e6, 35e6).plane_strain_block(0.7)[0]
    text = bar(cell, "finite", mechanics=True) + STRETCH
    text += condition("bar.bottom", "temperature", '"100 K"')
    if kind == "heat_flux":
        q = 300.0
        result = written(text + condition("bar.top", kind, '"300 W/m^2"'))
    else:
        value = '{ coefficient = "50 W/m^2/K", ambient = "20 K" }'
        result = written(text + condition("bar.top", kind, value))
        q = -two_bars(Bar(0.7 * LENGTH, K, 100.0), Bar(0.0, 1.0, 20.0), 50.0).out
    y, theta = temperatures(result)
    np.testing.assert_allclose(theta, 100.0 + q * 0.7 * y / K, rtol=1e-9)
    assert result.steps[-1].heat.loads == pytest.approx(q * WIDTH * wider, rel=1e-9)


def test_flux_on_the_side_of_a_stretched_bar(written):
    """On its free sides the current area is 0.7 of the undeformed one; conduction is sideways."""
    wider = NeoHooke(333e6, 35e6).plane_strain_block(0.7)[0]
    text = bar(strain="finite", mechanics=True) + STRETCH
    text += condition("bar.left", "temperature", '"100 K"')
    result = written(text + condition("bar.right", "heat_flux", '"300 W/m^2"'))
    picture = result.heat[0]
    expected = 100.0 + 300.0 * wider * picture.points[:, 0] / K
    np.testing.assert_allclose(picture.fields["temperature"][:, 0], expected, rtol=1e-9)
    assert result.steps[-1].heat.loads == pytest.approx(300.0 * 0.7 * LENGTH, rel=1e-9)
    flux = picture.fields["heat_flux"]
    np.testing.assert_allclose(flux[:, 0], -300.0, rtol=1e-9)
    np.testing.assert_allclose(flux[:, 1], 0.0, atol=1e-7)


def test_source_per_reference_volume(written):
    """A source in a pressed bar: θ = θ_0 + r (2 L y - y²) l² / (2 k J L²) at the vertices."""
    wider = NeoHooke(333e6, 35e6).plane_strain_block(0.7)[0]
    text = bar(strain="finite", mechanics=True) + STRETCH
    text += condition("bar.bottom", "temperature", '"100 K"')
    result = written(text + condition("bar", "heat_source", '"1e5 W/m^3"'))
    y, theta = temperatures(result)
    expected = 100.0 + 1e5 / (0.7 * wider) * 0.7**2 * (LENGTH * y - 0.5 * y**2) / K
    np.testing.assert_allclose(theta, expected, rtol=1e-9)
    assert result.steps[-1].heat.loads == pytest.approx(1e5 * WIDTH * LENGTH, rel=1e-9)


def test_fields_of_users(written, tmp_path):
    """Temperature, flux and source as functions of place and time."""
    (tmp_path / "mine.py").write_text(
        "def held(x, t):\n    return 100.0 + 1e3 * x[0] * t\n"
        "def flux(x, t):\n    return 1e5 * x[0] * t\n"
    )
    sides = ("bottom", "top", "left", "right")
    held = (condition(f"bar.{side}", "temperature", '"mine.py:held"') for side in sides)
    result = written(bar() + "".join(held))
    picture = result.heat[0]
    expected = 100.0 + 1e3 * picture.points[:, 0]
    np.testing.assert_allclose(picture.fields["temperature"][:, 0], expected, rtol=1e-12)
    text = bar() + condition("bar.bottom", "temperature", '"0 K"')
    result = written(text + condition("bar.top", "heat_flux", '"mine.py:flux"'))
    assert result.steps[-1].heat.loads == pytest.approx(1e5 * WIDTH**2 / 2, rel=1e-12)


def test_corner_of_two_prescribed_temperatures(written):
    """A vertex in two conditions counts once in the balance of heat."""
    text = bar() + condition("bar.bottom", "temperature", '"0 K"')
    text += condition("bar.left", "temperature", '"0 K"')
    result = written(text + condition("bar.top", "heat_flux", '"300 W/m^2"'))
    heat = result.steps[-1].heat
    assert sum(heat.held.values()) == pytest.approx(-300.0 * WIDTH, rel=1e-12)
    assert abs(heat.defect) < 1e-12 * 300.0 * WIDTH
