"""Cells of several kinds in one body become triangles or tetrahedra that fill the same space."""

import itertools

import numpy as np
import pytest

from contactfem.common.typing import Floats, Ints
from contactfem.meshes.body_cells import file_body
from contactfem.meshes.cell_complex import check_complex
from contactfem.meshes.data import boundary_facets, jacobians, mesh_data
from contactfem.meshes.raw import RawMesh
from contactfem.meshes.simplices import tetrahedra, triangles

RANDOM = np.random.default_rng(7)


def bricks(nx: int, ny: int, nz: int) -> tuple[Floats, Ints]:
    """Points of a skewed array of bricks, in random numbering, and the bricks."""
    x, y, z = np.meshgrid(np.arange(nx + 1), np.arange(ny + 1), np.arange(nz + 1), indexing="ij")
    points = np.stack([x + 0.3 * y, y - 0.1 * z, z + 0.2 * x], axis=-1).reshape(-1, 3)
    number = np.arange(len(points)).reshape(x.shape)
    around = ((0, 0), (1, 0), (1, 1), (0, 1))
    cells = [
        [number[i + a, j + b, k + c] for c in (0, 1) for a, b in around]
        for i, j, k in itertools.product(range(nx), range(ny), range(nz))
    ]
    shuffle = RANDOM.permutation(len(points))
    moved = np.empty_like(points)
    moved[shuffle] = points
    return moved, shuffle[np.array(cells)]


def volume(points: Floats, cells: Ints) -> float:
    return float(np.abs(jacobians(points, cells, "tetrahedron")).sum() / 6.0)


BRICK = abs(np.linalg.det([[1, 0, 0.2], [0.3, 1, 0], [0, -0.1, 1]]))


@pytest.mark.parametrize("shape", [(1, 1, 1), (3, 2, 2)])
def test_bricks_of_any_numbering(shape: tuple[int, int, int]) -> None:
    points, cells = bricks(*shape)
    found = tetrahedra({"hexahedron": cells})
    assert volume(points, found) == pytest.approx(np.prod(shape) * BRICK, rel=1e-12)
    assert check_complex(mesh_data(points, found, "tetrahedron", {})) == ()


def test_bricks_wedges_and_pyramids_fit_each_other() -> None:
    """A brick stays, one becomes two wedges, one six pyramids around its centre."""
    points, cells = bricks(3, 1, 1)
    first, second, third = cells
    centre = len(points)
    points = np.concatenate([points, points[third].mean(axis=0, keepdims=True)])
    sides = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    kinds = {
        "hexahedron": first[None],
        "wedge": second[[[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]]],
        "pyramid": np.array([[*third[list(side)], centre] for side in sides]),
    }
    found = file_body(RawMesh(points, kinds, {"shell": {"quad": first[None, :4]}}), None, 1.0, None)
    assert volume(found.data.points, found.data.cells) == pytest.approx(3 * BRICK, rel=1e-12)
    assert found.doubts == ()
    assert len(boundary_facets(found.data.cells, "tetrahedron")) == 2 * 14
    assert len(found.data.groups["shell"]) == 2
    assert found.notes == (
        "the cells, 1 hexahedra and 2 wedges and 6 pyramids, are split into tetrahedra: "
        "a body has cells of one kind",
    )


def test_a_brick_that_is_collapsed_to_a_wedge() -> None:
    """As meshers of bricks write them: two edges are points."""
    points, ((a, b, c, d, e, f, g, h),) = bricks(1, 1, 1)
    cells = np.array([[a, b, c, c, e, f, g, g], [a, a, c, d, e, e, g, h]])
    found = file_body(RawMesh(points, {"hexahedron": cells}, {}), None, 1.0, None)
    assert volume(found.data.points, found.data.cells) == pytest.approx(BRICK, rel=1e-12)
    assert found.notes[0].endswith("are split into tetrahedra: some have a vertex twice")


def area(points: Floats, cells: Ints) -> float:
    return float(np.abs(jacobians(points, cells, "triangle")).sum() / 2.0)


def test_quadrilaterals_by_the_better_diagonal() -> None:
    """A hollow one can be split in one way only; one with a vertex twice is a triangle."""
    points = np.array([[0.0, 0], [2, 0], [0.5, 0.5], [0, 2], [3, 0], [3, 2.5]])
    arrow = np.array([[0, 1, 2, 3]])
    for turn in range(4):
        found = triangles({"quad": np.roll(arrow, turn, axis=1)}, points)
        assert area(points, found) == pytest.approx(1.0)
    long = np.array([[0.0, 0], [1, 0], [3, 1], [2, 1]])
    found = triangles({"quad": np.array([[0, 1, 2, 3]])}, long)
    assert sorted(map(sorted, found.tolist())) == [[0, 1, 3], [1, 2, 3]]
    found = triangles({"quad": np.array([[0, 1, 1, 3]]), "triangle": np.array([[1, 4, 5]])}, points)
    assert sorted(map(sorted, found.tolist())) == [[0, 1, 3], [1, 4, 5]]
