"""Meshes from files: groups, units, bodies, and one clear error for each bad file."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from pydantic import ValidationError

from contactfem.errors import MeshError
from contactfem.meshes import readers
from contactfem.meshes.data import jacobians
from contactfem.meshes.file import MeshFile
from contactfem.meshes.gmsh_session import gmsh_session
from contactfem.meshes.raw import corners


def read(path: Path, **more: Any) -> MeshFile:
    table = {"file": path.name, "unit": "mm"} | more
    return MeshFile.model_validate(table, context={"folder": path.parent, "strict_units": True})


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    """Writes two squares of side 2, `lower` of quadrilaterals below `upper` of triangles."""

    def draw(order: int = 1, tilt: float = 0.0) -> Path:
        with gmsh_session() as gmsh:
            for k, body in enumerate(("lower", "upper")):
                square = gmsh.model.occ.addRectangle(0, 2.1 * k, 0.5, 2, 2)
                gmsh.model.occ.rotate([(2, square)], 0, 0, 0, 1, 0, 0, tilt)
                gmsh.model.occ.synchronize()
                sides = [tag for _, tag in gmsh.model.getBoundary([(2, square)], oriented=False)]
                for curve in sides:
                    gmsh.model.mesh.setTransfiniteCurve(curve, 4)
                gmsh.model.mesh.setTransfiniteSurface(square)
                if not k:
                    gmsh.model.mesh.setRecombine(2, square)
                gmsh.model.addPhysicalGroup(2, [square], name=body)
                gmsh.model.addPhysicalGroup(1, [sides[0]], name=f"{body} base")
                gmsh.model.addPhysicalGroup(1, [sides[2]], tag=70 + k)
            gmsh.model.mesh.generate(2)
            gmsh.model.mesh.setOrder(order)
            gmsh.write(str(tmp_path / "two.msh"))
        return tmp_path / "two.msh"

    return draw


@pytest.mark.parametrize(
    ("body", "cell", "bottom"), [("lower", "quadrilateral", 0), ("upper", "triangle", 2.1)]
)
def test_one_body_of_a_gmsh_file(
    write: Callable[..., Path], body: str, cell: str, bottom: float
) -> None:
    """Cells in dolfinx order, lengths in metres, groups by name or number, other bodies out."""
    data = read(write(), body=body).build()
    assert data.cell_type == cell
    share = 0.5 if cell == "triangle" else 1
    area = share * jacobians(data.points, data.cells, data.cell_type).mean(axis=1).sum()
    assert area == pytest.approx(4e-6, rel=1e-12)
    assert set(data.groups) == {f"{body} base", "70" if body == "lower" else "71"}
    base = data.surface(f"{body} base").X
    np.testing.assert_allclose(base, np.c_[np.linspace(0, 2, 4), 4 * [bottom]] * 1e-3, atol=1e-15)


def test_two_bodies_in_one_file(write: Callable[..., Path]) -> None:
    """Without a name both are one body, of triangles, in two pieces: both is said."""
    both = read(write())
    assert len(both.build().cells) == 2 * 9 + 2 * 9
    assert both.read.doubts == ("in 2 pieces; 'body' takes one group of cells of a file",)
    assert both.read.notes == (
        "the cells, 18 triangles and 9 quadrilaterals, are split into triangles: "
        "a body has cells of one kind",
    )
    with pytest.raises(MeshError, match="no group of cells 'middle'; there are: lower, upper"):
        read(write(), body="middle").build()


@pytest.mark.parametrize("order", [2, 3])
def test_corners_of_cells_of_higher_order(write: Callable[..., Path], order: int) -> None:
    """The mesh of the corners is that of first order."""
    curved = read(write(order=order), body="lower")
    data, plain = curved.build(), read(write(), body="lower").build()
    assert curved.read.notes == (
        "27 cells of the file are of second or higher order: their corners are taken, edges are "
        "straight in between",
    )
    assert len(data.points) == len(plain.points)
    assert jacobians(data.points, data.cells, "quadrilateral").sum() == pytest.approx(16e-6)
    assert {n: len(f) for n, f in data.groups.items()} == {"lower base": 3, "70": 3}


def test_tilted_meshes_are_refused(write: Callable[..., Path]) -> None:
    with pytest.raises(MeshError, match="plane of constant z"):
        read(write(tilt=0.3), body="lower").build()


def test_outline(write: Callable[..., Path]) -> None:
    outline = read(write(), body="lower").outline()
    np.testing.assert_allclose(outline["lower base"][:, 0], np.linspace(0, 2e-3, 4), atol=1e-15)
    low, high = read(write(), body="lower").extent()
    np.testing.assert_allclose([low, high], [[0, 0], [2e-3, 2e-3]], atol=1e-15)


def test_outline_of_separate_pieces_has_gaps(tmp_path: Path) -> None:
    lines = ("line", np.array([[1, 2], [4, 3], [0, 1]]))
    numbers = [np.array([0, 0]), np.array([5, 5, 5])]
    mesh = meshio.Mesh(POINTS, [QUADS, lines], cell_data={"part": numbers})
    mesh.write(tmp_path / "sides.vtu")
    line = read(tmp_path / "sides.vtu", unit="m").outline()["5"]
    gap = [np.nan, np.nan]
    np.testing.assert_array_equal(line, [[0, 0], [1, 0], [2, 0], gap, [1, 1], [0, 1]])


POINTS = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0]])
QUADS = ("quad", np.array([[0, 1, 4, 3], [1, 2, 5, 4]]))


def test_sets_of_an_abaqus_file(tmp_path: Path) -> None:
    """A set of points names the boundary facets between them."""
    lines = ("line", np.array([[0, 1], [1, 2], [4, 3], [5, 4]]))
    mesh = meshio.Mesh(POINTS, [QUADS, lines], point_sets={"foot": [0, 1, 2]})
    mesh.write(tmp_path / "plate.inp")
    data = read(tmp_path / "plate.inp", unit="m").build()
    assert data.cell_type == "quadrilateral"
    np.testing.assert_array_equal(data.groups["foot"], [[0, 1], [1, 2]])


@pytest.mark.parametrize("suffix", ["vtu", "mesh"])
def test_numbers_on_facets(tmp_path: Path, suffix: str) -> None:
    """Whole numbers on the facet cells name groups."""
    lines = ("line", np.array([[1, 0], [1, 2], [3, 4]]))
    numbers = [np.array([9, 9]), np.array([1, 1, 2])]
    name = "medit:ref" if suffix == "mesh" else "part"
    mesh = meshio.Mesh(POINTS, [QUADS, lines], cell_data={name: numbers})
    mesh.write(tmp_path / f"plate.{suffix}")
    data = read(tmp_path / f"plate.{suffix}", unit="m").build()
    assert {n: f.tolist() for n, f in data.groups.items()} == {"1": [[0, 1], [1, 2]], "2": [[4, 3]]}


def test_solid(tmp_path: Path) -> None:
    """Hexahedra in the file's order, faces in any order."""
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=float)
    points = np.concatenate([np.insert(corners, 2, z, axis=1) for z in (0, 3)])
    cells = [("hexahedron", np.arange(8)[None]), ("quad", np.array([[3, 2, 1, 0]]))]
    mesh = meshio.Mesh(points, cells, cell_data={"tag": [np.array([0]), np.array([4])]})
    mesh.write(tmp_path / "brick.vtu")
    data = read(tmp_path / "brick.vtu").build()
    assert jacobians(data.points, data.cells, data.cell_type) == pytest.approx(3e-9)
    np.testing.assert_array_equal(np.sort(data.groups["4"]), [[0, 1, 2, 3]])


def test_bad_files(tmp_path: Path) -> None:
    with pytest.raises(ValidationError, match=r"there is no file '.*absent.msh'"):
        read(tmp_path / "absent.msh")
    for name, text in {"a.msh": "hello\n", "b.vtu": "hello\n", "c.stuff": "hello\n"}.items():
        (tmp_path / name).write_text(text)
        with pytest.raises(MeshError, match=f"{name}: not a mesh"):
            read(tmp_path / name).build()
    (tmp_path / "empty.stl").write_text("solid\nendsolid\n")
    with pytest.raises(MeshError, match=r"empty.stl: holds no points"):
        read(tmp_path / "empty.stl").build()
    with pytest.raises(ValidationError, match="greater than 0"):
        read(tmp_path / "a.msh", unit="-1 mm")
    with pytest.raises(ValidationError, match="length"):
        read(tmp_path / "a.msh", unit="s")


def test_a_file_that_is_read_on_for_ever(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """meshio looks for the numbers of an OFF file past its end."""
    monkeypatch.setattr(readers, "PATIENCE", 3.0)
    (tmp_path / "cut.off").write_text("OFF\n")
    with pytest.raises(MeshError, match=r"cut.off: not a mesh that meshio reads \(still not done"):
        read(tmp_path / "cut.off").build()


def test_a_file_at_which_gmsh_crashes(tmp_path: Path) -> None:
    """A triangle with the vertex that is next after the last one."""
    text = """$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
3
1 0 0 0
2 1 0 0
3 0 1 0
$EndNodes
$Elements
1
1 2 2 1 1 1 2 4
$EndElements
"""
    (tmp_path / "past.msh").write_text(text)
    with pytest.raises(MeshError, match=r"past.msh: (not a mesh that gmsh reads|has cells with)"):
        read(tmp_path / "past.msh").build()


def test_facets_inside_the_body_are_no_surface(tmp_path: Path) -> None:
    lines = ("line", np.array([[1, 4]]))
    mesh = meshio.Mesh(
        POINTS, [QUADS, lines], cell_data={"part": [np.array([0, 0]), np.array([5])]}
    )
    mesh.write(tmp_path / "cut.vtu")
    with pytest.raises(MeshError, match="group '5': 1 of 1 facets are not on the body's boundary"):
        read(tmp_path / "cut.vtu").build()


def test_cells_that_are_no_lists_of_vertices() -> None:
    """As meshio reads them from some broken files."""
    for rows in (np.arange(3), np.arange(4).reshape(2, 2)):
        with pytest.raises(MeshError, match="triangle cells of the file are not lists of vertices"):
            corners("triangle", rows)


def test_cells_of_two_groups_in_format_2(tmp_path: Path) -> None:
    """gmsh writes such a cell once for each of its groups."""
    quads = [[1, 2, 5, 4], [2, 3, 6, 5]]
    rows = [(3, tag, tag, *quad) for tag in (1, 2) for quad in quads] + [(1, 7, 7, 1, 2)]
    elements = [
        f"{k} {kind} 2 {rest}"
        for k, (kind, rest) in enumerate(
            ((row[0], " ".join(map(str, row[1:]))) for row in rows), start=1
        )
    ]
    points = [f"{k} {x:g} {y:g} {z:g}" for k, (x, y, z) in enumerate(POINTS, start=1)]
    names = ['2 1 "plate"', '2 2 "all"', '1 7 "foot"']
    text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
    for title, part in (("PhysicalNames", names), ("Nodes", points), ("Elements", elements)):
        text += "\n".join([f"${title}", str(len(part)), *part, f"$End{title}"]) + "\n"
    (tmp_path / "two.msh").write_text(text)
    for body in ("plate", None):
        mesh = read(tmp_path / "two.msh", body=body)
        assert len(mesh.build().cells) == 2
        np.testing.assert_array_equal(mesh.build().groups["foot"], [[0, 1]])
    assert mesh.read.notes == ("2 cells are there twice, as those of two groups are: taken once",)


def test_group_names_of_a_med_file(tmp_path: Path) -> None:
    """Families have names: one of two groups, and groups of nodes alone."""
    mesh = meshio.Mesh(
        POINTS,
        [QUADS, ("line", np.array([[0, 1], [1, 2], [2, 5]]))],
        cell_data={"cell_tags": [np.array([-1, -1]), np.array([-2, -3, -4])]},
        point_data={"point_tags": np.array([0, 0, 0, 1, 1, 2])},
    )
    mesh.cell_tags = {-1: ["plate"], -2: ["foot"], -3: ["foot", "right half"], -4: ["right half"]}
    mesh.point_tags = {1: ["top"], 2: ["top", "corner"]}
    mesh.write(tmp_path / "salome.med")
    data = read(tmp_path / "salome.med", unit="m", body="plate").build()
    assert {name: facets.tolist() for name, facets in data.groups.items()} == {
        "foot": [[0, 1], [1, 2]],
        "right half": [[1, 2], [2, 5]],
        "top": [[5, 4], [4, 3]],
    }


def test_whole_numbers_with_a_point(tmp_path: Path) -> None:
    """As ParaView writes them; those with a fraction are no groups."""
    lines = ("line", np.array([[0, 1], [1, 2]]))
    data = {"part": [np.array([9.0, 9.0]), np.array([1.0, 2.0])]}
    data |= {"size": [np.array([0.5, 1.0]), np.array([1.0, 1.5])]}
    meshio.Mesh(POINTS, [QUADS, lines], cell_data=data).write(tmp_path / "plate.vtu")
    found = read(tmp_path / "plate.vtu", unit="m").build()
    assert {n: f.tolist() for n, f in found.groups.items()} == {"1": [[0, 1]], "2": [[1, 2]]}


@pytest.mark.parametrize("suffix", ["unv", "bdf"])
def test_universal_and_nastran_files(tmp_path: Path, suffix: str) -> None:
    """Groups of the one have names, of the other numbers of properties."""
    with gmsh_session() as gmsh:
        square = gmsh.model.occ.addRectangle(0, 0, 0, 2, 1)
        gmsh.model.occ.synchronize()
        sides = [tag for _, tag in gmsh.model.getBoundary([(2, square)], oriented=False)]
        gmsh.model.addPhysicalGroup(2, [square], tag=1, name="plate")
        gmsh.model.addPhysicalGroup(1, [sides[0]], tag=12, name="foot")
        gmsh.model.mesh.generate(2)
        gmsh.option.setNumber("Mesh.SaveElementTagType", 2)
        gmsh.write(str(tmp_path / f"plate.{suffix}"))
    data = read(tmp_path / f"plate.{suffix}", body="plate" if suffix == "unv" else "1").build()
    area = 0.5 * jacobians(data.points, data.cells, data.cell_type).sum()
    assert area == pytest.approx(2e-6, rel=1e-5)
    foot = data.surface("foot" if suffix == "unv" else "12").X
    np.testing.assert_allclose(foot[:, 1], 0.0, atol=1e-12)
    assert np.ptp(foot[:, 0]) == pytest.approx(2e-3)


def test_a_body_by_a_set_of_nodes(tmp_path: Path) -> None:
    """Its cells are those all of whose vertices are in the set."""
    mesh = meshio.Mesh(POINTS, [QUADS], point_sets={"left": [0, 1, 3, 4], "foot": [0, 1, 2]})
    mesh.write(tmp_path / "plate.inp")
    data = read(tmp_path / "plate.inp", unit="m", body="left").build()
    assert len(data.cells) == 1
    np.testing.assert_array_equal(data.groups["foot"], [[0, 1]])
