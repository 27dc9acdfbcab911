"""Boundaries of mesh files: corners kept, curves smooth, and what cannot be walked refused."""

from pathlib import Path

import meshio
import numpy as np
import pytest

from contactfem.errors import MeshError
from contactfem.meshes.block import Block
from contactfem.meshes.box import Box
from contactfem.meshes.curves import Edge, Parametric
from contactfem.meshes.cylinder import Cylinder
from contactfem.meshes.data import MeshData, jacobians, mesh_data
from contactfem.meshes.disk import Ring
from contactfem.meshes.file import MeshFile
from contactfem.meshes.reconstruct import reconstructed
from contactfem.meshes.size_field import SizeField, size_field


def file_of(data: MeshData, folder: Path) -> MeshFile:
    """The mesh by way of a file, its groups as numbers on facets."""
    order = [0, 1, 3, 2] if data.cell_type == "quadrilateral" else [0, 1, 2]
    names = {"quadrilateral": "quad"}
    cells = [(names.get(data.cell_type, data.cell_type), data.cells[:, order])]
    cells += [("line", facets) for facets in data.groups.values()]
    marks = [np.zeros(len(data.cells), dtype=int)]
    marks += [np.full(len(facets), k + 1) for k, facets in enumerate(data.groups.values())]
    points = np.c_[data.points, np.zeros(len(data.points))]
    mesh = meshio.Mesh(points, cells, cell_data={"part": marks})
    mesh.write(folder / "body.vtu")
    return MeshFile(file=folder / "body.vtu", unit=1.0)


def uniform(data: MeshData, size: float) -> SizeField:
    return size_field(data, np.full(len(data.points), size))


def area(data: MeshData) -> float:
    return 0.5 * float(jacobians(data.points, data.cells, data.cell_type).sum())


def test_straight_sides_stay_and_so_do_corners(tmp_path: Path) -> None:
    """Also where a group ends on a straight side."""
    before = Block(width=2.0, height=1.0, nx=10, ny=5, split=(0.6, 1.4)).build()
    body = file_of(before, tmp_path)
    data = body.adapted(uniform(before, 0.07))
    assert data.groups.keys() == body.build().groups.keys()
    assert area(data) == pytest.approx(2.0, rel=1e-13)
    for group in data.groups:
        old, new = body.build().surface(group).X, data.surface(group).X
        np.testing.assert_allclose(new[[0, -1]], old[[0, -1]], atol=1e-14)
    (loop,) = body.curves()
    assert len(loop) == 6


def test_smooth_boundaries_are_refined_as_curves() -> None:
    """Halved facets of an arc lie far closer to the circle than its chords, and faster so."""
    errors = []
    for size in (0.2, 0.1):
        roll = Cylinder(radius=1.0, zone=0.9, size=size, growth=0.01, coarse=size)
        before = roll.build()
        loops = reconstructed(before)
        assert len(loops) == 1
        arc = [curve for curve in loops[0] if "contact" in curve.groups]
        assert len(arc) == 1 and isinstance(arc[0], Parametric)
        x = arc[0].at(np.linspace(0.0, 1.0, 500))
        errors.append(np.abs(np.hypot(x[:, 0], x[:, 1] - 1.0) - 1.0).max())
        assert errors[-1] < 0.3 * size**2 / 8
    assert errors[1] < errors[0] / 6


def test_holes_are_closed_curves() -> None:
    """A ring's circles have no corner; its mesh may be refined and coarsened."""
    before = Ring(inner_radius=1.0, outer_radius=2.0, facets=40, layers=6).build()
    outer, inner = reconstructed(before)
    assert [curve.groups for curve in (*outer, *inner)] == [("outer",), ("inner",)]
    for (curve,), radius in ((outer, 2.0), (inner, np.hypot(*before.surface("inner").X[0]))):
        t = np.linspace(0.0, 1.0, 801)
        off = np.abs(np.hypot(*curve.at(t).T) - radius)
        assert off.max() < 0.02 * radius * (1 - np.cos(np.pi / 40))
        np.testing.assert_allclose(curve.at(t[[0]]), curve.at(t[[-1]]), atol=1e-14)


def test_corners_are_where_it_turns_sharply() -> None:
    """A fan of two triangles: 29 degrees are a bend, 31 a corner."""
    for angle, corners in ((29.0, 3), (31.0, 4)):
        turn = np.deg2rad(angle)
        points = np.array([[0, 0], [1, 0], [1 + np.cos(turn), np.sin(turn)], [0.5, 2.0]])
        data = mesh_data(points, np.array([[0, 1, 3], [1, 2, 3]]), "triangle", {})
        (loop,) = reconstructed(data)
        assert len(loop) == corners
        assert sum(isinstance(curve, Edge) for curve in loop) == (2 if corners == 3 else 4)


def touching() -> MeshData:
    """Two squares that share a corner."""
    points = np.array([[0, 0], [1, 0], [0, 1], [1, 1], [2, 1], [1, 2], [2, 2]], dtype=float)
    return mesh_data(points, np.array([[0, 1, 2, 3], [3, 4, 5, 6]]), "quadrilateral", {})


def apart() -> MeshData:
    """Two triangles that share nothing."""
    points = np.array([[0, 0], [1, 0], [0, 1], [3, 0], [4, 0], [3, 1]], dtype=float)
    return mesh_data(points, np.array([[0, 1, 2], [3, 4, 5]]), "triangle", {})


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (touching(), r"its boundary touches itself at \(1, 1\) m"),
        (apart(), "it is in 2 pieces"),
        (Box(width=1.0, height=1.0, depth=1.0, nx=1, ny=1, nz=1).build(), "this one is solid"),
    ],
)
def test_what_is_refused(data: MeshData, words: str) -> None:
    with pytest.raises(MeshError, match=words):
        reconstructed(data)


def test_the_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=r"body.vtu: cannot be adapted: it is in 2 pieces"):
        file_of(apart(), tmp_path).adapted(uniform(apart(), 0.1))
