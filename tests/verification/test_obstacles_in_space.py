"""Rigid obstacles in space: uniform pressure on planes of any slope, Hertz's sphere, bores."""

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case import read_case
from contactfem.errors import CaseError
from contactfem.run import run_case

HEAD = """
title = "obstacle"
dimension = "3d"
strain = "small"
time = { end = "1 s", step = "1 s" }
solver = { tolerance = 1e-11 }
output = { figures = false }
[materials.m]
youngs_modulus = "200 MPa"
poisson_ratio = 0.3
"""
CUBE = """
[bodies.cube]
material = "m"
[bodies.cube.mesh]
builder = "box"
width = "1 mm"
height = "1 mm"
depth = "1 mm"
nx = 3
ny = 3
nz = 2
cell = "CELL"
[interfaces.sole]
nonmortar = "cube.bottom"
mortar = "ground"
"""
HELD = """
[[conditions]]
on = "cube.left"
displacement.x = "0 mm"
[[conditions]]
on = "cube.back"
displacement.z = "0 mm"
"""


def solved(tmp_path, text):
    path = tmp_path / "case.toml"
    path.write_text(HEAD + text)
    result = run_case(read_case(path), MPI.COMM_WORLD, None)
    assert result.converged, result.message
    return result


@pytest.mark.mpi
@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
def test_a_cube_on_a_plane_is_pressed_evenly(tmp_path, cell):
    plane = '[obstacles.ground]\nshape = "plane"\npoint = ["0 mm", "0 mm", "0 mm"]\n'
    load = '[[conditions]]\non = "cube.top"\ntraction.y = "-2 MPa"\n'
    text = CUBE.replace("CELL", cell) + plane + "normal = [0, 1, 0]\n" + HELD + load
    result = solved(tmp_path, text)
    if MPI.COMM_WORLD.rank == 0:
        # small strain, but pressures are per current area: the sole widens by ν σ/E twice
        area = (1.0 + 0.3 * 2.0 / 200.0) ** 2
        assert result.interfaces[0].pressure == pytest.approx(2e6 / area, rel=1e-9)
        assert result.steps[-1].forces["sole"][1] == pytest.approx(-2.0, rel=1e-9)


def test_hertz_under_a_rigid_sphere(tmp_path):
    """F = 4/3 E* sqrt(R δ³), a quarter of it, and p_max; 5 cells over the contact radius."""
    text = """
[bodies.half]
material = "m"
[bodies.half.mesh]
builder = "graded_box"
width = "20 mm"
height = "20 mm"
depth = "20 mm"
corner = ["0 mm", "-20 mm", "0 mm"]
zone_x = ["0 mm", "0.6 mm"]
zone_z = ["0 mm", "0.6 mm"]
size = "0.08 mm"
growth = 0.5
coarse = "6 mm"
[obstacles.ball]
shape = "sphere"
center = ["0 mm", "80 mm", "0 mm"]
radius = "80 mm"
displacement.y = "-0.002 mm"
[interfaces.contact]
nonmortar = "half.contact"
mortar = "ball"
[[conditions]]
on = "half.bottom"
displacement.y = "0 mm"
[[conditions]]
on = "half.left"
displacement.x = "0 mm"
[[conditions]]
on = "half.back"
displacement.z = "0 mm"
"""
    result = solved(tmp_path, text)
    E = 200e6 / (1 - 0.3**2)
    force = 4.0 / 3.0 * E * np.sqrt(80e-3 * 2e-6**3) / 4.0
    peak = 2.0 * E / np.pi * np.sqrt(2e-6 / 80e-3)
    # the block is 50 contact radii high and wide, which makes it 1.5 to 3 % stiffer
    assert abs(result.steps[-1].forces["contact"][1]) == pytest.approx(force, rel=0.05)
    assert result.interfaces[0].pressure.max() == pytest.approx(peak, rel=0.03)


def test_a_rod_swells_in_a_bore(tmp_path):
    """Plane strain: a rod that is 20 um too large for its rigid bore."""
    text = """
[bodies.rod]
material = "m"
[bodies.rod.mesh]
builder = "extrusion"
depth = "1 mm"
layers = 2
plane = { builder = "disk", radius = "2 mm", facets = 48, layers = 6 }
[obstacles.bore]
shape = "cylinder"
point = ["0 mm", "0 mm", "0 mm"]
axis = [0, 0, 1]
radius = "2 mm"
inside = true
[interfaces.fit]
nonmortar = "rod.rim"
mortar = "bore"
interference = "20 um"
[[conditions]]
on = "rod.back"
displacement.z = "0 mm"
[[conditions]]
on = "rod.front"
displacement.z = "0 mm"
[[conditions]]
on = "rod"
at = ["0 mm", "0 mm", "0 mm"]
displacement = ["0 mm", "0 mm", "0 mm"]
[[conditions]]
on = "rod"
at = ["2.00285946 mm", "0 mm", "0 mm"] # round in the mean over a facet
displacement.y = "0 mm"
"""
    result = solved(tmp_path, text)
    # u = -p R (1 + ν)(1 - 2ν) / E, p per area where the rod then is; it is round to 1e-3 of u
    pressure = 20e-6 / 2e-3 * 200e6 / (1.3 * 0.4) / (1.0 - 20e-6 / 2e-3)
    assert result.interfaces[0].pressure.mean() == pytest.approx(pressure, rel=0.005)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ('shape = "circle"\ncenter = ["0 mm", "0 mm"]\nradius = "1 mm"', "has plane, sphere"),
        ('shape = "plane"\npoint = ["0 mm", "0 mm"]\nnormal = [0, 1]', "3 coordinates"),
    ],
)
def test_plane_figures_are_refused_in_space(tmp_path, table, words):
    text = CUBE.replace("CELL", "hexahedron") + f"[obstacles.ground]\n{table}\n" + HELD
    with pytest.raises(CaseError, match=words):
        solved(tmp_path, text)
