"""Tied interfaces, rough contact, interference, clearance, adjusted gaps: against closed forms."""

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case import read_case
from contactfem.errors import CaseError
from contactfem.run import run_case

SCENE = """
title = "two blocks"
dimension = "plane strain"
strain = "{strain}"
time = {{ end = "1 s", step = "1 s" }}
solver = {{ tolerance = 1e-12 }}
[materials.a]
youngs_modulus = "1000 MPa"
poisson_ratio = 0.3
[materials.b]
youngs_modulus = "3000 MPa"
poisson_ratio = 0.2
[bodies.lower]
material = "a"
mesh = {{ builder = "block", width = "1 mm", height = "1 mm", nx = {nx}, ny = 3 }}
[bodies.upper]
material = "{other}"
[bodies.upper.mesh]
builder = "block"
width = "1 mm"
height = "1 mm"
corner = ["0 mm", "{y} mm"]
nx = 5
ny = 3
[interfaces.joint]
nonmortar = "lower.top"
mortar = "upper.bottom"
{laws}
[[conditions]]
on = "lower.bottom"
displacement.y = "0 mm"
[[conditions]]
on = "lower"
at = ["0 mm", "0 mm"]
displacement = ["0 mm", "0 mm"]
[[conditions]]
on = "upper"
at = ["0 mm", "{top} mm"]
displacement.x = "0 mm"
{conditions}
[output]
figures = false
"""
UPPER_FIXED = '[[conditions]]\non = "upper.top"\ndisplacement.y = "0 mm"'
PULLED = '[[conditions]]\non = "upper.top"\ntraction.y = "10 MPa"'


def solved(tmp_path, laws, conditions, *, nx=3, y=1.0, strain="small", other="b"):
    path = tmp_path / "case.toml"
    words = {"laws": laws, "conditions": conditions, "nx": nx, "y": y, "top": y + 1.0}
    path.write_text(SCENE.format(strain=strain, other=other, **words))
    result = run_case(read_case(path), MPI.COMM_SELF, None)
    assert result.converged, result.message
    return result


def stresses(result):
    return np.concatenate([body.fields["stress"] for body in result.bodies])


@pytest.mark.parametrize("nx", [3, 5, 7])
@pytest.mark.parametrize("strain", ["small", "finite"])
def test_tied_bodies_are_one_under_tension(tmp_path, nx, strain):
    """Equal materials: σ_yy = 10 MPa of the strip pulled as one, whatever the meshes."""
    tied = 'normal.law = "tied"'
    result = solved(tmp_path, tied, PULLED, nx=nx, strain=strain, other="a")
    stress = stresses(result)
    assert np.ptp(stress[:, 1]) < 1e-9 * 1e7
    assert result.steps[0].forces["joint"][1] == pytest.approx(-1e4, rel=1e-9)  # pulled on
    if strain == "small":
        assert stress[:, 1] == pytest.approx(1e7, rel=1e-9)
    assert abs(stress[:, 3]).max() < 1e-2
    assert np.ptp(result.interfaces[0].pressure) < 1e-9 * 1e7


def test_tied_bodies_carry_shear(tmp_path):
    """A pure shear of 10 MPa on all sides passes."""
    sides = [
        ("lower.left", "y", -1), ("lower.right", "y", 1), ("upper.left", "y", -1),
        ("upper.right", "y", 1), ("upper.top", "x", 1), ("lower.bottom", "x", -1),
    ]  # fmt: skip
    loads = "\n".join(
        f'[[conditions]]\non = "{on}"\ntraction.{axis} = "{10 * sign} MPa"'
        for on, axis, sign in sides
    )
    path = tmp_path / "case.toml"
    text = SCENE.format(
        strain="small", other="b", laws='normal.law = "tied"', conditions=loads, nx=3, y=1.0,
        top=2.0,
    )  # fmt: skip
    # three held components alone: a corner, and another one in y
    start, end = text.index('[[conditions]]\non = "lower.bottom"'), text.index(loads)
    held = (
        '[[conditions]]\non = "lower"\nat = ["0 mm", "0 mm"]\ndisplacement = ["0 mm", "0 mm"]\n'
        '[[conditions]]\non = "lower"\nat = ["1 mm", "0 mm"]\ndisplacement.y = "0 mm"\n'
    )
    path.write_text(text[:start] + held + text[end:])
    result = run_case(read_case(path), MPI.COMM_SELF, None)
    assert result.converged, result.message
    stress = stresses(result)
    assert stress[:, 3] == pytest.approx(1e7, rel=1e-8)
    assert abs(stress[:, :2]).max() < 0.1


@pytest.mark.parametrize("gap", [0.001, -0.002])
def test_small_gaps_of_tied_meshes_make_no_stress(tmp_path, gap):
    laws = 'normal.law = "tied"\nadjust = "0.01 mm"'
    result = solved(tmp_path, laws, UPPER_FIXED, y=1.0 + gap)
    assert abs(stresses(result)).max() < 1e-3


def test_tied_surfaces_that_are_apart_are_refused(tmp_path):
    with pytest.raises(CaseError, match=r"smallest gap is 0\.0005 m; give adjust"):
        solved(tmp_path, 'normal.law = "tied"\nsearch_radius = "1 mm"', UPPER_FIXED, y=1.5)


def pressed_by(interference):
    """Pressure of two strips in plane strain with free sides that are too high for their place."""
    compliance = 1e-3 * ((1 - 0.3**2) / 1e9 + (1 - 0.2**2) / 3e9)
    return interference / compliance


def test_interference_presses(tmp_path):
    laws = 'interference = "1 um"'
    result = solved(tmp_path, laws, UPPER_FIXED)
    assert stresses(result)[:, 1] == pytest.approx(-pressed_by(1e-6), rel=1e-3)


def test_interference_grows_with_time(tmp_path):
    laws = 'interference = [["0 s", "0 um"], ["0.5 s", "4 um"], ["1 s", "2 um"]]'
    result = solved(tmp_path, laws, UPPER_FIXED)
    assert stresses(result)[:, 1] == pytest.approx(-pressed_by(2e-6), rel=3e-3)


def test_clearance_is_closed_first(tmp_path):
    down = '[[conditions]]\non = "upper.top"\ndisplacement.y = "-3 um"'
    result = solved(tmp_path, 'clearance = "1 um"', down)
    assert stresses(result)[:, 1] == pytest.approx(-pressed_by(2e-6), rel=3e-3)
    down = down.replace("-3", "-0.5")
    assert abs(stresses(solved(tmp_path, 'clearance = "1 um"', down))).max() < 1e-3


@pytest.mark.parametrize("gap", [0.001, -0.002])
def test_adjusted_gaps_of_contact_count_as_none(tmp_path, gap):
    """3 um down press as bodies that touched would be pressed."""
    down = '[[conditions]]\non = "upper.top"\ndisplacement.y = "-3 um"'
    result = solved(tmp_path, 'adjust = "0.01 mm"', down, y=1.0 + gap)
    assert stresses(result)[:, 1] == pytest.approx(-pressed_by(3e-6), rel=5e-3)


def test_rough_contact_never_slips(tmp_path):
    """As friction with a coefficient that is never reached."""
    down = '[[conditions]]\non = "upper.top"\ndisplacement.y = "-3 um"'
    rough = solved(tmp_path, 'friction = "rough"', down)
    high = solved(tmp_path, "friction.coefficient = 100.0", down)
    assert rough.interfaces[0].pressure == pytest.approx(high.interfaces[0].pressure, rel=1e-9)
    assert (rough.interfaces[0].status == 1).all()


@pytest.mark.parametrize("key", ['interference = "1 um"', 'friction = "rough"'])
def test_tied_takes_no_laws_of_contact(tmp_path, key):
    with pytest.raises(CaseError, match="does not go with normal"):
        solved(tmp_path, f'normal.law = "tied"\n{key}', UPPER_FIXED)


def box(name: str, y: float, nx: int, nz: int, cell: str) -> str:
    held = "".join(
        f'[[conditions]]\non = "{name}.{side}"\ndisplacement.{axis} = "0 mm"\n'
        for side, axis in (("left", "x"), ("right", "x"), ("back", "z"), ("front", "z"))
    )
    return (
        f'[bodies.{name}]\nmaterial = "m"\n[bodies.{name}.mesh]\nbuilder = "box"\n'
        f'width = "1 mm"\nheight = "1 mm"\ndepth = "1 mm"\ncorner = ["0 mm", "{y} mm", "0 mm"]\n'
        f'nx = {nx}\nny = 2\nnz = {nz}\ncell = "{cell}"\n{held}'
    )


def test_tied_bodies_in_space_are_one_under_tension(tmp_path):
    """Tetrahedra on hexahedra pulled by 10 MPa between smooth walls: σ_yy everywhere."""
    path = tmp_path / "case.toml"
    path.write_text(
        'title = "tied"\ndimension = "3d"\nstrain = "small"\n'
        'time = { end = "1 s", step = "1 s" }\noutput = { figures = false }\n'
        '[materials.m]\nyoungs_modulus = "1000 MPa"\npoisson_ratio = 0.4\n'
        + box("lower", 0.0, 3, 3, "hexahedron")
        + box("upper", 1.0, 5, 4, "tetrahedron")
        + '[interfaces.joint]\nnonmortar = "lower.top"\nmortar = "upper.bottom"\n'
        'normal.law = "tied"\n[[conditions]]\non = "lower.bottom"\ndisplacement.y = "0 mm"\n'
        '[[conditions]]\non = "upper.top"\ntraction.y = "10 MPa"\n'
    )
    result = run_case(read_case(path), MPI.COMM_SELF, None)
    assert result.converged, result.message
    assert stresses(result)[:, 1] == pytest.approx(1e7, rel=1e-10)
    assert result.steps[0].forces["joint"][1] == pytest.approx(-10.0, rel=1e-10)
