"""What contact asks of an interface in space."""

import numpy as np
import pytest
from spatial_surfaces import grid, mesh_of, two_grids

from mpi4py import MPI

from contactfem.mortar.evaluation import operators_at
from contactfem.mortar.facet_areas import full_areas
from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.mortar_operators import Weights
from contactfem.mortar.search_range import SearchRange
from contactfem.mortar.spatial_operators import jumps

RADIUS = 0.3


def bent(X):
    return X + (0.3 * X[:, :1] ** 2 + 0.2 * X[:, :1] * X[:, 1:2]) * (0, 0, 1)


def partly(mesh, basis="dual"):
    """The same interface with prescribed nodes along one edge, a symmetry plane along another, and
    a shared node."""
    X, n = mesh.X, mesh.n_nonmortar
    free = np.ones(X.shape, bool)
    free[:n][X[:n, 0] < -0.49] = False
    free[:n, 1] &= X[:n, 1] > -0.49
    shared = np.arange(n) == np.argmin(np.hypot(X[:n, 0] - 0.2, X[:n, 1] - 0.2))
    return InterfaceMesh(n, mesh.nonmortar, mesh.mortar, X, free, basis, shared=shared)


def operators(mesh, x, comm=MPI.COMM_SELF):
    k = len(mesh.nonmortar)
    mine = np.arange(k * comm.rank // comm.size, k * (comm.rank + 1) // comm.size)
    reach = SearchRange.within(RADIUS, len(mesh.nonmortar))
    return operators_at(comm, mesh, x, mine, reach)


def scene(ka, kb, basis="dual"):
    mesh = partly(two_grids(4, ka, 5, kb, 0.2, 0.9, 0.05), basis)
    x = bent(mesh.X)
    rng = np.random.default_rng(2)
    n = mesh.n_nonmortar
    active = mesh.has_multiplier & (operators(mesh, x).D > 0.0) & (rng.random(n) > 0.2)

    def some(*shape):
        values = rng.normal(size=(n, *shape))
        values[~active] = 0.0
        return values

    weights = Weights(active, some(3), some(3), some(3, 3), some(3))
    return mesh, x, weights, rng.normal(size=x.shape)


def sums(mesh, x, weights):
    op = operators(mesh, x)
    gap = np.where(weights.active, op.gap, 0.0)
    v = jumps(x, op.M)
    rows = weights.D * op.D[:, None] + weights.gap * gap[:, None]
    rows += np.einsum("jik,jk->ji", weights.jump, v)
    D = np.where(weights.active, op.D, 0.0)
    return np.concatenate(((-op.M.T @ weights.multiplier).ravel(), rows.ravel(), D))


@pytest.mark.parametrize("basis", ["dual", "standard"])
@pytest.mark.parametrize("ka", [3, 4])
@pytest.mark.parametrize("kb", [3, 4])
def test_derivative(ka, kb, basis):
    mesh, x, weights, way = scene(ka, kb, basis)
    h = 1e-5
    f = [sums(mesh, x + k * h * way, weights) for k in (-2, -1, 1, 2)]
    expected = (8 * (f[2] - f[1]) - f[3] + f[0]) / (12 * h)
    found = operators(mesh, x).derivative(weights).scipy() @ way.ravel()
    ends = np.cumsum([3 * mesh.n_nodes, 3 * mesh.n_nonmortar])
    for a, b in zip(np.split(found, ends), np.split(expected, ends), strict=True):
        assert abs(a - b).max() <= 1e-9 * abs(b).max()


@pytest.mark.parametrize(("ka", "kb"), [(3, 4), (4, 3)])
def test_nodes_without_multiplier(ka, kb):
    """Their areas stand with the others', so that rows add up and all forces balance."""
    mesh = partly(two_grids(5, ka, 4, kb, 0.2, 1.6, 0.05))
    op = operators(mesh, bent(mesh.X))
    assert 0 < mesh.has_multiplier.sum() < mesh.n_nonmortar
    np.testing.assert_array_equal(op.D[~mesh.has_multiplier], 0.0)
    assert op.M[~mesh.has_multiplier].nnz == 0
    np.testing.assert_allclose(np.asarray(op.M.sum(1)).ravel(), op.D, rtol=0, atol=1e-15)
    # a uniform pressure reaches all of both sides
    own = op.D - np.asarray(op.M[:, : len(op.D)].sum(0)).ravel()
    np.testing.assert_allclose(own, full_areas(mesh, op.x), rtol=1e-12)
    other = np.asarray(op.M[:, len(op.D) :].sum())
    assert other == pytest.approx(op.full.sum(), rel=1e-13)


@pytest.mark.parametrize("height", [-0.01, 0.0, 0.02])
def test_gap_of_flat_surfaces(height):
    mesh = two_grids(4, 4, 5, 3, height=height)
    op = operators(mesh, mesh.X)
    np.testing.assert_allclose(op.gap, height, rtol=0, atol=1e-15)
    np.testing.assert_allclose(op.coverage, 1.0, rtol=1e-12)
    np.testing.assert_allclose(op.normals.n, np.broadcast_to([0, 0, 1.0], (len(op.D), 3)))


def test_nothing_covered():
    """Surfaces beyond the search radius."""
    mesh = two_grids(2, 4, 2, 4, height=1.0)
    op = operators(mesh, mesh.X)
    assert np.isinf(op.gap).all()
    np.testing.assert_array_equal(op.D, 0.0)
    zero = np.zeros((mesh.n_nonmortar, 3))
    weights = Weights(np.zeros(len(zero), bool), zero, zero, np.zeros((len(zero), 3, 3)), zero)
    assert not op.derivative(weights).values.any()


def test_normals_on_symmetry_planes():
    X, facets = grid(3, 4)
    free = np.ones((2 * len(X), 3), bool)
    free[: len(X), 0] = X[:, 0] > -0.49
    mesh = mesh_of(len(X), facets, facets[:, ::-1] + len(X), np.vstack((X, X)), free=free)
    n = operators(mesh, bent(mesh.X)).normals.n
    np.testing.assert_array_equal(n[X[:, 0] < -0.49, 0], 0.0)
    np.testing.assert_allclose(np.linalg.norm(n, axis=1), 1.0)


@pytest.mark.mpi
def test_ranks():
    """The operators are the same on all ranks as on one, and parts of derivatives add up."""
    comm = MPI.COMM_WORLD
    mesh, x, weights, way = scene(4, 3)
    alone, shared = operators(mesh, x), operators(mesh, x, comm)
    np.testing.assert_array_equal(shared.D, alone.D)
    np.testing.assert_array_equal(shared.M.toarray(), alone.M.toarray())
    np.testing.assert_array_equal(shared.gap, alone.gap)
    part = shared.derivative(weights).scipy() @ way.ravel()
    whole = alone.derivative(weights).scipy() @ way.ravel()
    np.testing.assert_allclose(comm.allreduce(part), whole, rtol=0, atol=1e-13 * abs(whole).max())
