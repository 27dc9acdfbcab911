"""Surfaces find each other however far apart they start and however far they are led."""

import textwrap

import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.check.check import check_case
from contactfem.results.expectations import judge
from contactfem.results.measures import measure
from contactfem.run.driver import run_case

BLOCKS = """
title = "A block led towards another"
strain = "{strain}"
time = {{ end = "1 s", step = "1 s" }}
materials.m = {{ youngs_modulus = "10 MPa", poisson_ratio = 0.0 }}
[bodies.low]
material = "m"
mesh = {{ builder = "block", width = "10 mm", height = "{low} mm", nx = 6, ny = 6 }}
[bodies.up]
material = "m"
[bodies.up.mesh]
builder = "block"
width = "10 mm"
height = "{up} mm"
corner = ["0 mm", "{start} mm"]
nx = 10
ny = 5
[interfaces.c]
nonmortar = "up.bottom"
mortar = "low.top"
[[conditions]]
on = "low.bottom"
displacement = ["0 mm", "0 mm"]
[[conditions]]
on = "up.top"
displacement = ["0 mm", "{led} mm"]
"""


def blocks(folder, *, low=10.0, up=6.0, gap=0.5, led=-4.0, strain="small", more=""):
    path = folder / "case.toml"
    text = BLOCKS.format(low=low, up=up, start=low + gap, led=led, strain=strain)
    path.write_text(text + textwrap.dedent(more))
    return read_case(path)


def solved(case, comm=MPI.COMM_SELF):
    result = run_case(case, comm, None)
    assert result.converged, result.message
    return measure(result)


@pytest.mark.parametrize(
    ("low", "up", "gap", "led"),
    [(10, 6, 0.5, -4), (10, 2, 0.5, -4), (10, 6, 30, -33), (4, 6, -2, 0)],
    ids=["through the gap", "further than it is thick", "from far away", "overlap at the start"],
)
def test_led_through_a_gap_in_one_step(tmp_path, low, up, gap, led):
    """Two bars in a row, nu = 0: F = E A d / (l1 + l2), d = the gap passed by the led motion."""
    found = solved(blocks(tmp_path, low=low, up=up, gap=gap, led=led))
    assert found["c.force_y"] == pytest.approx(-1e7 * 0.01 * -(led + gap) / (low + up), rel=1e-9)


@pytest.mark.mpi
def test_ranks_find_the_same(tmp_path):
    case = blocks(MPI.COMM_WORLD.bcast(tmp_path), low=10.0, up=2.0)
    found = solved(case, MPI.COMM_WORLD)
    assert found["c.force_y"] == pytest.approx(-1e5 * 3.5 / 12.0, rel=1e-9)


def test_a_given_radius_stays(tmp_path):
    """Nothing is found beyond it, and a number that nothing measures is not met."""
    more = """
    [expect]
    "c.gap_min" = { min = "-1 m" }
    """
    case = blocks(tmp_path, gap=0.5, led=0.0, more=more)
    assert all(v.passed for v in judge(case, solved(case)))
    near = read_case(case.path, ["interfaces.c.search_radius=0.1 mm"])
    assert "search: gaps and overlaps up to 0.1 mm" in check_case(near)
    (verdict,) = judge(near, solved(near))
    assert not verdict.passed


def test_check_says_gap_overlap_and_range(tmp_path):
    text = check_case(blocks(tmp_path, gap=-2.0))
    assert "overlap 2 mm at (0, 0.008) m, which contact pushes apart" in text
    assert "search: gaps of any width, overlaps up to 10 mm" in text


PLANE = """
title = "Pushed along a plane by a wall that is led far away"
strain = "small"
time = { end = "1 s", step = "0.1 s" }
materials.m = { youngs_modulus = "10 MPa", poisson_ratio = 0.0 }
[bodies.b]
material = "m"
mesh = { builder = "block", width = "10 mm", height = "5 mm", nx = 6, ny = 3 }
[obstacles.ground]
shape = "plane"
point = ["5 mm", "0 mm"]
normal = [0.0, 1.0]
[obstacles.wall]
shape = "plane"
point = ["0 mm", "0 mm"]
normal = [1.0, 0.0]
displacement.x = [["0 s", "0 mm"], ["1 s", "900 mm"]]
[interfaces.sole]
nonmortar = "b.bottom"
mortar = "ground"
[interfaces.push]
nonmortar = "b.left"
mortar = "wall"
[[conditions]]
on = "b.top"
displacement.y = "-0.1 mm"
[[conditions]]
on = "b.right"
traction.x = "-1 kPa"
"""


def test_planes_do_not_end(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(PLANE)
    found = solved(read_case(path))
    assert found["sole.force_y"] == pytest.approx(-2e3, rel=1e-6)
