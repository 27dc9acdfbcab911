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


def test_body_is_needed_where_there_are_two(write: Callable[..., Path]) -> None:
    with pytest.raises(MeshError, match=r"two.msh: a body needs cells of one kind.*triangle, quad"):
        read(write()).build()
    with pytest.raises(MeshError, match="no group of cells 'middle'; there are: lower, upper"):
        read(write(), body="middle").build()


def test_second_order_and_tilted_meshes_are_refused(write: Callable[..., Path]) -> None:
    with pytest.raises(MeshError, match="first order"):
        read(write(order=2)).build()
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


def test_cells_that_are_no_lists_of_vertices(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As meshio reads them from some broken Abaqus files."""
    (tmp_path / "mesh.inp").write_text("")
    raw = readers.RawMesh(np.zeros((3, 3)), {"triangle": np.arange(3)}, {})
    monkeypatch.setattr("contactfem.meshes.file.read_mesh", lambda path: raw)
    with pytest.raises(MeshError, match="triangle cells of the file are not lists of vertices"):
        read(tmp_path / "mesh.inp").build()
