"""Dual mortar operators against an independent quadrature, their invariants and derivatives."""

import numpy as np
import pytest
from scipy.optimize import brentq

from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.normals import nodal_normals
from contactfem.mortar.operators import D_ENTRY, GAP_ENTRY, assemble
from contactfem.mortar.segments import cut, find_pairs

PRESCRIBED = ((0, 0), (0, 1), (3, 1))  # a Dirichlet end and a node inside, both without multiplier
CASES = {
    "over the end": {"nonmortar": 5, "mortar": 7},
    "finer nonmortar": {"nonmortar": 9, "mortar": 4, "span": (0.13, 0.88)},
    "one on many": {"nonmortar": 1, "mortar": 9},
    "many on one": {"nonmortar": 20, "mortar": 1, "span": (-0.2, 0.77)},
    "island": {"nonmortar": 3, "mortar": 1, "span": (0.4, 0.6)},
    "held": {"nonmortar": 6, "mortar": 6, "held": PRESCRIBED},
    "held, partly covered": {"nonmortar": 6, "mortar": 5, "span": (0.1, 0.7), "held": PRESCRIBED},
}


def entries(mesh, x, differentiate=False, chosen=slice(None), radius=0.4):
    facets = np.arange(len(mesh.nonmortar))[chosen]
    normals = nodal_normals(mesh, x)
    pairs = find_pairs(mesh, x, normals.n, facets, radius)
    return assemble(mesh, x, cut(mesh, x, normals.n, pairs, differentiate), normals)


def dense(mesh, found):
    """D (n,), M (n, n_nodes) and the weighted gap (n,) from the list of entries."""
    D, gap = np.zeros(mesh.n_nonmortar), np.zeros(mesh.n_nonmortar)
    M = np.zeros((mesh.n_nonmortar, mesh.n_nodes))
    for target, kind in ((D, D_ENTRY), (gap, GAP_ENTRY)):
        at = found.col == kind
        np.add.at(target, found.row[at], found.value[at])
    at = found.col >= 0
    np.add.at(M, (found.row[at], found.col[at]), found.value[at])
    return D, M, gap


def ray(points, normals, ends, xi):
    """Shape functions at xi, mortar coordinate of the ray's hit, and gap along the unit normal."""
    shape = np.column_stack(((1 - xi) / 2, (1 + xi) / 2))
    n = shape @ normals
    across = np.broadcast_to(ends[0] - ends[1], n.shape)
    start = ends[0] - shape @ points
    s, zeta = np.linalg.solve(np.stack((n, across), axis=2), start[..., None])[..., 0].T
    return shape, zeta, s * np.linalg.norm(n, axis=1)


def quadrature(mesh, x, points):
    """D, M and weighted gap of single-sheeted surfaces by sampling, root finding and Gauss's rule.

    The dual functions follow from their definition on the covered part of each facet,
    ∫ Φ_j N_k = δ_jk ∫ N_k, and are 1 beside a node without multiplier.
    """
    normals = nodal_normals(mesh, x).n
    gauss, weights = np.polynomial.legendre.leggauss(points)
    D, gap = np.zeros(mesh.n_nonmortar), np.zeros(mesh.n_nonmortar)
    M = np.zeros((mesh.n_nonmortar, mesh.n_nodes))
    for facet in mesh.nonmortar:
        half = np.linalg.norm(x[facet[1]] - x[facet[0]]) / 2
        w, N, zeta, g, where = [], [], [], [], []
        for other in mesh.mortar:
            for lo, hi in visible(x[facet], normals[facet], x[other]):
                xi = (lo + hi) / 2 + (hi - lo) / 2 * gauss
                shape, z, distance = ray(x[facet], normals[facet], x[other], xi)
                w.append(weights * (hi - lo) / 2 * half)
                N.append(shape)
                zeta.append(z)
                g.append(distance)
                where.append(np.tile(other, (points, 1)))
        if not w:
            continue
        w, N, zeta, g, where = map(np.concatenate, (w, N, zeta, g, where))
        mass, integral = N.T @ (w[:, None] * N), w @ N
        dual = np.linalg.solve(mass, np.diag(integral)).T @ N.T
        for k, j in enumerate(facet):
            if not mesh.has_multiplier[j]:
                continue
            phi, lone = dual[k], not mesh.has_multiplier[facet[1 - k]]
            if lone:
                phi = np.ones(len(w))
                M[j, facet[1 - k]] -= integral[1 - k]
            D[j] += integral[k]
            gap[j] += w @ ((N[:, k] if lone else 0.5 * (phi + N[:, k])) * g)
            np.add.at(M[j], where[:, 0], w * phi * (1 - zeta))
            np.add.at(M[j], where[:, 1], w * phi * zeta)
    return D, M, gap


def visible(points, normals, ends):
    """Parts of the facet whose rays hit a mortar facet that faces it."""
    if (points[1] - points[0]) @ (ends[1] - ends[0]) >= 0:
        return []
    grid = np.linspace(-1, 1, 148)
    places = [-1.0, 1.0]
    for target in (0.0, 1.0):

        def beyond(xi, target=target):
            return ray(points, normals, ends, np.array([xi]))[1][0] - target

        values = ray(points, normals, ends, grid)[1] - target
        for k in np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0):
            places.append(brentq(beyond, grid[k], grid[k + 1], xtol=1e-15, rtol=1e-15))
    places = np.unique(places)
    middle = ray(points, normals, ends, (places[:-1] + places[1:]) / 2)[1]
    return [(places[k], places[k + 1]) for k in np.flatnonzero((middle > 0) & (middle < 1))]


def flat(mesh, x):
    """Put the nonmortar surface on a line, where normals do not turn."""
    x[: mesh.n_nonmortar, 1] = 0.0
    return x


@pytest.mark.parametrize("name", CASES)
def test_flat_surface_against_quadrature(chains, name):
    """Constant normals: the kernel's rule is exact, so many Gauss points must give the same."""
    mesh, x = chains(seed=4, **CASES[name])
    x = flat(mesh, x)
    for found, expected in zip(dense(mesh, entries(mesh, x)), quadrature(mesh, x, 30), strict=True):
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", CASES)
def test_curved_surface_against_quadrature(chains, name):
    """Turning normals: the same with three points per segment, close to it with many."""
    mesh, x = chains(seed=4, wave=0.15, **CASES[name])
    found = dense(mesh, entries(mesh, x))
    for a, same, exact in zip(found, quadrature(mesh, x, 3), quadrature(mesh, x, 30), strict=True):
        np.testing.assert_allclose(a, same, rtol=0, atol=1e-11)
        np.testing.assert_allclose(a, exact, rtol=0, atol=1e-5 * abs(exact).max())


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("name", CASES)
def test_partition_of_unity(chains, name, seed):
    """Σ M_jl = D_jj, so forces balance and slip does not see the origin; D is never negative."""
    mesh, x = chains(seed=seed, wave=0.1, noise=0.01, **CASES[name])
    D, M, _ = dense(mesh, entries(mesh, x))
    np.testing.assert_allclose(M.sum(1), D, rtol=0, atol=1e-14)
    assert (D >= 0).all()
    assert (D[~mesh.has_multiplier] == 0).all()
    assert not M[~mesh.has_multiplier].any()


@pytest.mark.parametrize("name", CASES)
def test_linear_motion_is_reproduced(chains, name):
    """On surfaces that coincide biorthogonality gives M x = D x, covered wholly, partly or not."""
    mesh, x = chains(seed=2, **CASES[name])
    x = flat(mesh, x)
    x[mesh.n_nonmortar :, 1] = 0.0
    D, M, gap = dense(mesh, entries(mesh, x))
    np.testing.assert_allclose(M @ x, D[:, None] * x[: mesh.n_nonmortar], rtol=0, atol=1e-14)
    np.testing.assert_allclose(gap, 0, atol=1e-15)
    x[mesh.n_nonmortar :, 1] = 0.01
    D, _, gap = dense(mesh, entries(mesh, x))
    np.testing.assert_allclose(gap, 0.01 * D, rtol=0, atol=1e-15)


@pytest.mark.parametrize("cover", [1e-1, 1e-3, 1e-6])
def test_barely_covered_node(cover):
    """The first node of a facet of which a small part at the other end is covered: D ~ cover²."""
    X = np.array([[1.0, 0], [0, 0], [-0.5, 0], [cover, 0]])
    mesh = InterfaceMesh(2, np.array([[0, 1]]), np.array([[2, 3]]), X, np.ones((4, 2), bool))
    D, M, gap = dense(mesh, entries(mesh, X))
    np.testing.assert_allclose(D, [cover**2 / 2, cover - cover**2 / 2], rtol=1e-9)
    # Φ of the part itself reaches far beyond it: x of node 0 is extrapolated from the mortar side
    np.testing.assert_allclose((M @ X)[:, 0] / D, [1.0, 0.0], atol=1e-4)
    np.testing.assert_allclose(gap, 0, atol=1e-15)


def test_shift_and_rotation(chains):
    """A shift by a thousand lengths gives round-off only, a right angle next to nothing."""
    mesh, x = chains(seed=7, wave=0.1)
    here = dense(mesh, entries(mesh, x))
    quarter = np.array(((0.0, 1.0), (-1.0, 0.0)))
    for moved, tolerance in ((x + 1e3, 1e-11), (x @ quarter, 1e-14)):
        for a, b in zip(dense(mesh, entries(mesh, moved)), here, strict=True):
            np.testing.assert_allclose(a, b, rtol=0, atol=tolerance)


def test_ring_covers_itself_once():
    """A disk in a hole: D adds up to its perimeter, though the search reaches the far side."""
    X, facets, n = [], [], 0
    for count, radius, sense in ((24, 1.0, 1), (17, 1.02, -1)):
        angle = sense * 2 * np.pi * np.arange(count) / count
        X.append(radius * np.column_stack((np.cos(angle), np.sin(angle))))
        facets.append(n + np.column_stack((np.arange(count), (np.arange(count) + 1) % count)))
        n += count
    X = np.vstack(X)
    mesh = InterfaceMesh(24, *facets, X, np.ones(X.shape, bool))
    D, M, _ = dense(mesh, entries(mesh, X, radius=5.0))
    np.testing.assert_allclose(D, 2 * np.sin(np.pi / 24), rtol=1e-13)
    np.testing.assert_allclose(M.sum(1), D, rtol=1e-13)


def test_uncovered_facets_are_ignored(chains):
    """No entries, not even zeros, for nodes that face nothing; nor any where nothing is near."""
    mesh, x = chains(nonmortar=10, mortar=4, span=(0.5, 1.2), seed=1)
    found = entries(mesh, x, differentiate=True)
    left = x[: mesh.n_nonmortar, 0] < 0.38
    assert left.sum() >= 3
    assert not np.isin(found.row, np.flatnonzero(left)).any()
    x[mesh.n_nonmortar :, 1] += 100.0
    for differentiate in (False, True):
        assert len(entries(mesh, x, differentiate=differentiate).value) == 0


@pytest.mark.parametrize("differentiate", [False, True])
def test_facets_add_up(chains, differentiate):
    """Ranks assemble some facets each; together they give the whole."""
    mesh, x = chains(nonmortar=9, mortar=13, held=PRESCRIBED)
    whole = dense(mesh, entries(mesh, x, differentiate))
    parts = [dense(mesh, entries(mesh, x, differentiate, slice(k, None, 3))) for k in range(3)]
    for a, b in zip(whole, zip(*parts, strict=True), strict=True):
        np.testing.assert_allclose(sum(b), a, rtol=0, atol=1e-16)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", CASES)
def test_derivatives(chains, name, seed):
    """All entries with respect to all positions, normals included, by central differences."""
    mesh, x = chains(seed=seed, wave=0.1, **CASES[name])
    rng = np.random.default_rng(seed)
    found = entries(mesh, x, differentiate=True)
    np.testing.assert_array_equal(found.value, entries(mesh, x).value)
    for _ in range(3):
        v, h = rng.normal(size=x.shape), 1e-6
        ahead, behind = entries(mesh, x + h * v), entries(mesh, x - h * v)
        np.testing.assert_array_equal(ahead.col, behind.col)
        difference = (ahead.value - behind.value) / (2 * h)
        for of_gap in (False, True):  # they have other units, hence another scale
            at = (found.col == GAP_ENTRY) == of_gap
            exact = (found.derivative.scipy() @ v.ravel())[at]
            error = abs(exact - difference[at])
            assert error.max() <= 1e-7 * abs(exact).max()
