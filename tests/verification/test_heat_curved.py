"""Heat through curved surfaces and around an axis: a rod in a ring, walls of tubes."""

import numpy as np
import pytest

from contactfem.verification.heat_steady import RodInRing

EXACT = RodInRing(10e-3, 20e-3, 0.2, 0.2, 5.0, 150.0)  # of cases/heated_rod.toml


def meshes(facets):
    """Rod and ring with facets in the ratio 3 to 4, as in the case."""
    return (
        f"bodies.rod.mesh.facets={facets}",
        f"bodies.rod.mesh.layers={facets // 8}",
        f"bodies.ring.mesh.facets={4 * facets // 3}",
        f"bodies.ring.mesh.layers={facets // 6}",
    )


@pytest.mark.parametrize("swapped", [False, True])
def test_rod_in_a_ring(solved, swapped):
    """Facets that do not match on curved surfaces: 1 % and order 2, all heat passes (D25)."""
    sides = (
        ('interfaces.fit.nonmortar="ring.inner"', 'interfaces.fit.mortar="rod.rim"')
        if swapped
        else ()
    )
    errors = []
    for facets in (24, 48, 96):
        result = solved("heated_rod", *meshes(facets), *sides)
        rod, ring = result.heat
        r = np.hypot(*rod.points.T), np.hypot(*ring.points.T)
        found = rod.fields["temperature"][:, 0], ring.fields["temperature"][:, 0]
        exact = EXACT.rod(r[0]), EXACT.ring(np.maximum(r[1], 10e-3))
        errors.append([np.abs(f - e).max() / e.max() for f, e in zip(found, exact, strict=True)])
        step = result.steps[-1].heat
        assert step.held["ring.outer"] == pytest.approx(-5.0, rel=1e-9)
        assert abs(step.flow["fit"]) == pytest.approx(5.0, rel=1e-9)
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert (rates > 1.7).all(), (rates, errors)
    assert np.max(errors[1]) < 0.01


TUBE = """
title = "Wall of a tube"
dimension = "axisymmetric"
strain = "small"
mechanics = false
heat = {{ scheme = "steady" }}
time = {{ end = "1 s", step = "1 s" }}
[materials.solid]
youngs_modulus = "100 MPa"
poisson_ratio = 0.3
conductivity = "0.2 W/m/K"
[bodies.wall]
material = "solid"
mesh = {{ builder = "block", width = "10 mm", height = "4 mm", corner = ["10 mm", "0 mm"],
 nx = {n}, ny = {m}, cell = "{cell}" }}
""".replace(",\n nx", ", nx")


@pytest.mark.parametrize("cell", ["quadrilateral", "triangle"])
def test_wall_of_a_tube(written, cell):
    """θ = θ_b + P/(2πk) ln(b/r) around the axis, with a flux into the inside: order 2."""
    flux = 5.0 / (2 * np.pi * 10e-3)
    conditions = f'[[conditions]]\non = "wall.left"\nheat_flux = "{flux!r} W/m^2"\n'
    conditions += '[[conditions]]\non = "wall.right"\ntemperature = "0 K"\n'
    errors = []
    for n in (6, 12, 24):
        result = written(TUBE.format(n=n, m=n // 2, cell=cell) + conditions)
        picture = result.heat[0]
        exact = EXACT.ring(picture.points[:, 0])
        error = picture.fields["temperature"][:, 0] - exact
        errors.append(np.sqrt(np.mean(error**2)) / exact.max())
        assert result.steps[-1].heat.loads == pytest.approx(5.0 * 4e-3, rel=1e-12)
        assert result.steps[-1].heat.held["wall.right"] == pytest.approx(-5.0 * 4e-3, rel=1e-9)
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert (rates > 1.8).all(), (rates, errors)
    assert errors[-1] < 1e-3


TWO_TUBES = """
[bodies.core]
material = "solid"
mesh = { builder = "block", width = "10 mm", height = "4 mm", nx = 12, ny = 3 }
[interfaces.fit]
nonmortar = "core.right"
mortar = "wall.left"
heat = { law = "constant", conductance = "150 W/m^2/K", pressure = "1 Pa" }
[[conditions]]
on = "core"
heat_source = "15915.494309189534 W/m^3"
[[conditions]]
on = "wall.right"
temperature = "0 K"
"""


def test_rod_in_a_tube_around_its_axis(written):
    """The rod in a ring once more, seen along its axis: contact area and source per 2πr."""
    errors = []
    for n in (6, 12, 24):
        text = TUBE.format(n=n, m=n // 2, cell="quadrilateral") + TWO_TUBES.replace(
            "nx = 12", f"nx = {n}"
        )
        result = written(text)
        wall, core = result.heat
        errors.append(
            [
                np.abs(picture.fields["temperature"][:, 0] - exact(picture.points[:, 0])).max()
                for picture, exact in ((wall, EXACT.ring), (core, EXACT.rod))
            ]
        )
        assert result.steps[-1].heat.flow["fit"] == pytest.approx(5.0 * 4e-3, rel=1e-9)
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert (rates > 1.6).all(), (rates, errors)
    assert np.max(errors[-1]) < 2e-3 * EXACT.rod(0.0)
