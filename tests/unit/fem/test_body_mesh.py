"""A distributed mesh leads back to its input numbering, on any number of ranks."""

import numpy as np
import pytest
import ufl
from dolfinx import default_scalar_type, fem
from dolfinx.mesh import compute_midpoints

from mpi4py import MPI

from contactfem.errors import MeshError
from contactfem.fem.body_mesh import BodyMesh, distribute, dof_of_vertex, gather_vertex_values
from contactfem.meshes.block import Block
from contactfem.meshes.box import Box
from contactfem.meshes.data import FACETS, MeshData, mesh_data

pytestmark = pytest.mark.mpi
COMM = MPI.COMM_WORLD


def block(nx: int, ny: int, cell: str = "quadrilateral") -> MeshData:
    """Two by one block away from the origin, with a second group on part of its top."""
    data = Block(width="2 m", height="1 m", corner=("1 m", "3 m"), nx=nx, ny=ny, cell=cell).build()
    groups = data.groups | {"contact": data.groups["top"][: max(1, nx // 2)]}
    return mesh_data(data.points, data.cells, data.cell_type, groups)


def spread(data: MeshData) -> BodyMesh:
    return distribute(COMM, data if COMM.rank == 0 else None)


def integral(body: BodyMesh, integrand: ufl.core.expr.Expr) -> float:
    return COMM.allreduce(fem.assemble_scalar(fem.form(integrand)))


@pytest.mark.parametrize("cell", ["quadrilateral", "triangle"])
@pytest.mark.parametrize(("nx", "ny"), [(1, 1), (2, 1), (7, 4), (40, 1)])
def test_group_measures(cell: str, nx: int, ny: int) -> None:
    """Lengths of overlapping groups in one form; ranks may own nothing of them."""
    body = spread(block(nx, ny, cell))
    lengths = {"left": 1, "right": 1, "bottom": 2, "top": 2, "contact": 2 * max(1, nx // 2) / nx}
    one = fem.Constant(body.mesh, default_scalar_type(1))
    for name, length in lengths.items():
        assert integral(body, one * body.ds(name)) == pytest.approx(length, rel=1e-13)
    both = one * body.ds("top") + 10 * one * body.ds("contact", degree=2)
    assert integral(body, both) == pytest.approx(2 + 10 * lengths["contact"], rel=1e-13)


def test_measure_sees_the_right_facets() -> None:
    """The normal on each side, and a moment that tells the sides of a group apart."""
    body = spread(block(7, 4))
    x, n = ufl.SpatialCoordinate(body.mesh), ufl.FacetNormal(body.mesh)
    assert integral(body, n[1] * x[0] * body.ds("top")) == pytest.approx(4, rel=1e-13)
    assert integral(body, n[1] * x[0] * body.ds("bottom")) == pytest.approx(-4, rel=1e-13)
    assert integral(body, n[0] * x[1] * body.ds("left")) == pytest.approx(-3.5, rel=1e-13)


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
def test_solids(cell: str) -> None:
    """Sides of a box: areas, normals, and the same replicated surfaces."""
    data = Box(width=2, height=1, depth=3, nx=3, ny=1, nz=2, cell=cell).build()
    body = spread(data)
    x, n = ufl.SpatialCoordinate(body.mesh), ufl.FacetNormal(body.mesh)
    areas = {"left": 3, "right": 3, "bottom": 6, "top": 6, "back": 2, "front": 2}
    for name, area in areas.items():
        flux = {"right": 2 * area, "top": area, "front": 3 * area}.get(name, 0)
        assert integral(body, ufl.inner(x, n) * body.ds(name)) == pytest.approx(flux, abs=1e-13)
        assert integral(body, ufl.inner(n, n) * body.ds(name)) == pytest.approx(area, rel=1e-13)
        np.testing.assert_array_equal(body.groups[name], data.groups[name])
    V = fem.functionspace(body.mesh, ("Lagrange", 1, (3,)))
    u = fem.Function(V)
    u.interpolate(lambda x: x)
    gathered = gather_vertex_values(COMM, body, V, u.x.array)
    if COMM.rank == 0:
        np.testing.assert_allclose(gathered, data.points, atol=1e-14)


def test_owned_facets_cover_each_group_once() -> None:
    body = spread(block(7, 4))
    for name in body.surfaces:
        mine = body.facets(name)
        assert COMM.allreduce(len(mine)) == len(body.groups[name])
        middles = compute_midpoints(body.mesh, 1, mine) if len(mine) else np.empty((0, 3))
        expected = body.surface(name).X[body.surface(name).facets].mean(axis=1)
        everywhere = np.concatenate(COMM.allgather(middles[:, :2]))
        order = np.lexsort(everywhere.T.round(9)), np.lexsort(expected.T.round(9))
        np.testing.assert_allclose(everywhere[order[0]], expected[order[1]], atol=1e-14)


@pytest.mark.parametrize("nx", [1, 6])
def test_surfaces_are_the_input(nx: int) -> None:
    """Every rank holds the same surface, in input numbers and in the order of the walk."""
    data = block(nx, 3)
    body = spread(data)
    for name in data.groups:
        surface = body.surface(name)
        np.testing.assert_array_equal(body.groups[name], data.groups[name])
        np.testing.assert_array_equal(surface.X, data.points[surface.vertices])
        np.testing.assert_array_equal(surface.facets[1:, 0], surface.facets[:-1, 1])
        np.testing.assert_array_equal(surface.facets[0], [0, 1])


@pytest.mark.parametrize(("nx", "ny"), [(1, 1), (9, 5)])
@pytest.mark.parametrize("shape", [(), (2,)])
def test_values_come_back_in_input_numbering(nx: int, ny: int, shape: tuple[int, ...]) -> None:
    """A field that names its own point is gathered to that point."""
    data = block(nx, ny, "triangle")
    body = spread(data)
    V = fem.functionspace(body.mesh, ("Lagrange", 1, shape))
    u = fem.Function(V)
    u.interpolate(lambda x: x[:2] if shape else x[0] + 100 * x[1])
    gathered = gather_vertex_values(COMM, body, V, u.x.array)
    if COMM.rank == 0:
        expected = data.points if shape else (data.points @ [1, 100])[:, None]
        np.testing.assert_allclose(gathered, expected, rtol=1e-14)
    else:
        assert gathered is None


def test_dofs_of_ghosts_too() -> None:
    """Owned and ghost dofs have the coordinates of the vertex they are said to sit at."""
    data = block(8, 4)
    points = COMM.bcast(data.points)
    body = spread(data)
    V = fem.functionspace(body.mesh, ("Lagrange", 1, (2,)))
    dofs, vertices = dof_of_vertex(body.mesh, V)
    here = V.dofmap.index_map.size_local + V.dofmap.index_map.num_ghosts
    np.testing.assert_array_equal(dofs, np.arange(here))
    np.testing.assert_allclose(V.tabulate_dof_coordinates()[dofs, :2], points[vertices], rtol=1e-14)


def test_bubble_space_has_vertex_dofs() -> None:
    """Dofs that sit in cells are passed over."""
    import basix.ufl

    cell = "triangle"
    enriched = basix.ufl.enriched_element(
        [basix.ufl.element("Lagrange", cell, 1), basix.ufl.element("Bubble", cell, 3)]
    )
    data = block(5, 3, cell)
    body = spread(data)
    V = fem.functionspace(body.mesh, basix.ufl.blocked_element(enriched, shape=(2,)))
    u = fem.Function(V)
    dofs, vertices = dof_of_vertex(body.mesh, V)
    u.x.array.reshape(-1, 2)[dofs, 0] = vertices
    gathered = gather_vertex_values(COMM, body, V, u.x.array)
    if COMM.rank == 0:
        np.testing.assert_array_equal(gathered[:, 0], np.arange(len(data.points)))


@pytest.mark.parametrize("cell", FACETS)
def test_local_facets_are_numbered_as_in_dolfinx(cell: str) -> None:
    """The outward tables hold the facets of the reference cell, in its order."""
    import basix

    kind = getattr(basix.CellType, cell)
    facets = basix.topology(kind)[-2]
    assert [sorted(f) for f in FACETS[cell]] == facets
    X = basix.geometry(kind)
    outward = basix.cell.facet_outward_normals(kind)
    for local, normal in zip(FACETS[cell], outward, strict=True):
        edges = X[list(local[1 : X.shape[1]])] - X[local[0]]
        n = np.cross(*edges) if len(edges) == 2 else np.array([edges[0, 1], -edges[0, 0]])
        assert n @ normal > 0.99 * np.linalg.norm(n)


def test_unknown_group() -> None:
    with pytest.raises(MeshError, match="no group 'lid'; groups: left, right"):
        spread(block(2, 2)).surface("lid")


def test_somebody_gives_the_mesh() -> None:
    if COMM.size == 1:
        with pytest.raises(ValueError, match="rank 0"):
            distribute(COMM, None)
