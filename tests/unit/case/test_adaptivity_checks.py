"""What adaptivity asks for has to fit the rest of a case; check says it in words."""

import numpy as np
import pytest

from contactfem.case.read import read_case
from contactfem.check.check import check_case
from contactfem.errors import CaseError

CASE = """
title = "A block"
time = {{ end = "1 s", step = "1 s" }}
adaptivity = {{ {adaptivity} }}
{more}
[materials.solid]
youngs_modulus = "1 MPa"
poisson_ratio = 0.3
conductivity = "1 W/m/K"
[bodies.block]
material = "solid"
mesh = {{ {mesh} }}
[[conditions]]
on = "block.{held}"
displacement.y = "0 mm"
"""
BLOCK = 'builder = "block", width = "2 mm", height = "1 mm", nx = 2, ny = 2'
HEAT = '[heat]\nscheme = "steady"\n[[conditions]]\non = "block.top"\ntemperature = "0 K"'


def case_of(folder, adaptivity, more="", mesh=BLOCK, held="bottom"):
    path = folder / "case.toml"
    path.write_text(CASE.format(adaptivity=adaptivity, more=more, mesh=mesh, held=held))
    return read_case(path)


@pytest.mark.parametrize(
    ("adaptivity", "more", "said"),
    [
        ('heat = "5 %"', "", "adaptivity.heat: heat is not solved for; add [heat]"),
        ('mechanics = "5 %", time = "5 %"', "", "adaptivity.time: heat is not solved for"),
        ('time = "5 %"', HEAT, "adaptivity.time: a steady temperature has no error in time"),
        ('mechanics = "5 %"', f"mechanics = false\n{HEAT}", "adaptivity.mechanics: bodies do not"),
        (
            'tolerance = "5 %", bodies = ["blok"]',
            "",
            "adaptivity.bodies = blok: there is no body 'blok'; did you mean 'block'?",
        ),
        (
            'tolerance = "5 %", size_min = "2 mm", size_max = "1 mm"',
            "",
            "adaptivity.size_min = 0.002 m: is larger than size_max = 0.001 m",
        ),
        ('tolerance = "5 %"', 'dimension = "3d"', "only plane bodies have adapted meshes"),
        (
            'mechanics = "5 %", aspect = 20',
            "",
            "adaptivity.aspect = 20: heat is not solved for; add [heat]",
        ),
        ('heat = "5 %", aspect = 20', HEAT, "aspect = 20: there are no interfaces"),
        ('bodies = ["block"]', "", "give a tolerance, or one for mechanics, heat or time"),
    ],
)
def test_contradictions_are_refused(tmp_path, adaptivity, more, said):
    mesh, held = BLOCK, "bottom"
    if "3d" in more:
        mesh = BLOCK.replace('"block"', '"box"') + ', depth = "1 mm", nz = 2'
    with pytest.raises(CaseError) as caught:
        case_of(tmp_path, adaptivity, more, mesh, held)
    assert said in str(caught.value)


def test_a_mesh_in_two_pieces_is_refused_before_the_run(tmp_path):
    import meshio

    square = np.array([[0, 0], [1, 0], [0, 1]], float)
    points = np.column_stack((np.vstack((square, square + 5.0)), np.zeros(6)))
    cells = [("triangle", np.array([[0, 1, 2], [3, 4, 5]])), ("line", np.array([[0, 1]]))]
    tags = [np.array([1, 1]), np.array([2])]
    mesh = meshio.Mesh(points, cells, cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags})
    mesh.field_data = {"body": np.array([1, 2]), "foot": np.array([2, 1])}
    meshio.write(tmp_path / "two.msh", mesh, file_format="gmsh22", binary=False)
    given = 'file = "two.msh", unit = "mm"'
    with pytest.raises(CaseError, match=r"adaptivity needs its geometry: .*in 2 pieces"):
        case_of(tmp_path, 'tolerance = "5 %"', mesh=given, held="foot")


def test_check_says_what_adapts(tmp_path):
    text = check_case(case_of(tmp_path, 'tolerance = "5 %", size_min = "10 um"'))
    assert "errors asked for, ratios of norms: stress 5 %" in text
    assert "block; cells of 10 um to 1/8 of the extent" in text or "10 µm" in text
