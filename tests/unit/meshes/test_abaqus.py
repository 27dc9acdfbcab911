"""Input files of Abaqus, CalculiX and FreeCAD: cells, sets, surfaces, parts, and clear errors."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from contactfem.errors import MeshError
from contactfem.meshes.abaqus import read_abaqus
from contactfem.meshes.abaqus_elements import FACES, element_type
from contactfem.meshes.data import MeshData, jacobians
from contactfem.meshes.file import MeshFile

# two squares beside each other:  4 5 6
#                                 1 2 3
NODES = """*Heading
 a plate
** comment
*Node, nset=Nall
1, 0., 0.
2, 1., 0.
3, 2., 0.
4, 0., 1.
5, 1.0D+00, 1.
6, 2., 1., 0.
"""
QUADS = """*Element, type=CPE4R,
 elset=plate
11, 1, 2, 5, 4
12, 2, 3, 6, 5
"""
PLATE = NODES + QUADS


def write(folder: Path, text: str) -> Path:
    path = folder / "mesh.inp"
    path.write_text(text)
    return path


def build(folder: Path, text: str, **more: Any) -> MeshData:
    return MeshFile(file=write(folder, text), unit=1.0, **more).build()


def places(data: MeshData, name: str) -> list[list[float]]:
    return sorted(map(list, data.points[np.unique(data.groups[name])]))


def test_sets_of_nodes_become_boundary_facets(tmp_path: Path) -> None:
    text = PLATE + "*NSET, NSET=foot, GENERATE\n1, 3, 1\n*Nset, nset=Corner\nfoot, 4\n"
    data = build(tmp_path, text)
    assert data.cell_type == "quadrilateral"
    np.testing.assert_array_equal(data.groups["foot"], [[0, 1], [1, 2]])
    assert places(data, "Corner") == [[0, 0], [0, 1], [1, 0], [2, 0]]
    assert len(data.groups["Corner"]) == 3
    assert len(data.groups["Nall"]) == 6  # the edge between the squares is no boundary


def test_surfaces_of_faces(tmp_path: Path) -> None:
    """By element, by set of elements, of sets of sets, and all that are free."""
    text = (
        PLATE
        + "*Elset, elset=_foot_S1, internal, generate\n11, 12\n*Elset, elset=all\nPLATE,\n"
        + "*Surface, type=ELEMENT, name=foot\n_foot_S1, S1\n*Surface, name=ends\n11, S4\n12, S2\n"
        + "*Surface, name=around\nall,\n*Surface, type=NODE, name=top\n4,\n5,\n6,\n"
    )
    data = build(tmp_path, text, body="ALL".lower())
    assert set(data.groups) == {"Nall", "foot", "ends", "around", "top"}
    np.testing.assert_array_equal(data.groups["foot"], [[0, 1], [1, 2]])
    assert sorted(map(tuple, np.sort(data.groups["ends"]))) == [(0, 3), (2, 5)]
    assert len(data.groups["around"]) == 6
    assert places(data, "top") == [[0, 1], [1, 1], [2, 1]]


@pytest.mark.parametrize(
    ("name", "kind", "nodes"),
    [
        *(("CPE3", "triangle", 3), ("CAX6M", "triangle", 6), ("CPS8R", "quad", 8)),
        *(("CPE4RT", "quad", 4), ("DCAX4", "quad", 4), ("CPEG4H", "quad", 4)),
        *(("C3D4", "tetra", 4), ("C3D10M", "tetra", 10), ("C3D5", "pyramid", 5)),
        *(("C3D6", "wedge", 6), ("C3D15", "wedge", 15), ("C3D8I", "hexahedron", 8)),
        *(("C3D20RHT", "hexahedron", 20), ("DC3D8", "hexahedron", 8), ("SC8R", "hexahedron", 8)),
        *(
            ("S4R5", "quad", 4),
            ("S8R", "quad", 8),
            ("STRI65", "triangle", 6),
            ("S6", "triangle", 6),
        ),
        *(("T3D2", "line", 2), ("T3D3", "line", 3), ("B21", "line", 2), ("B32", "line", 3)),
    ],
)
def test_types_of_elements(name: str, kind: str, nodes: int) -> None:
    found = element_type(name)
    assert found is not None
    assert (found.kind, found.nodes) == (kind, nodes)


@pytest.mark.parametrize("name", ["MASS", "SPRINGA", "CONN3D2", "CPE5", "C3D7", "DCOUP3D", "B33"])
def test_elements_that_are_no_cells(name: str) -> None:
    assert element_type(name) is None


SOLIDS = {
    "tetra": ("C3D4", [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    "wedge": ("C3D6", [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]]),
    "pyramid": ("C3D5", [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1]]),
    "hexahedron": (
        "C3D8",
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", SOLIDS)
def test_faces_of_solids(tmp_path: Path, kind: str) -> None:
    """S1 and S2 are the two ends, S3 the side at y = 0 of a brick; all of them close the cell."""
    name, corners = SOLIDS[kind]
    text = "*NODE\n" + "".join(f"{k},{x},{y},{z}\n" for k, (x, y, z) in enumerate(corners, 1))
    text += f"*ELEMENT, TYPE={name}\n7, {', '.join(str(k + 1) for k in range(len(corners)))}\n"
    for k in range(len(FACES[kind])):
        text += f"*SURFACE, NAME=s{k + 1}\n7, S{k + 1}\n"
    data = build(tmp_path, text)
    assert places(data, "s1") == sorted(x for x in corners if x[2] == 0)
    if kind == "hexahedron":
        assert places(data, "s2") == sorted(x for x in corners if x[2] == 1)
        assert places(data, "s3") == sorted(x for x in corners if x[1] == 0)
        assert places(data, "s4") == sorted(x for x in corners if x[0] == 1)
    normals = np.zeros(3)
    count = 0
    for facets in data.groups.values():
        for facet in facets:
            a, b, c = data.points[facet[:3]]
            normals += np.cross(b - a, c - a) * (1.0 if len(facet) == 4 else 0.5)
            count += 1 if len(facet) == 3 else 2
    np.testing.assert_allclose(normals, 0.0, atol=1e-14)
    expected = {"tetra": 4, "pyramid": 6, "wedge": 8, "hexahedron": 12}
    assert count == expected[kind]


def test_second_order_over_two_lines(tmp_path: Path) -> None:
    """A brick of 20 nodes takes two lines; its corners are taken, and that is said."""
    corners = np.array(SOLIDS["hexahedron"][1], dtype=float)
    nodes = np.concatenate([corners, np.full((12, 3), 0.5)])
    text = "*NODE\n" + "".join(f"{k},{x},{y},{z}\n" for k, (x, y, z) in enumerate(nodes, 1))
    text += "*ELEMENT, TYPE=C3D20R, ELSET=brick\n"
    text += "3, 1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,\n16,17,18,19,20\n"
    mesh = MeshFile(file=write(tmp_path, text), unit=2.0, body="brick")
    data = mesh.build()
    assert len(data.points) == 8
    assert jacobians(data.points, data.cells, "hexahedron") == pytest.approx(8.0)
    assert "1 cells of the file are of second or higher order" in mesh.read.notes[0]


ASSEMBLY = f"""*Part, name=Square
{NODES}{QUADS}*Nset, nset=foot
1, 2, 3
*Surface, name=right
12, S2
*End Part
*Assembly, name=Assembly
*Instance, name=Left, part=square
*End Instance
*Instance, name=Turned, part=Square
10., 0., 0.
10., 0., 0., 10., 0., 1., 90.
*End Instance
*Node
1, 99., 99., 99.
*Nset, nset=ends, instance=Left
1, 4
*Nset, nset=ends
Turned.3, Turned.6
*End Assembly
*Step
*Static
*End Step
"""


def test_instances_are_where_the_assembly_puts_them(tmp_path: Path) -> None:
    """The turned one is shifted first and then stands upright, to the left of x = 10."""
    turned = build(tmp_path, ASSEMBLY, body="Turned")
    assert turned.points.min(axis=0) == pytest.approx([9.0, 0.0])
    assert turned.points.max(axis=0) == pytest.approx([10.0, 2.0])
    foot = turned.points[np.unique(turned.groups["foot"])]
    np.testing.assert_allclose(foot, [[10, 0], [10, 1], [10, 2]], atol=1e-12)
    for name in ("right", "Turned.right", "ends"):
        np.testing.assert_allclose(
            turned.points[np.unique(turned.groups[name])][:, 1], 2.0, err_msg=name
        )
    left = build(tmp_path, ASSEMBLY, body="Left")
    assert left.points.max(axis=0) == pytest.approx([2.0, 1.0])
    assert places(left, "ends") == [[0, 0], [0, 1]]
    np.testing.assert_array_equal(left.groups["Left.foot"], left.groups["foot"])


def test_turn_about_an_oblique_axis(tmp_path: Path) -> None:
    """A third of a turn about x = y = z carries x to y and y to z."""
    text = ASSEMBLY.replace("10., 0., 0.\n10., 0., 0., 10., 0., 1., 90.", "0,0\n0,0,0,1,1,1,120")
    raw = read_abaqus(write(tmp_path, text))
    left, turned = raw.points[1:7], raw.points[7:]
    np.testing.assert_allclose(turned, np.roll(left, 1, axis=1), atol=1e-12)


def test_cylindrical_coordinates_and_included_files(tmp_path: Path) -> None:
    (tmp_path / "nodes.txt").write_text(
        "*NODE, SYSTEM=C\n1, 1., 0.\n2, 2., 0.\n3, 2., 90.\n4, 1., 90.\n"
    )
    text = "*INCLUDE, INPUT=nodes.txt\n*ELEMENT, TYPE=CAX4\n1, 1, 2, 3, 4\n"
    data = build(tmp_path, text)
    np.testing.assert_allclose(data.points, [[1, 0], [2, 0], [0, 2], [0, 1]], atol=1e-15)


def test_elements_that_are_no_cells_are_left_out_and_named(tmp_path: Path) -> None:
    text = PLATE + "*ELEMENT, TYPE=MASS, ELSET=heavy\n50, 3\n*ELSET, ELSET=both\n50, 11, heavy\n"
    text += "*SURFACE, TYPE=CYLINDER, NAME=roll\n0,0,0,1,0,0\n"
    raw = read_abaqus(write(tmp_path, text))
    assert len(raw.groups["both"]["quad"]) == 1
    assert raw.notes[0] == "line 15: elements of type MASS are left out"
    assert raw.notes[1].startswith("line 19: the surface 'roll' is left out")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "has no *NODE and *ELEMENT"),
        ("1, 2\n", "line 1: no keyword"),
        (NODES, "has no *NODE and *ELEMENT"),
        (NODES.replace("2., 0.", "2., zero"), "line 7: '3, 2., zero' is not numbers"),
        (NODES.replace("3, 2.", "3.5, 2."), "line 7: 3.5 is not the number of a node"),
        (NODES.replace("3, 2.", "nan, 2."), "line 7: nan is not the number of a node"),
        (PLATE.replace("12, 2, 3", "12, 2, 33"), "line 14: there is no node 33"),
        (PLATE.replace("12, 2", "11, 2"), "line 14: there is an element 11 already"),
        (PLATE.replace("6, 5\n", "6\n"), "line 14: an element of type CPE4R has 4 nodes; found 3"),
        (PLATE.replace("6, 5\n", "6, 5, 4, 3\n"), "has 4 nodes; found 6"),
        (PLATE.replace("type=CPE4R,\n elset", "elset"), "line 11: *ELEMENT has no TYPE="),
        (PLATE + "*NSET, NSET=a\n1, b\n", "line 16: there is no set of nodes 'b'; there are: Nall"),
        (PLATE + "*ELSET, ELSET=a\n99\n", "line 16: *ELSET names the element 99, which is not"),
        (PLATE + "*NSET, NSET=a, GENERATE\n1, 6, 0\n", "line 16: a range is a first label"),
        (PLATE + "*SURFACE, NAME=a\n11, S5\n", "line 16: quad elements have no face S5"),
        (PLATE + "*SURFACE, NAME=a\nnone, S1\n", "line 16: there is no set of elements 'none'"),
        (PLATE + "*NGEN, NSET=a\n1, 6\n", "line 15: *NGEN is not read"),
        (PLATE + "*INCLUDE, INPUT=b.inp\n", "line 15: *INCLUDE names 'b.inp': there is no"),
        (PLATE + "*INCLUDE, INPUT=mesh.inp\n", "nested too deep"),
        (NODES.replace("nset=Nall", "system=X"), "line 4: *NODE has coordinates in a system 'X'"),
        (ASSEMBLY.replace("part=square", "part=round"), "is of the part 'round', which is not"),
        (ASSEMBLY.replace("name=Turned", "name=left"), "line 24: *INSTANCE is named 'left', as"),
        (ASSEMBLY.replace("instance=Left", "instance=Lift"), "the instance 'Lift', which is not"),
        (ASSEMBLY.replace("10., 0., 1., 90", "90"), "a motion that is not 3 numbers"),
        (ASSEMBLY.replace("10., 0., 1., 90", "10., 0., 0., 90"), "whose two points are one"),
    ],
)  # fmt: skip
def test_what_is_not_understood_is_one_sentence_with_its_line(
    tmp_path: Path, text: str, words: str
) -> None:
    with pytest.raises(MeshError) as caught:
        read_abaqus(write(tmp_path, text))
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
