"""Invariants of the mortar operators of surfaces in space."""

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from spatial_surfaces import grid, mesh_of, operators_of, polygons_of, two_grids

from contactfem.mortar import polygon_operators
from contactfem.mortar.facet_areas import areas, full_areas, full_areas_derivative
from contactfem.mortar.polygon_basis import facet_basis
from contactfem.mortar.polygon_operators import differentiate_polygons

PAIRINGS = list(itertools.product((3, 4), (3, 4)))


def operators(mesh, x, radius=0.3):
    return operators_of(mesh, polygons_of(mesh, x, radius))


def bent(X):
    return X + (0.3 * X[:, :1] ** 2 + 0.2 * X[:, :1] * X[:, 1:2]) * (0, 0, 1)


def forces(D, M, multiplier):
    force = -(M.T @ multiplier)
    force[: len(D)] += D[:, None] * multiplier
    return force


@pytest.mark.parametrize("basis", ["dual", "standard"])
@pytest.mark.parametrize("size", [1.5, 0.7])
@pytest.mark.parametrize(("ka", "kb"), PAIRINGS)
def test_rows_add_up_and_forces_balance(ka, kb, size, basis):
    mesh = two_grids(6, ka, 7, kb, 0.2, size, 0.02, basis)
    D, M = operators(mesh, bent(mesh.X))
    np.testing.assert_allclose(np.asarray(M.sum(1)).ravel(), D, rtol=0, atol=1e-15)
    assert (D >= 0).all()
    force = forces(D, M, np.random.default_rng(0).normal(size=(len(D), 3)))
    np.testing.assert_allclose(force.sum(0), 0, atol=1e-14)


@pytest.mark.parametrize("basis", ["dual", "standard"])
@pytest.mark.parametrize(("ka", "kb"), PAIRINGS)
def test_moment_of_flat_interfaces(ka, kb, basis):
    mesh = two_grids(5, ka, 7, kb, 0.2, 0.7, 0.0, basis)
    D, M = operators(mesh, mesh.X)
    force = forces(D, M, np.random.default_rng(1).normal(size=(len(D), 3)))
    np.testing.assert_allclose(np.cross(mesh.X, force).sum(0), 0, atol=1e-14)


@pytest.mark.parametrize(("ka", "kb"), PAIRINGS)
def test_covered_area(ka, kb):
    """Of a turned square within a larger one, and of a whole surface under a larger one."""
    small = two_grids(6, ka, 5, kb, 0.4, 0.6)
    assert operators(small, small.X)[0].sum() == pytest.approx(0.36, rel=1e-13)
    large = two_grids(6, ka, 5, kb, 0.4, 1.5)
    D = operators(large, large.X)[0]
    np.testing.assert_allclose(D, full_areas(large, large.X), rtol=1e-12)


@pytest.mark.parametrize(("ka", "kb"), PAIRINGS)
def test_full_coverage_of_warped_facets(ka, kb):
    """Every facet is seen in its own planes, so that D is the whole of it however it is warped."""
    mesh = two_grids(5, ka, 4, kb, 0.3, 1.8, 0.2)
    x = mesh.X.copy()
    x[: mesh.n_nonmortar] = bent(x[: mesh.n_nonmortar])
    np.testing.assert_allclose(operators(mesh, x, 1.0)[0], full_areas(mesh, x), rtol=1e-12)


@pytest.mark.parametrize(("ka", "kb"), PAIRINGS)
def test_rigid_motions(ka, kb):
    mesh = two_grids(4, ka, 5, kb, 0.2, 0.8, 0.02)
    x = bent(mesh.X)
    D, M = operators(mesh, x)
    turned = x @ Rotation.from_rotvec([0.7, -1.1, 0.9]).as_matrix().T + [3.0, 2, 1]
    D1, M1 = operators(mesh, turned)
    np.testing.assert_allclose(D1, D, rtol=0, atol=1e-15)
    slip = (M1 - M) @ turned - np.asarray((M1 - M).sum(1)) * turned[: len(D)]
    assert abs(slip).max() < 1e-13 * D.max()
    far = operators(mesh, x + 1e3)[0]
    np.testing.assert_allclose(far, D, rtol=0, atol=1e-11 * D.max())


def test_linear_fields_pass_flat_interfaces():
    """Weighted jumps of a linear field that both sides share add up to zero where all is flat."""
    for ka, kb in PAIRINGS:
        mesh = two_grids(4, ka, 6, kb, 0.3, 0.8)
        D, M = operators(mesh, mesh.X)
        field = mesh.X @ np.array([[1.0, 0.3, 0], [0.2, -1.0, 0], [0, 0, 0]])
        total = (D[:, None] * field[: len(D)]).sum(0)
        np.testing.assert_allclose((M @ field).sum(0), total, atol=1e-14)


def test_dual_functions():
    rng = np.random.default_rng(0)
    corner = rng.uniform(0.1, 1, (50, 9, 4))
    mass = np.einsum("fgi,fgj->fij", corner, corner)
    mass[::2, 3, :] = mass[::2, :, 3] = 0.0
    triangle = np.arange(50) % 2 == 0
    basis, d = facet_basis(mass, triangle, "dual"), mass.sum(2)
    regular = basis.delta == 0.0
    assert regular.sum() > 25
    product = basis.A @ mass
    expected = d[:, :, None] * np.eye(4)
    np.testing.assert_allclose(product[regular], expected[regular], atol=1e-10)
    np.testing.assert_allclose(product.sum(1), d, rtol=1e-9, atol=1e-12)  # the sum is 1
    np.testing.assert_allclose(product.sum(2), d, rtol=1e-9, atol=1e-12)  # and integrals are d


@pytest.mark.parametrize("corner", [0.05, 1e-3, 1e-6, 1e-9])
def test_slivers_within_one_triangle_of_a_quadrilateral(corner):
    """Two of the four functions coincide there: a regular basis all the same."""
    A, own = grid(1, 4)
    B, other = grid(1, 4, 0.0, True, 0.0, 1.0)
    mesh = mesh_of(4, own, other + 4, np.vstack((A, B + np.array([0, 1 - corner, 0]))))
    D, M = operators(mesh, mesh.X)
    assert D.sum() == pytest.approx(corner, rel=1e-5)
    np.testing.assert_allclose(np.asarray(M.sum(1)).ravel(), D, rtol=0, atol=1e-11 * D.max())
    assert np.isfinite(M.data).all()


def test_areas():
    X, facets = grid(5, 4)
    split = np.vstack((facets[:, [0, 1, 2, 2]], facets[:, [0, 2, 3, 3]]))
    assert areas(facets, X).sum() == pytest.approx(1.0, rel=1e-14)
    assert areas(split, X).sum() == pytest.approx(1.0, rel=1e-14)
    np.testing.assert_allclose(areas(np.array([[0, 1, 2, 2]]), np.eye(3)), np.sqrt(3) / 2)


@pytest.mark.parametrize("kind", [3, 4])
def test_derivative_of_full_areas(kind):
    mesh = two_grids(3, kind, 2, 4)
    x, rng, h = bent(mesh.X), np.random.default_rng(3), 1e-5
    way = rng.normal(size=x.shape)
    expected = (full_areas(mesh, x + h * way) - full_areas(mesh, x - h * way)) / (2 * h)
    found = full_areas_derivative(mesh, x).scipy() @ way.ravel()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


def test_blocks_of_facets_change_nothing(monkeypatch):
    """Derivatives are made for some facets at a time."""
    mesh = two_grids(4, 4, 5, 3, size=0.8)
    polygons = polygons_of(mesh, mesh.X)
    multiplier = np.random.default_rng(5).normal(size=(mesh.n_nonmortar, 3))
    expected = differentiate_polygons(mesh, mesh.X, polygons, multiplier)
    monkeypatch.setattr(polygon_operators, "ROOM", 5_000)
    found = differentiate_polygons(mesh, mesh.X, polygons, multiplier)
    for name in ("D", "jump", "force"):
        a, b = (getattr(d, name).scipy().toarray() for d in (expected, found))
        np.testing.assert_array_equal(a, b)
