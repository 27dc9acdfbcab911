"""The kernels for facets in space alone, so that they can run with a compiler's checks."""

import itertools

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.spatial import ConvexHull
from spatial_surfaces import (
    facet,
    grid,
    mesh_of,
    one_over_three,
    operators_of,
    polygons_of,
    quadruple,
    two_grids,
)

from contactfem.mortar.polygon_operators import differentiate_polygons
from contactfem.mortar.polygons import MASS, find_facet_pairs, intersect

PAIRINGS = list(itertools.product((3, 4), (3, 4)))
SPLIT = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]


def triangles(points):
    """Corners of a facet's triangles, and their functions by those of the nodes."""
    if len(points) == 3:
        return [(points, np.eye(3))]
    five = np.vstack((points, points.mean(0)))
    T = np.vstack((np.eye(4), np.full(4, 0.25)))
    return [(five[corners], T[corners]) for corners in SPLIT]


def common_points(p, q):
    """Corners of what two triangles in a plane share: corners inside, and where edges cross."""
    found = []
    for a, b in ((p, q), (q, p)):
        local = np.linalg.solve(np.column_stack((b[1] - b[0], b[2] - b[0])), (a - b[0]).T).T
        K = np.column_stack((1 - local.sum(1), local))
        found += list(a[(K >= 0).all(1)])
    for i, j in itertools.product(range(3), repeat=2):
        along, across = p[(i + 1) % 3] - p[i], q[(j + 1) % 3] - q[j]
        s, t = np.linalg.solve(np.column_stack((along, -across)), q[j] - p[i])
        if 0 <= s <= 1 and 0 <= t <= 1:
            found.append(p[i] + s * along)
    return np.array(found)


def brute_force(own, other):
    """Integrals over what two facets share: corners by trying all, a product rule on their hull."""
    gauss, weights = np.polynomial.legendre.leggauss(5)
    r, t = (g.ravel() for g in np.meshgrid((1 + gauss) / 2, (1 + gauss) / 2))
    w = np.outer(weights, weights).ravel() / 4 * t  # a square onto a triangle
    bary = np.column_stack((1 - t, t * (1 - r), t * r))
    mass, mixed = np.zeros((len(own),) * 2), np.zeros((len(own), len(other)))
    for x, T in triangles(own):
        frame = np.linalg.qr(np.column_stack((x[1] - x[0], x[2] - x[0])))[0]
        p = (x - x[0]) @ frame
        for y, R in triangles(other):
            q = (y - x[0]) @ frame
            points = common_points(p, q)
            if len(points) < 3:
                continue
            hull = points[ConvexHull(points).vertices]
            for k in range(1, len(hull) - 1):
                corners = hull[[0, k, k + 1]]
                at = bary @ corners
                jacobian = abs(np.linalg.det(corners[1:] - corners[0]))
                N, K = (
                    np.column_stack((np.ones(len(at)), at))
                    @ np.linalg.inv(np.column_stack((np.ones(3), c)))
                    @ S
                    for c, S in ((p, T), (q, R))
                )
                mass += jacobian * N.T @ (w[:, None] * N)
                mixed += jacobian * N.T @ (w[:, None] * K)
    return mass, mixed


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("ka", "kb"), PAIRINGS)
def test_integrals_against_brute_force(ka, kb, seed):
    rng = np.random.default_rng(seed)
    own, other = facet(rng, ka, False, 0.0), facet(rng, kb, True, 0.1, (0.3, 0.2))
    mesh = mesh_of(ka, [quadruple(0, ka)], [quadruple(ka, kb)], np.vstack((own, other)))
    found = intersect(mesh, mesh.X, np.array([[0, 0]]))
    mass, mixed = brute_force(own, other)
    assert len(found.met) == 1
    np.testing.assert_allclose(found.integrals[0, MASS][:ka, :ka], mass, rtol=0, atol=1e-13)
    np.testing.assert_allclose(found.mixed[0, :ka, :kb], mixed, rtol=0, atol=1e-13)
    np.testing.assert_array_equal(found.mixed[0, ka:], 0.0)
    np.testing.assert_array_equal(found.mixed[0, :, kb:], 0.0)


@pytest.mark.parametrize(("ka", "kb"), PAIRINGS)
def test_integrals_where_the_mortar_facet_covers_all(ka, kb):
    """Closed form: all of the nonmortar facet, and a field that is linear on the mortar facet."""
    rng = np.random.default_rng(4)
    own = facet(rng, ka, False, 0.0)
    own[:, 2] = 0.0
    other = 8.0 * (facet(rng, kb, True, 0.0) - (0.4, 0.4, 0.0)) + (0.4, 0.4, 0.0)
    other[:, 2] = 0.3
    mesh = mesh_of(ka, [quadruple(0, ka)], [quadruple(ka, kb)], np.vstack((own, other)))
    found = intersect(mesh, mesh.X, np.array([[0, 0]]))
    mass, mixed = np.zeros((ka, ka)), np.zeros((ka, 3))
    for x, T in triangles(own):
        area = np.linalg.norm(np.cross(x[1] - x[0], x[2] - x[0])) / 2
        whole = area * (np.eye(3) + 1) / 12
        mass += T.T @ whole @ T
        mixed += T.T @ whole @ x
    np.testing.assert_allclose(found.integrals[0, MASS][:ka, :ka], mass, rtol=0, atol=1e-15)
    projected = found.mixed[0, :ka, :kb] @ other
    np.testing.assert_allclose(projected[:, :2], mixed[:, :2], rtol=0, atol=1e-14)


def quantities(mesh, x, multiplier):
    D, M = operators_of(mesh, polygons_of(mesh, x))
    jump = M @ x - np.asarray(M.sum(1)) * x[: mesh.n_nonmortar]
    return np.concatenate((D, jump.ravel(), (M.T @ multiplier).ravel()))


def slope_along(mesh, x, multiplier, way, h):
    f = [quantities(mesh, x + k * h * way, multiplier) for k in (-2, -1, 1, 2)]
    return (8 * (f[2] - f[1]) - f[3] + f[0]) / (12 * h)


def derivative(mesh, x, multiplier):
    d = differentiate_polygons(mesh, x, polygons_of(mesh, x), multiplier)
    return sp.vstack([part.scipy() for part in (d.D, d.jump, d.force)])


@pytest.mark.parametrize("size", [1.0, 1e-3, 1e2])
@pytest.mark.parametrize("basis", ["dual", "standard"])
@pytest.mark.parametrize(("ka", "kb"), PAIRINGS)
def test_derivatives(ka, kb, basis, size):
    """Of D, jumps and forces against differences of the fourth order."""
    rng = np.random.default_rng(6)
    for _ in range(4):
        mesh = one_over_three(rng, ka, kb, basis)
        x, multiplier, way = size * mesh.X, rng.normal(size=(ka, 3)), rng.normal(size=mesh.X.shape)
        expected = slope_along(mesh, x, multiplier, way, 1e-4 * size)
        found = derivative(mesh, x, multiplier) @ way.ravel()
        for part in np.split(np.arange(len(found)), (ka, 4 * ka)):
            error = abs(found[part] - expected[part]).max()
            assert error <= 1e-9 * max(abs(expected[part]).max(), 0.1 * size)


@pytest.mark.parametrize(("ka", "kb"), PAIRINGS)
def test_derivatives_of_surfaces(ka, kb):
    """As above on two bent surfaces, where whole facets and edges of mortar facets occur."""
    mesh = two_grids(3, ka, 4, kb, size=0.9)
    x = (
        mesh.X
        + 0.2 * mesh.X[:, :1] ** 2 * (0, 0, 1)
        + 0.1 * (mesh.X[:, :1] * mesh.X[:, 1:2]) * (0, 0, 1)
    )
    rng = np.random.default_rng(8)
    multiplier, way = rng.normal(size=(mesh.n_nonmortar, 3)), rng.normal(size=x.shape)
    expected = slope_along(mesh, x, multiplier, way, 1e-5)
    found = derivative(mesh, x, multiplier) @ way.ravel()
    assert abs(found - expected).max() <= 1e-9 * abs(expected).max()


@pytest.mark.parametrize("kind", [3, 4])
@pytest.mark.parametrize("shift", [0.0, 1e-16, 1e-13, 1e-12, 1e-10, 1e-8, 1e-5])
def test_coincident_meshes(kind, shift):
    """Facets over their own images, and shifted a little: no gap, overlap or noise in slopes."""
    X, facets = grid(4, kind)
    k = kind
    images = facets[:, ::-1] if k == 4 else facets[:, [2, 1, 0, 0]]
    other = X + np.array([shift, 0.6 * shift, 0.0])
    mesh = mesh_of(len(X), facets, images + len(X), np.vstack((X, other)))
    D, _ = operators_of(mesh, polygons_of(mesh, mesh.X, 1e-3))
    assert D.sum() == pytest.approx(1.0, abs=2 * shift + 1e-10 * (shift > 0) + 1e-14)
    if shift < 1e-11 / 4:
        assert len(polygons_of(mesh, mesh.X, 1e-3).met) == len(facets)
    inner = np.flatnonzero((abs(X[:, :2]) < 0.49).all(1))
    slopes = derivative(mesh, mesh.X, np.ones((len(X), 3)))
    way = np.zeros_like(mesh.X)
    way[inner] = np.random.default_rng(0).normal(size=(len(inner), 3))
    way[inner, 2] = 0.0
    # moving inner nodes within the plane leaves the covered area as it is
    total = (slopes @ way.ravel())[: len(X)].sum()
    assert abs(total) < 1e-14


@pytest.mark.parametrize("s", [1e-9, 1e-7, 1e-5, 1e-3])
def test_slopes_at_nearly_coincident_edges(s):
    """A band of width s between nearly parallel edges: round-off grows as 1e-16 / s at most."""
    own = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
    other = np.array([[0.2, 0.7, 0.1], [0.9, s, 0.1], [0.1, 1.3 * s, 0.1]])
    mesh = mesh_of(3, [quadruple(0, 3)], [quadruple(3, 3)], np.vstack((own, other)))
    slopes = derivative(mesh, mesh.X, np.ones((3, 3)))[:3].toarray().sum(0).reshape(-1, 3)
    # area of the mortar triangle within the nonmortar one: closed form by its corners
    b = other[[2, 1, 0], :2]
    expected = (
        np.array(
            [
                [b[(i + 1) % 3, 1] - b[(i + 2) % 3, 1], b[(i + 2) % 3, 0] - b[(i + 1) % 3, 0]]
                for i in range(3)
            ]
        )
        / 2
    )
    np.testing.assert_allclose(slopes[[5, 4, 3], :2], expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize(("ka", "kb"), PAIRINGS)
def test_the_nearest_of_several_facets_counts(ka, kb, reverse):
    """A second surface behind the first changes nothing, whichever is listed first."""
    A, own = grid(3, ka)
    near, facets = grid(4, kb, 0.05, True, 0.3, 0.8, 1)
    far, _ = grid(4, kb, 0.15, True, 0.3, 0.8, 1)
    one = mesh_of(len(A), own, facets + len(A), np.vstack((A, near)))
    layers = (far, near) if reverse else (near, far)
    both = np.vstack((facets + len(A), facets + len(A) + len(near)))
    two = mesh_of(len(A), own, both, np.vstack((A, *layers)))
    expected, found = (operators_of(m, polygons_of(m, m.X, 0.3)) for m in (one, two))
    np.testing.assert_allclose(found[0], expected[0], rtol=0, atol=1e-16)
    M = [np.asarray(M.sum(0)).ravel() for _, M in (expected, found)]
    offset = len(near) if reverse else 0
    seen = slice(len(A) + offset, len(A) + offset + len(near))
    np.testing.assert_allclose(M[1][seen], M[0][len(A) : len(A) + len(near)], rtol=0, atol=1e-16)


def test_surfaces_behind_beside_the_nearest_are_seen():
    """Where the near surface ends the far one counts: together they cover all."""
    A, own = grid(4, 4, jitter=0.0)
    near, facets = grid(2, 4, 0.05, True, 0.0, 0.5, jitter=0.0)
    near = near + np.array([0.25, 0.0, 0.0])
    far, _ = grid(2, 4, 0.1, True, 0.0, 2.0, jitter=0.0)
    mortar = np.vstack((facets, facets + len(near))) + len(A)
    mesh = mesh_of(len(A), own, mortar, np.vstack((A, near, far)))
    D, M = operators_of(mesh, polygons_of(mesh, mesh.X, 0.3))
    assert D.sum() == pytest.approx(1.0, rel=1e-14)
    on_near = M[:, len(A) : len(A) + len(near)].sum()
    assert on_near == pytest.approx(0.25, rel=1e-13)


@pytest.mark.parametrize(("ka", "kb"), PAIRINGS)
def test_search_against_all_pairs(ka, kb):
    mesh = two_grids(6, ka, 5, kb, height=0.1)
    x = mesh.X + 0.3 * np.sin(3 * mesh.X[:, :1]) * (0, 0, 1)
    radius = 0.05
    found = find_facet_pairs(mesh, x, np.arange(len(mesh.nonmortar)), radius)

    def box(f):
        return x[f].min(0), x[f].max(0)

    def vector(f):
        return np.cross(x[f[2]] - x[f[0]], x[f[3]] - x[f[1]])

    expected = [
        (e, f)
        for e, own in enumerate(mesh.nonmortar)
        for f, other in enumerate(mesh.mortar)
        if (box(own)[0] - radius <= box(other)[1]).all()
        and (box(other)[0] <= box(own)[1] + radius).all()
        and vector(own) @ vector(other) < 0
    ]
    np.testing.assert_array_equal(found, expected)


def test_search_needs_a_radius():
    mesh = two_grids(2, 4, 2, 4)
    with pytest.raises(ValueError, match="search radius 0 m: must be positive"):
        find_facet_pairs(mesh, mesh.X, np.arange(4), 0.0)


@pytest.mark.parametrize("mortar", [np.empty((0, 4), np.int64), np.array([[4, 5, 6, 7]])])
def test_nothing_to_see(mortar):
    """No mortar facet, or one that looks away."""
    X = np.vstack((grid(1, 4)[0], grid(1, 4, 0.1)[0]))
    own = grid(1, 4)[1]
    away = grid(1, 4)[1] + 4 if len(mortar) else mortar
    mesh = mesh_of(4, own, away, X)
    assert len(polygons_of(mesh, X).met) == 0
    np.testing.assert_array_equal(operators_of(mesh, polygons_of(mesh, X))[0], 0.0)
    d = differentiate_polygons(mesh, X, polygons_of(mesh, X), np.zeros((4, 3)))
    assert (d.D.height, d.jump.height, d.force.height) == (4, 12, 24)
    assert len(d.force.values) == 0


def test_degenerate_facets_have_no_part():
    """Facets without area on either side, and mortar facets seen from their edge."""
    X = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]], float)
    other = np.array([[0.5, 0, 0.1], [0.5, 1, 0.1], [0.5, 1, 0.2], [0.5, 0, 0.2]])
    thin = np.array([[0.0, 1, 0.1], [1, 1, 0.1], [2, 1, 0.1], [3, 1, 0.1]])
    x = np.vstack((X, other, thin))
    mesh = mesh_of(5, [[0, 1, 2, 3], [0, 1, 4, 4]], [[5, 6, 7, 8], [9, 10, 11, 12]], x)
    pairs = np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
    assert len(intersect(mesh, x, pairs).met) == 0
