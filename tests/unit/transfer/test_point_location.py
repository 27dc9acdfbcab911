"""Points are found in the cells that hold them, whatever the sizes of cells and the domain."""

import numpy as np
import pytest

from contactfem.geometry.bounding_boxes import BoxTree
from contactfem.geometry.closest_point import NearestFacets
from contactfem.meshes.block import Block
from contactfem.meshes.box import Box
from contactfem.meshes.cylinder import Cylinder
from contactfem.meshes.data import FACETS, MeshData, jacobians, mesh_data
from contactfem.meshes.disk import Disk, Ring
from contactfem.meshes.graded_block import GradedBlock
from contactfem.meshes.wave import Wave
from contactfem.transfer.point_location import Location, Places, surroundings
from contactfem.transfer.shape_functions import linear_weights, pull_back, shape_functions

UNIT = {"width": 1.0, "height": 1.0}


def block(n: int, cell: str, **more: object) -> MeshData:
    return Block(**UNIT, nx=n, ny=n, cell=cell, **more).build()


def skewed(data: MeshData, by: float, seed: int = 0) -> MeshData:
    """The same mesh with its inner points moved by a part of a cell."""
    rng = np.random.default_rng(seed)
    X = data.points
    inner = ((X > X.min(0) + 1e-9) & (X < X.max(0) - 1e-9)).all(1)
    size = 1.0 / (round(len(X) ** (1 / X.shape[1])) - 1)
    moved = X + inner[:, None] * rng.uniform(-by, by, X.shape) * size
    return mesh_data(moved, data.cells, data.cell_type, data.groups)


def linear(X: np.ndarray) -> np.ndarray:
    return 50.0 + X @ np.array([3.0, -5.0, 7.0])[: X.shape[1]]


def located(data: MeshData, points: np.ndarray) -> tuple[Places, np.ndarray]:
    """Places of points, and a linear field there."""
    places = Location(data).places(points, points)
    nodes = data.cells[places.cells]
    return places, np.einsum("nv,nv->n", places.weights, linear(data.points)[nodes])


def in_cells(data: MeshData, n: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Random cells, and a random point well inside each."""
    rng = np.random.default_rng(seed)
    cells = rng.integers(len(data.cells), size=n)
    if data.cell_type in ("triangle", "tetrahedron"):
        weights = rng.dirichlet(np.full(data.cells.shape[1], 2.0), n)
    else:
        xi = rng.uniform(0.01, 0.99, (n, data.points.shape[1]))
        weights = shape_functions(data.cell_type, xi)[0]
    return cells, np.einsum("nv,nvd->nd", weights, data.points[data.cells[cells]])


CUBE = UNIT | {"depth": 1.0, "nx": 5, "ny": 5, "nz": 5}
BODIES = {
    "triangles": skewed(block(9, "triangle"), 0.25),
    "quadrilaterals": skewed(block(9, "quadrilateral"), 0.25),
    "tetrahedra": skewed(Box(**CUBE, cell="tetrahedron").build(), 0.15),
    "hexahedra": skewed(Box(**CUBE, cell="hexahedron").build(), 0.15),
    "disk": Disk(radius=2.0, facets=40, layers=4).build(),
    "ring": Ring(inner_radius=1.0, outer_radius=2.0, facets=40, layers=3).build(),
    "fan": Cylinder(radius=1.0, zone=0.1, size=0.01, cell="quadrilateral").build(),
    "wave": Wave(**UNIT, nx=12, ny=6, amplitude=0.1, wavelength=0.5).build(),
    "thousandfold": block(2, "triangle", grading=(1e3, 1e-3)),
    "comb": Block(**UNIT, nx=300, ny=2, cell="triangle", grading=(1.0, 1e3)).build(),
    "graded": GradedBlock(
        **UNIT, zone=(0.4999, 0.5001), size=1e-4, growth=1.0, coarse=0.25
    ).build(),
}


@pytest.mark.parametrize("name", BODIES)
def test_points_are_found_in_their_cells(name: str) -> None:
    data = BODIES[name]
    cells, points = in_cells(data, 3000)
    places, values = located(data, points)
    np.testing.assert_array_equal(places.cells, cells)
    np.testing.assert_array_equal(places.distance, 0.0)
    np.testing.assert_allclose(values, linear(points), rtol=1e-12)
    assert places.weights.min() > 0.0


@pytest.mark.parametrize("name", BODIES)
def test_vertices_have_the_weight_one(name: str) -> None:
    data = BODIES[name]
    middle = surroundings(data.points, data.cells)[0]
    places = Location(data).places(data.points, middle)
    nodes = data.cells[places.cells]
    own = nodes == np.arange(len(data.points))[:, None]
    np.testing.assert_array_equal(own.sum(1), 1)
    np.testing.assert_allclose(places.weights[own], 1.0, rtol=1e-12)
    np.testing.assert_allclose(places.weights[~own], 0.0, atol=1e-9)
    np.testing.assert_array_equal(places.distance, 0.0)


@pytest.mark.parametrize("name", BODIES)
def test_outside_linear_fields_go_on(name: str) -> None:
    """Weights are exact for linear fields, the distance is that to the nearest boundary facet."""
    data = BODIES[name]
    _, points = in_cells(data, 300)
    outside = 1.3 * points + [8.0, 1.0, 0.5][: points.shape[1]]
    places, values = located(data, outside)
    np.testing.assert_allclose(values, linear(outside), rtol=1e-12)
    vertex = np.linalg.norm(outside[:, None] - data.points, axis=2).min(axis=1)
    assert (places.distance >= outside[:, 0] - data.points[:, 0].max()).all()
    assert (places.distance <= vertex * (1 + 1e-12)).all()


def test_distance_and_field_outside_of_a_square() -> None:
    """By hand: beside a side and beyond a corner, with the bilinear cell's field continued."""
    points = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    square = mesh_data(points, np.array([[0, 1, 2, 3]]), "quadrilateral", {})
    places = Location(square).places(np.array([[0.25, 1.5], [4.0, 5.0]]), np.full((2, 2), 0.5))
    np.testing.assert_allclose(places.distance, [0.5, 5.0], rtol=1e-12)
    # xy beyond (1/4, 1): 1/4 + (1/2) (1/4); beyond (1, 1): 1 + 3 + 4
    xy = np.array([0.0, 0.0, 0.0, 1.0])
    by_vertex = places.weights @ xy[square.cells[0]]
    np.testing.assert_allclose(by_vertex, [0.375, 8.0], rtol=1e-12)


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
def test_round_off_does_not_lead_outside(cell: str) -> None:
    data = block(3, cell)
    x = np.linspace(0.0, 1.0, 50)
    below = np.column_stack((x, np.full(50, -1e-12)))
    places, values = located(data, below)
    np.testing.assert_array_equal(places.distance, 0.0)
    np.testing.assert_allclose(values, linear(below), rtol=1e-14)
    assert located(data, below - np.array([0.0, 1e-6]))[0].distance.min() > 0.9e-6


def slit(n: int, cell: str, width: float = 0.0) -> MeshData:
    """Unit square cut along y = 1/2 from its middle to its right side; n is even."""
    data = block(n, cell)
    on = np.flatnonzero((np.abs(data.points[:, 1] - 0.5) < 1e-9) & (data.points[:, 0] > 0.5 + 1e-9))
    twin = np.arange(len(data.points))
    twin[on] = len(data.points) + np.arange(len(on))
    points = np.concatenate([data.points, data.points[on]])
    above = points[data.cells].mean(axis=1)[:, 1] > 0.5
    cells = np.where(above[:, None], twin[data.cells], data.cells)
    points[len(data.points) :, 1] += width
    return mesh_data(points, cells, cell, {})


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
@pytest.mark.parametrize(("n", "m"), [(8, 24), (24, 8), (10, 14)])
def test_each_lip_of_a_slit_keeps_its_values(cell: str, n: int, m: int) -> None:
    source, target = slit(n, cell), slit(m, cell)
    # opened like a wedge: above y = 1/2, and there alone, the field rises with x - 1/2
    lips = [np.zeros(len(d.points)) for d in (source, target)]
    for data, value in zip((source, target), lips, strict=True):
        upper = np.unique(data.cells[data.points[data.cells].mean(axis=1)[:, 1] > 0.5])
        value[upper] = np.maximum(data.points[upper, 0] - 0.5, 0.0)
    middle = surroundings(target.points, target.cells)[0]
    places = Location(source).places(target.points, middle)
    values = np.einsum("nv,nv->n", places.weights, lips[0][source.cells[places.cells]])
    np.testing.assert_allclose(values, lips[1], atol=1e-12)


def test_the_nearest_centroid_may_lie_beyond_a_slit() -> None:
    """Large cells below an open slit, small ones above: what is below stays below."""
    low, high = block(2, "quadrilateral"), block(40, "quadrilateral")
    points = np.concatenate([low.points, high.points + np.array([0.0, 1.001])])
    cells = np.concatenate([low.cells, high.cells + len(low.points)])
    data = mesh_data(points, cells, "quadrilateral", {})
    x = np.linspace(0.01, 0.99, 50)
    for y, lower in ((0.9999, True), (1.0002, True), (1.0008, False), (1.0012, False)):
        at = np.column_stack((x, np.full_like(x, y)))
        places = Location(data).places(at, at)
        np.testing.assert_array_equal(places.cells < len(low.cells), lower)
        gap = max(0.0, min(y - 1.0, 1.001 - y))
        np.testing.assert_allclose(places.distance, gap, atol=1e-12)


def test_what_is_said_of_a_point_does_not_depend_on_the_others() -> None:
    data = BODIES["ring"]
    rng = np.random.default_rng(0)
    points = rng.uniform(-2.2, 2.2, (500, 2))
    together = Location(data).places(points, np.zeros((500, 2)))
    for part in (slice(0, 1), slice(123, 337), slice(498, 500)):
        alone = Location(data).places(points[part], np.zeros((500, 2))[part])
        np.testing.assert_array_equal(alone.cells, together.cells[part])
        np.testing.assert_array_equal(alone.weights, together.weights[part])
        np.testing.assert_array_equal(alone.distance, together.distance[part])


def test_no_points() -> None:
    for data in (BODIES["ring"], BODIES["graded"]):
        places = Location(data).places(np.empty((0, 2)), np.empty((0, 2)))
        assert places.weights.shape == (0, data.cells.shape[1])
        assert len(places.cells) == len(places.distance) == 0


def test_long_cells() -> None:
    """A thousand times longer than wide, far from the origin."""
    data = Block(width=1.0, height=1e-3, corner=(7.0, 3.0), nx=3, ny=3, cell="triangle").build()
    cells, points = in_cells(data, 500)
    places, values = located(data, points)
    np.testing.assert_array_equal(places.cells, cells)
    np.testing.assert_allclose(values, linear(points), rtol=1e-12)


@pytest.mark.parametrize("cell", ["quadrilateral", "hexahedron"])
def test_bent_cells_are_inverted(cell: str) -> None:
    """Cells bent almost to a triangle or a twist: Newton's method finds the way back in all."""
    rng = np.random.default_rng(1)
    dim = 2 if cell == "quadrilateral" else 3
    corners = shape_functions(cell, np.zeros((1, dim)))[0].shape[1]
    unit = np.array([[(k >> a) & 1 for a in range(dim)] for k in range(corners)], dtype=float)
    bend = 0.9 if dim == 2 else 0.3
    X = unit + rng.uniform(-bend, bend, (20_000, corners, dim))
    cells = np.arange(len(X) * corners).reshape(-1, corners)
    det = jacobians(X.reshape(-1, dim), cells, cell).min(axis=1)
    X = X[det > (0.01 if dim == 2 else 0.2)]
    assert len(X) > 1000
    xi = rng.uniform(0, 1, (len(X), dim))
    points = np.einsum("mv,mvd->md", shape_functions(cell, xi)[0], X)
    np.testing.assert_allclose(pull_back(cell, X, points), xi, atol=1e-9)


@pytest.mark.parametrize("cell", FACETS)
def test_shape_functions(cell: str) -> None:
    """As basix has them, values and derivatives."""
    import basix

    kind = getattr(basix.CellType, cell)
    element = basix.create_element(basix.ElementFamily.P, kind, 1)
    xi = basix.create_lattice(kind, 4, basix.LatticeType.equispaced, True)
    values, slopes = shape_functions(cell, xi)
    table = element.tabulate(1, xi)[..., 0]
    np.testing.assert_allclose(values, table[0], atol=1e-14)
    np.testing.assert_allclose(slopes, np.moveaxis(table[1:], 0, 2), atol=1e-14)


@pytest.mark.parametrize("name", ["triangles", "quadrilaterals", "tetrahedra", "hexahedra"])
def test_weights_are_exact_where_the_reference_point_is_not(name: str) -> None:
    data = BODIES[name]
    cells, points = in_cells(data, 100)
    X = data.points[data.cells[cells]]
    off = pull_back(data.cell_type, X, points) + 0.05
    weights = linear_weights(data.cell_type, X, points, off)
    np.testing.assert_allclose(np.einsum("mv,mvd->md", weights, X), points, rtol=1e-12)


def test_boxes_that_meet() -> None:
    rng = np.random.default_rng(2)
    for n, m in ((1, 1), (1, 20), (3, 20), (100, 77), (1000, 0)):
        low, other = rng.uniform(size=(n, 2)), rng.uniform(size=(m, 2))
        # from very small to very large ones
        size, more = 10.0 ** rng.uniform(-4, 0, (n, 2)), 10.0 ** rng.uniform(-4, 0, (m, 2))
        pairs = BoxTree(low, low + size).meeting(other, other + more)
        meet = (other[:, None] <= low + size).all(2) & ((other + more)[:, None] >= low).all(2)
        expected = set(zip(*np.nonzero(meet), strict=True))
        assert set(zip(*pairs, strict=True)) == expected
        assert len(pairs[0]) == len(expected)
        assert (np.diff(pairs[0]) >= 0).all()


@pytest.mark.parametrize("dim", [2, 3])
def test_nearest_facets(dim: int) -> None:
    """Against sampling of random facets, of very different sizes."""
    rng = np.random.default_rng(3)
    k = 40
    middle = rng.uniform(size=(k, 1, dim))
    X = (middle + 10.0 ** rng.uniform(-3, 0, (k, 1, 1)) * rng.normal(size=(k, dim, dim))).reshape(
        -1, dim
    )
    facets = np.arange(k * dim).reshape(k, dim)
    points = rng.uniform(-1, 2, (200, dim))
    nearest, weights, distance = NearestFacets(X, facets).closest(points)
    at = np.einsum("mv,mvd->md", weights, X[facets[nearest]])
    np.testing.assert_allclose(np.linalg.norm(at - points, axis=1), distance, rtol=1e-12)
    assert weights.min() >= 0.0
    np.testing.assert_allclose(weights.sum(1), 1.0, rtol=1e-14)
    steps = 60
    grid = np.stack(np.meshgrid(*[np.arange(steps + 1)] * (dim - 1)), -1).reshape(-1, dim - 1)
    grid = grid[grid.sum(1) <= steps] / steps
    samples = np.column_stack((1 - grid.sum(1), grid)) @ X[facets]
    sampled = np.linalg.norm(samples[:, :, None] - points, axis=3).min((0, 1))
    assert (distance <= sampled + 1e-12).all()
    assert (sampled - distance < 0.1).all()


def test_nearest_facet_at_a_distance_without_square() -> None:
    search = NearestFacets(np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([[0, 1]]))
    facets, weights, distance = search.closest(np.array([[-1e-200, 0.0]]))
    np.testing.assert_array_equal(facets, [0])
    np.testing.assert_array_equal(weights, [[1.0, 0.0]])
    assert distance[0] < 1e-150
