"""A nonmortar face that is led as a whole has no multiplier: refused, and right when exchanged."""

import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.errors import CaseError
from contactfem.results.measures import measure
from contactfem.run.driver import run_case

LED = """
title = "A face led 0.7 mm over a gap of 0.5 mm"
strain = "small"
time = { end = "1 s", step = "0.5 s" }
materials.m = { youngs_modulus = "10 MPa", poisson_ratio = 0.0 }
[bodies.low]
material = "m"
mesh = { builder = "block", width = "10 mm", height = "10 mm", nx = 6, ny = 6 }
[bodies.up]
material = "m"
[bodies.up.mesh]
builder = "block"
width = "10 mm"
height = "6 mm"
corner = ["0 mm", "10.5 mm"]
nx = 10
ny = 5
[interfaces.c]
nonmortar = "up.bottom"
mortar = "low.top"
[[conditions]]
on = "low.bottom"
displacement = ["0 mm", "0 mm"]
[[conditions]]
on = "up.bottom"
KIND = { x = "0 mm", y = [["0 s", "0 mm"], ["1 s", "-0.7 mm"]] }
"""
CONDITIONS = {
    "displacement": LED.replace("KIND", "displacement"),
    "grip": LED.replace("KIND", "grip.displacement"),
}


@pytest.mark.parametrize("kind", CONDITIONS)
def test_a_led_face_is_refused_as_nonmortar(tmp_path, kind):
    path = tmp_path / "case.toml"
    path.write_text(CONDITIONS[kind])
    with pytest.raises(CaseError, match=r"interface c: .*exchange nonmortar and mortar"):
        run_case(read_case(path), MPI.COMM_SELF, None)


@pytest.mark.parametrize("kind", CONDITIONS)
def test_a_led_face_as_mortar_side(tmp_path, kind):
    """E d / l over the width: 10 MPa 0.2 mm / 10 mm 10 mm, on the body below."""
    path = tmp_path / "case.toml"
    path.write_text(CONDITIONS[kind])
    sides = ["interfaces.c.nonmortar=low.top", "interfaces.c.mortar=up.bottom"]
    found = measure(run_case(read_case(path, sides), MPI.COMM_SELF, None))
    assert found["c.normal_force"] == pytest.approx(2e3, rel=1e-9)
