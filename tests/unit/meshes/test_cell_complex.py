"""What is found in the cells of a mesh: folds, slits, pieces, cells twice, nodes that are one."""

import numpy as np
import pytest

from contactfem.errors import MeshError
from contactfem.meshes import MeshData
from contactfem.meshes.body_cells import file_body
from contactfem.meshes.box import Box
from contactfem.meshes.cell_complex import check_complex, coincident, distinct, merged, pieces
from contactfem.meshes.data import CellName, mesh_data
from contactfem.meshes.grid import Cell2D, grid
from contactfem.meshes.raw import RawMesh


def plate(cell: Cell2D = "triangle", nx: int = 6, ny: int = 4) -> MeshData:
    x, y = np.meshgrid(np.arange(nx + 1.0), np.arange(ny + 1.0))
    return grid(np.stack([x, y], axis=-1), cell, "alternating")


def box(cell: CellName) -> MeshData:
    mesh = {"builder": "box", "width": 3.0, "height": 2.0, "depth": 2.0, "cell": cell}
    return Box.model_validate(mesh | {"nx": 3, "ny": 2, "nz": 2}).build()


def parted(data: MeshData, axis: int, at: float, along: int, below: float) -> MeshData:
    """Give the cells beyond a plane their own nodes on it, as far as another coordinate goes."""
    beyond = data.points[data.cells].mean(axis=1)[:, axis] > at
    cut = (np.abs(data.points[:, axis] - at) < 1e-9) & (data.points[:, along] < below)
    number = np.arange(len(data.points))
    number[cut] = len(data.points) + np.arange(cut.sum())
    cells = np.where(beyond[:, None], number[data.cells], data.cells)
    points = np.concatenate([data.points, data.points[cut]])
    return mesh_data(points, cells, data.cell_type, {})


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
def test_a_sound_plate_is_not_doubted(cell: Cell2D) -> None:
    assert check_complex(plate(cell)) == ()


@pytest.mark.parametrize("cell", ["tetrahedron", "hexahedron"])
def test_a_sound_box_is_not_doubted(cell: CellName) -> None:
    assert check_complex(box(cell)) == ()


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
def test_a_slit_from_the_edge(cell: Cell2D) -> None:
    """Three nodes of a column of five are there twice; the body stays in one piece."""
    slit = parted(plate(cell), 0, 3.0, 1, 2.5)
    np.testing.assert_array_equal(coincident(slit), [[3, 0], [3, 1], [3, 2]])
    (doubt,) = check_complex(slit)
    assert doubt.startswith("at 3 places several nodes lie that are not one, the first at (3, 0) m")
    assert 'merge = "1e-6 mm"' in doubt


@pytest.mark.parametrize("cell", ["tetrahedron", "hexahedron"])
def test_a_box_in_two_pieces(cell: CellName) -> None:
    halves = parted(box(cell), 0, 1.0, 1, 9.0)
    nodes, apart = check_complex(halves)
    assert nodes.startswith("at 9 places")
    assert apart.startswith("in 2 pieces")
    assert pieces(halves.points, halves.cells) == 2


def test_small_cells_are_no_coincident_nodes() -> None:
    """Rings that grow from a hundred millionth of the body's size: nodes are close, not one."""
    r, angle = np.meshgrid(np.geomspace(1e-8, 1.0, 40), np.linspace(0.0, 0.5 * np.pi, 9))
    points = np.stack([r * np.cos(angle), r * np.sin(angle)], axis=-1)
    assert check_complex(grid(points, "quadrilateral", "right")) == ()


def test_a_node_pushed_through_the_opposite_edge() -> None:
    """Around it two cells run the other way round; turned, they lie over their neighbours."""
    data = plate()
    points = data.points.copy()
    points[8] += [1.4, 0.1]  # from (1, 1) into the next column
    with pytest.raises(MeshError, match=r"cells overlap near \(.*\) m: at \d+ facets"):
        check_complex(mesh_data(points, data.cells, "triangle", {}))


def test_a_node_pushed_through_a_face() -> None:
    data = box("tetrahedron")
    inner = np.flatnonzero((np.abs(data.points - [1, 1, 1]) < 1e-9).all(axis=1))
    points = data.points.copy()
    points[inner] += [1.37, 0.11, 0.07]
    with pytest.raises(MeshError, match="cells overlap near"):
        check_complex(mesh_data(points, data.cells, "tetrahedron", {}))


def test_a_hexahedron_over_its_neighbour() -> None:
    """The mirrored copy of a cell at one of its faces lies on the same side of that."""
    corners = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), axis=-1)
    points = corners.transpose(2, 1, 0, 3).reshape(8, 3).astype(float)
    inside = points[[1, 3, 5, 7]] - [0.5, 0, 0]
    both = np.array([np.arange(8), [0, 8, 2, 9, 4, 10, 6, 11]])
    data = mesh_data(np.concatenate([points, inside]), both, "hexahedron", {})
    with pytest.raises(MeshError, match="cells overlap near"):
        check_complex(data)


def test_three_cells_at_an_edge() -> None:
    points = np.array([[0, 0], [1, 0], [0.5, 1], [0.5, -1], [0.5, 2.0]])
    cells = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    with pytest.raises(MeshError, match=r"1 facets belong to more than two cells.*\(0.5, 0\) m"):
        check_complex(mesh_data(points, cells, "triangle", {}))


@pytest.mark.parametrize("height", [0.0, 1e-17, -1e-12, 1e-9])
def test_flat_cells_up_to_round_off(height: float) -> None:
    """A node in the middle of its opposite edge."""
    points = np.array([[0.0, 0], [1, 0], [0.5, height], [0.5, 1]]) * 1e-3
    with pytest.raises(MeshError, match=r"1 of 3 cells are flat or twisted, the first near \(0.0"):
        mesh_data(points, np.array([[0, 1, 2], [1, 3, 2], [3, 0, 2]]), "triangle", {})


def test_cells_of_an_aspect_of_a_million_are_not_flat() -> None:
    x, y = np.meshgrid(np.arange(3.0), 1e-6 * np.arange(3.0))
    assert len(grid(np.stack([x, y], axis=-1), "triangle", "right").cells) == 8


def test_cells_that_are_there_twice() -> None:
    rows = np.array([[0, 1, 2], [1, 2, 3], [2, 0, 1]])
    kept, count = distinct({"triangle": rows, "line": rows[:2, :2]})
    assert count == 1
    np.testing.assert_array_equal(kept["triangle"], rows[:2])


def test_points_that_chains_join_are_one() -> None:
    points = np.array([[0.0, 0], [1, 0], [1.09, 0], [1.18, 0], [3, 0]])
    np.testing.assert_array_equal(merged(points, 0.1), [0, 1, 1, 1, 4])


def raw(data: MeshData) -> RawMesh:
    order = [0, 1, 3, 2] if data.cell_type == "quadrilateral" else [0, 1, 2]
    kind = "quad" if data.cell_type == "quadrilateral" else "triangle"
    points = np.insert(data.points, 2, 0.0, axis=1)
    return RawMesh(points, {kind: data.cells[:, order]}, {})


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
def test_a_slit_that_is_merged(cell: Cell2D) -> None:
    """The mesh is as if it had never been cut."""
    whole = plate(cell)
    found = file_body(raw(parted(whole, 0, 3.0, 1, 2.5)), None, 1.0, 1e-6)
    assert found.doubts == ()
    assert found.notes == ("merge = 1e-06 m has joined 3 nodes with others",)
    assert len(found.data.points) == len(whole.points)


def test_a_merge_beyond_the_size_of_cells() -> None:
    with pytest.raises(MeshError, match=r"merge = 1.1 m joins vertices of one cell, in 48 cells"):
        file_body(raw(plate()), None, 1.0, 1.1)
    many = plate("quadrilateral", 40, 40)
    with pytest.raises(MeshError, match="merge = 1000 m is far larger than its cells"):
        file_body(raw(many), None, 1.0, 1e3)
