"""Nodal values go from mesh to mesh of a body: what is exact, what is kept, on any ranks."""

from dataclasses import replace

import basix.ufl
import numpy as np
import pytest
from dolfinx import fem

from mpi4py import MPI

from contactfem.errors import MeshError
from contactfem.fem.body_mesh import BodyMesh, distribute
from contactfem.fem.vertex_values import VertexValues, insert, replicate
from contactfem.meshes.block import Block
from contactfem.meshes.box import Box
from contactfem.meshes.cylinder import Cylinder
from contactfem.meshes.data import MeshData, Surface
from contactfem.meshes.disk import Disk, Ring
from contactfem.meshes.graded_block import GradedBlock
from contactfem.meshes.wave import Wave
from contactfem.transfer.matching import FAR
from contactfem.transfer.surface import SurfaceTransfer, conserving
from contactfem.transfer.volume import VolumeTransfer

COMM = MPI.COMM_WORLD
SELF = MPI.COMM_SELF


def spread(data: MeshData) -> BodyMesh:
    return distribute(COMM, data if COMM.rank == 0 else None)


def transfer(source: MeshData, target: MeshData) -> VolumeTransfer:
    return VolumeTransfer(COMM, spread(source), spread(target), "tire")


def block(n: int, cell: str = "triangle", ny: int | None = None) -> MeshData:
    return Block(width=2.0, height=1.0, nx=n, ny=ny or n, cell=cell).build()


def disk(facets: int) -> MeshData:
    return Disk(radius=1.0, facets=facets, layers=facets // 8).build()


def ring(facets: int) -> MeshData:
    return Ring(inner_radius=1.0, outer_radius=2.0, facets=facets, layers=facets // 8).build()


def wave(n: int, cell: str = "triangle") -> MeshData:
    shape = {"width": 1.0, "height": 1.0, "amplitude": 0.05, "wavelength": 0.5}
    return Wave(**shape, nx=n, ny=n, cell=cell).build()


def cylinder(size: float, cell: str) -> MeshData:
    return Cylinder(radius=1.0, zone=0.2, size=size, growth=0.3, cell=cell).build()


def graded(size: float) -> MeshData:
    """Cells from `size` to a quarter of the body, twice as long from one to the next."""
    shape = {"width": 1.0, "height": 1.0, "zone": (0.4999, 0.5001)}
    return GradedBlock(**shape, size=size, growth=1.0, coarse=0.25).build()


def linear(X: np.ndarray) -> np.ndarray:
    return 50.0 + X @ np.array([[3.0, -5.0, 7.0], [1.0, 2.0, -4.0]])[:, : X.shape[1]].T


def box(n: int, cell: str) -> MeshData:
    return Box(width=1.0, height=1.0, depth=1.0, nx=n, ny=n, nz=n, cell=cell).build()


PAIRS = {
    "triangles": (block(5), block(40)),
    "quadrilaterals": (block(5, "quadrilateral"), block(40, "quadrilateral")),
    "both": (block(5, "triangle"), block(7, "quadrilateral")),
    "disks": (disk(16), disk(128)),
    "rings": (ring(24), ring(136)),
    "cylinders": (cylinder(0.08, "triangle"), cylinder(0.01, "quadrilateral")),
    "waves": (wave(12, "quadrilateral"), wave(97)),
    "graded": (graded(1e-4), Block(width=1.0, height=1.0, nx=4, ny=4).build()),
    "tetrahedra": (box(2, "tetrahedron"), box(5, "hexahedron")),
}


@pytest.mark.mpi
@pytest.mark.quick
@pytest.mark.parametrize("back", [False, True])
@pytest.mark.parametrize("name", PAIRS)
def test_linear_fields_are_reproduced(name: str, back: bool) -> None:
    """Coarse to fine and fine to coarse, on curved boundaries too, by matrices of equal rows."""
    source, target = PAIRS[name][::-1] if back else PAIRS[name]
    operator = transfer(source, target)
    assert operator.matrix.shape == (len(target.points), len(source.points))
    np.testing.assert_allclose(operator(linear(source.points)), linear(target.points), rtol=1e-12)
    np.testing.assert_allclose(operator(np.ones(len(source.points))), 1.0, rtol=1e-12)
    curved = name in ("disks", "rings", "cylinders", "waves")
    assert (operator.farthest > 0.0) == curved


@pytest.mark.mpi
@pytest.mark.quick
def test_the_farthest_vertex() -> None:
    """Corners of the outer 16-gon are those of the octagon, or lie over the middles of its sides.

    All inner ones lie in the other ring, or nearer to it: those polygons have the same area.
    """
    coarse, fine = (
        Ring(inner_radius=1.0, outer_radius=2.0, facets=n, layers=2).build() for n in (8, 16)
    )
    assert transfer(fine, coarse).farthest == 0.0
    farthest = transfer(coarse, fine).farthest
    assert farthest == pytest.approx(2.0 * (1.0 - np.cos(np.pi / 8)), rel=1e-12)


@pytest.mark.mpi
@pytest.mark.quick
@pytest.mark.parametrize("make", [disk, wave])
def test_smooth_fields_at_second_order(make) -> None:
    """The maximal error falls with h², on curved boundaries and inside."""
    target = make(104)
    errors = []
    for n in (16, 32, 64):
        source = make(n)
        smooth = [np.sin(2 * d.points[:, 0]) * np.exp(d.points[:, 1]) for d in (source, target)]
        errors.append(np.abs(transfer(source, target)(smooth[0]) - smooth[1]).max())
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (rates > 1.8).all(), rates


@pytest.mark.mpi
@pytest.mark.quick
def test_the_same_mesh_is_the_identity() -> None:
    data = disk(16)
    operator = transfer(data, replace(data, points=data.points.copy(), groups={}))
    n = len(data.points)
    assert operator.matrix.nnz == n
    assert (operator.matrix != transfer(data, data).matrix).nnz == 0
    values = np.arange(3.0 * n).reshape(n, 3)
    np.testing.assert_array_equal(operator(values), values)
    assert operator.farthest == 0.0


@pytest.mark.mpi
@pytest.mark.quick
@pytest.mark.parametrize("name", PAIRS)
def test_the_same_matrix_on_all_ranks(name: str) -> None:
    """To the last bit that of one rank alone; some of three ranks may hold no cell."""
    both = transfer(*PAIRS[name])
    alone = VolumeTransfer(SELF, *(distribute(SELF, data) for data in PAIRS[name]), "tire")
    np.testing.assert_array_equal(both.matrix.indptr, alone.matrix.indptr)
    np.testing.assert_array_equal(both.matrix.indices, alone.matrix.indices)
    np.testing.assert_array_equal(both.matrix.data, alone.matrix.data)
    assert both.farthest == alone.farthest


@pytest.mark.mpi
@pytest.mark.quick
def test_other_bodies_are_refused_on_all_ranks() -> None:
    """A mesh moved by less than half a cell passes; farther, the error says how far and whose."""
    data = block(4, "quadrilateral")
    size = np.hypot(0.5, 0.25)
    for far, passes in ((0.99 * FAR * size, True), (1.01 * FAR * size, False)):
        moved = replace(data, points=data.points + np.array([0.0, far]))
        if passes:
            assert transfer(data, moved).farthest == pytest.approx(far, rel=1e-12)
        else:
            with pytest.raises(MeshError, match=rf"'tire'.*5 of 25 .*lies {far:.3g} m away"):
                transfer(data, moved)


@pytest.mark.mpi
@pytest.mark.quick
def test_large_cells_excuse_vertices_of_either_mesh() -> None:
    """A coarse target's corners may lie farther from a fine source than its cells are long."""
    fine, coarse = block(64, "quadrilateral"), block(2, "quadrilateral")
    moved = replace(coarse, points=coarse.points + np.array([0.1, 0.0]))
    assert transfer(fine, moved).farthest == pytest.approx(0.1, rel=1e-12)
    assert transfer(moved, fine).farthest == pytest.approx(0.1, rel=1e-12)


def mini(body: BodyMesh) -> fem.FunctionSpace:
    cell = body.mesh.basix_cell()
    P1, bubble = basix.ufl.element("Lagrange", cell, 1), basix.ufl.element("Bubble", cell, 3)
    vector = basix.ufl.blocked_element(basix.ufl.enriched_element([P1, bubble]), shape=(2,))
    return fem.functionspace(body.mesh, basix.ufl.mixed_element([vector, P1]))


@pytest.mark.mpi
@pytest.mark.quick
@pytest.mark.parametrize("n", [1, 9])
def test_replicated_and_inserted(n: int) -> None:
    """Scalar, vector and MINI spaces, owned and ghost values, also where a rank has no cell."""
    data = block(n)
    body = spread(data)
    W = mini(body)
    spaces = {(): ("Lagrange", 1), (2,): ("Lagrange", 1, (2,))}
    plain = [fem.functionspace(body.mesh, element) for element in spaces.values()]
    for V, function in [(V, fem.Function(V)) for V in plain] + [(W.sub(0), fem.Function(W))]:
        components = max(1, V.num_sub_spaces)
        wanted = np.arange(1.0, components * len(data.points) + 1).reshape(-1, components)
        before = function.x.array.copy()
        insert(body, V, wanted, function.x.array)
        # ghosts have what their owners have
        inserted = function.x.array.copy()
        function.x.scatter_forward()
        np.testing.assert_array_equal(function.x.array, inserted)
        # nothing else was written
        here = body.mesh.topology.index_map(0)
        written = np.count_nonzero(inserted != before)
        assert written == components * (here.size_local + here.num_ghosts)
        np.testing.assert_array_equal(replicate(COMM, body, V, function.x.array), wanted)
        # owned values are enough
        function.x.array[V.dofmap.index_map.size_local * V.dofmap.index_map_bs :] = np.nan
        again = VertexValues(COMM, body, V).replicate(function.x.array)
        np.testing.assert_array_equal(again, wanted)


@pytest.mark.mpi
@pytest.mark.quick
def test_from_function_to_function() -> None:
    """A linear displacement of MINI triangles arrives in the bilinear one of quadrilaterals."""
    source, target = spread(block(6)), spread(block(9, "quadrilateral"))
    W, V = mini(source), fem.functionspace(target.mesh, ("Lagrange", 1, (2,)))
    u, arrived, wanted = fem.Function(W), fem.Function(V), fem.Function(V)

    def field(x: np.ndarray) -> np.ndarray:
        return np.stack([1.0 + x[0] - 2.0 * x[1], 5.0 - x[1]])

    u.sub(0).interpolate(field)
    wanted.interpolate(field)
    operator = VolumeTransfer(COMM, source, target, "tire")
    values = operator(replicate(COMM, source, W.sub(0), u.x.array))
    insert(target, V, values, arrived.x.array)
    np.testing.assert_allclose(arrived.x.array, wanted.x.array, rtol=1e-12, atol=1e-12)


# Along surfaces


def arc(size: float) -> Surface:
    return cylinder(size, "quadrilateral").surface("arc")


def top(n: int) -> Surface:
    return block(n, ny=1).surface("top")


def lengths(surface: Surface) -> np.ndarray:
    """∫ N_K dΓ."""
    size = np.linalg.norm(np.diff(surface.X[surface.facets], axis=1)[:, 0], axis=1)
    return np.bincount(surface.facets.ravel(), np.repeat(size / 2, 2))


@pytest.mark.parametrize(("n", "m"), [(5, 40), (40, 5), (7, 9)])
def test_straight_surfaces_carry_linear_fields(n: int, m: int) -> None:
    source, target = top(n), top(m)
    operator = SurfaceTransfer(source, target, "top")
    np.testing.assert_allclose(operator(linear(source.X)), linear(target.X), rtol=1e-12)
    assert operator.farthest == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(("n", "m"), [(0.08, 0.01), (0.01, 0.08), (0.03, 0.029)])
def test_bounds_are_kept_along_surfaces(n: float, m: float) -> None:
    """Weights in [0, 1] of the sum 1, also beyond the chords; rough densities stay in bounds."""
    source, target = arc(n), arc(m)
    operator = SurfaceTransfer(source, target, "arc")
    assert operator.farthest > 1e-6
    assert operator.matrix.data.min() >= 0.0
    assert operator.matrix.data.max() <= 1.0
    np.testing.assert_allclose(operator.matrix.sum(axis=1), 1.0, rtol=1e-14)
    rough = np.random.default_rng(0).choice([0.0, 1e9], len(source.X))
    assert operator(rough).min() >= 0.0
    assert operator(rough).max() <= 1e9 * (1 + 1e-14)


def test_curved_surfaces_at_second_order() -> None:
    target = arc(0.003)
    errors = []
    for size in (0.08, 0.04, 0.02):
        source = arc(size)
        fine = np.abs(target.X[:, 0]) < 0.2
        smooth = [np.sin(8 * s.X[:, 0]) for s in (source, target)]
        error = SurfaceTransfer(source, target, "arc")(smooth[0]) - smooth[1]
        errors.append(np.abs(error[fine]).max())
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (rates > 1.7).all(), rates


def test_the_same_surface_is_the_identity() -> None:
    surface = arc(0.05)
    operator = SurfaceTransfer(surface, replace(surface, X=surface.X.copy()), "arc")
    values = np.random.default_rng(0).uniform(size=(len(surface.X), 2))
    np.testing.assert_array_equal(operator(values), values)


@pytest.mark.parametrize("cell", ["tetrahedron", "hexahedron"])
def test_surfaces_of_solids(cell: str) -> None:
    source, target = box(2, cell).surface("top"), box(5, "hexahedron").surface("top")
    operator = SurfaceTransfer(source, target, "top")
    np.testing.assert_allclose(operator(linear(source.X)), linear(target.X), rtol=1e-12)
    assert operator.matrix.data.min() >= 0.0


def test_another_surface_is_refused() -> None:
    surface = top(4)
    for far, passes in ((0.24, True), (0.26, False)):
        moved = replace(surface, X=surface.X + np.array([0.0, far]))
        if passes:
            operator = SurfaceTransfer(surface, moved, "block.top")
            assert operator.farthest == pytest.approx(far, rel=1e-12)
        else:
            with pytest.raises(MeshError, match=r"'block\.top'.* 5 of 5 .*lies 0\.26 m away"):
                SurfaceTransfer(surface, moved, "block.top")


def parabola(surface: Surface, middle: float, half: float) -> np.ndarray:
    """Density with the integral 4/3 half."""
    return np.maximum(0.0, 1.0 - ((surface.X[:, 0] - middle) / half) ** 2)


@pytest.mark.parametrize(("n", "m"), [(320, 40), (40, 320), (40, 40), (53, 47)])
def test_totals_are_conserved(n: int, m: int) -> None:
    """A Hertz-like patch: the total to round-off, the raw defect small and as it is."""
    source, target = top(n), top(m)
    density = parabola(source, 0.9371, 0.2)
    total = lengths(source) @ density
    operator = SurfaceTransfer(source, target, "top")
    values, defect = operator.conserved(density, lengths(target), total)
    assert lengths(target) @ values == pytest.approx(total, rel=4e-16)
    raw = operator(density)
    np.testing.assert_allclose(values / values.max(), raw / raw.max(), rtol=1e-12)
    missing = lengths(target) @ raw - total
    assert defect == pytest.approx(missing / max(total, total + missing), rel=1e-9, abs=1e-15)
    # where the target has all of the source's nodes nothing is lost
    assert (abs(defect) > 1e-6) == (m % n != 0)


def test_the_defect_of_interpolation_is_of_second_order() -> None:
    """Below h² by the Euler-Maclaurin formula: h²/12 times the slopes 4 at both ends, over 2/3."""
    fine = top(4000)
    density = parabola(fine, 0.9371, 0.5)
    total = lengths(fine) @ density
    for n in (20, 40, 80, 160, 320):
        target = top(n)
        defect = SurfaceTransfer(fine, target, "top").conserved(density, lengths(target), total)[1]
        assert 0.0 < abs(defect) < 1.01 * (2.0 / n) ** 2


@pytest.mark.parametrize("middle", [1.1, 1.24, 0.02, 1.99])
def test_a_patch_between_two_nodes_is_not_lost(middle: float) -> None:
    """Interpolation misses all of it; its power goes to the ends of the facet it lies on."""
    source, target = top(800), top(8)
    density = parabola(source, middle, 0.008)
    total = lengths(source) @ density
    operator = SurfaceTransfer(source, target, "top")
    assert total > 0.0
    assert not operator(density).any()
    values, defect = operator.conserved(density, lengths(target), total)
    assert defect == -1.0
    assert lengths(target) @ values == pytest.approx(total, rel=1e-15)
    assert values.min() >= 0.0
    loaded = np.flatnonzero(values)
    assert (np.abs(target.X[loaded, 0] - middle) < 0.25).all()
    # and the power's centre stays, for the shares are those of interpolation
    centre = (lengths(target) * values) @ target.X[:, 0] / total
    assert centre == pytest.approx(middle, abs=1e-3)


def test_conserving() -> None:
    """By hand: rescaled, all missing, nothing wanted, nothing at all, and contradictions."""
    weights = np.array([1.0, 2.0, 1.0])
    values, defect = conserving(np.array([1.0, 2.0, 3.0]), weights, 16.0)
    np.testing.assert_array_equal(values, [2.0, 4.0, 6.0])
    assert defect == -0.5
    values, defect = conserving(np.array([-1.0, -2.0, -3.0]), weights, -4.0)
    np.testing.assert_array_equal(values, [-0.5, -1.0, -1.5])
    assert defect == -0.5
    values, defect = conserving(np.ones(3), weights, 0.0)
    np.testing.assert_array_equal(values, 0.0)
    assert defect == 1.0
    assert conserving(np.zeros(3), weights, 0.0)[1] == 0.0
    for wrong in (np.zeros(3), -np.ones(3)):
        with pytest.raises(ValueError, match="cannot be scaled to 2"):
            conserving(wrong, weights, 2.0)
