"""The compiled kernels alone, so that they can run with a compiler's checks on memory accesses.

A pair is a nonmortar facet (a, b) with its normals and a mortar facet (c, d); here nodes 0 to 3.
"""

import itertools

import numpy as np
import pytest
from scipy.optimize import brentq

from contactfem._kernels import ffi, lib

FACETS = np.array([[0, 1]]), np.array([[2, 3]])


def doubles(array):
    assert array.flags.c_contiguous
    return ffi.from_buffer("double[]", array)


def integers(array):
    assert array.flags.c_contiguous
    return ffi.from_buffer("int64_t[]", array)


def cut(x, normals, pairs=((0, 0),), facets=FACETS, differentiate=True, axisymmetric=False):
    """Call the kernel, into arrays that hold rubbish; count, range, integrals, distance, slopes."""
    pairs = np.array(pairs, np.int64).reshape(-1, 2)
    s = len(pairs)
    out = [np.full(shape, np.nan) for shape in ((s, 2), (s, 7), s, (s, 7, 12))]
    count = lib.cf_segments(
        doubles(x), doubles(normals), *(integers(f) for f in facets), axisymmetric, s,
        integers(pairs),
        *(doubles(a) for a in out[:3]), doubles(out[3]) if differentiate else ffi.NULL,
    )  # fmt: skip
    return count, *out


def find(x, normals, nonmortar, mortar, radius, capacity=10_000):
    pairs = np.full((capacity, 2), -7, np.int64)
    count = lib.cf_pairs(
        doubles(x), doubles(normals), len(nonmortar), integers(nonmortar), len(mortar),
        integers(mortar), radius, doubles(np.full(len(nonmortar), radius)), capacity,
        integers(pairs),
    )  # fmt: skip
    return count, pairs


def make_pair(rng, covered, turn=0.2, size=1.0):
    """A facet whose normals turn by about `turn`, and a mortar facet over an interval of it."""
    angle, x0 = rng.uniform(0, 2 * np.pi), size * rng.normal(size=2)
    edge = size * np.array((np.cos(angle), np.sin(angle)))
    ab = np.array((x0, x0 + edge))
    tilt = angle - np.pi / 2 + turn * rng.uniform(-1, 1, 2)
    normals = np.column_stack((np.cos(tilt), np.sin(tilt)))
    cd = []
    for xi in reversed(covered):  # the walks of the two bodies run against each other
        weights = np.array(((1 - xi) / 2, (1 + xi) / 2))
        cd.append(weights @ ab + size * rng.uniform(-0.05, 0.1) * weights @ normals)
    return np.vstack((ab, cd)), np.vstack((normals, np.zeros((2, 2))))


def rays(x, normals, xi):
    """Mortar coordinate and gap where the normals at facet coordinates xi meet the other line."""
    shape = np.column_stack(((1 - xi) / 2, (1 + xi) / 2))
    n = shape @ normals[:2]
    across = np.broadcast_to(x[2] - x[3], n.shape)
    system = np.stack((n, across), axis=2)
    s, zeta = np.linalg.solve(system, (x[2] - shape @ x[:2])[..., None])[..., 0].T
    return shape, zeta, s * np.linalg.norm(n, axis=1)


def quadrature(x, normals, points):
    """Interval and integrals of a pair by sampling, root finding and Gauss's rule."""
    grid = np.linspace(-1, 1, 398)
    ends = [-1.0, 1.0]
    for target in (0.0, 1.0):

        def beyond(xi, target=target):
            return rays(x, normals, np.array([xi]))[1][0] - target

        values = rays(x, normals, grid)[1] - target
        for k in np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0):
            ends.append(brentq(beyond, grid[k], grid[k + 1], xtol=1e-15, rtol=1e-15))
    ends = np.unique(ends)
    inside = rays(x, normals, (ends[:-1] + ends[1:]) / 2)[1]
    (piece,) = np.flatnonzero((inside > 0) & (inside < 1))
    lo, hi = ends[piece : piece + 2]
    gauss, weights = np.polynomial.legendre.leggauss(points)
    shape, zeta, gap = rays(x, normals, (lo + hi) / 2 + (hi - lo) / 2 * gauss)
    w = weights * (hi - lo) / 2 * np.linalg.norm(x[1] - x[0]) / 2
    N1, N2 = shape.T
    parts = (N1 * N1, N1 * N2, N2 * N2, N1 * zeta, N2 * zeta, N1 * gap, N2 * gap)
    return (lo, hi), np.array([w @ part for part in parts]), w @ abs(gap) / w.sum()


INTERVALS = {
    "inside": (-0.6, 0.5),
    "over the start": (-1.4, 0.3),
    "over the end": (-0.2, 1.3),
    "over both": (-1.2, 1.7),
    "short": (0.13, 0.35),
}


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("covered", INTERVALS.values(), ids=INTERVALS)
@pytest.mark.parametrize(("turn", "points"), [(0.0, 40), (0.3, 3)])
def test_integrals_against_quadrature(covered, turn, points, seed):
    """Where normals do not turn the three points are exact, else they are Gauss's three points."""
    x, normals = make_pair(np.random.default_rng(seed), covered, turn)
    if turn == 0.0:
        normals[0] = normals[1]
        assert normals[0] @ (x[1] - x[0]) == pytest.approx(0, abs=1e-15)
    count, found, integrals, distance, _ = cut(x, normals)
    interval, expected, mean = quadrature(x, normals, points)
    assert count == 1
    np.testing.assert_allclose(found[0], interval, rtol=0, atol=1e-12)
    np.testing.assert_allclose(integrals[0], expected, rtol=0, atol=1e-12 * abs(expected).max())
    assert distance[0] == pytest.approx(mean, rel=1e-10 if points == 3 else 0.1)


def test_error_of_the_quadrature():
    """With turning normals the integrands are not polynomials; the error vanishes fast."""
    errors = []
    for turn in (0.4, 0.2, 0.1):
        x = np.array([[1.0, 0], [0, 0], [-0.2, 0.1], [1.3, 0.15]])
        tilt = np.pi / 2 - turn / 2 * np.array((1, -1))
        normals = np.array((*zip(np.cos(tilt), np.sin(tilt), strict=True), (0, 0), (0, 0)))
        errors.append(abs(cut(x, normals)[2][0] - quadrature(x, normals, 40)[1]).max())
    assert errors[0] < 1e-6
    assert errors[0] / errors[1] > 2**3.5
    assert errors[1] / errors[2] > 2**3.5


@pytest.mark.parametrize("size", [1.0, 1e-3, 1e2])
@pytest.mark.parametrize("covered", INTERVALS.values(), ids=INTERVALS)
def test_derivatives(covered, size):
    """Every integral with respect to every one of the twelve inputs, by central differences."""
    rng = np.random.default_rng(5)
    for _ in range(5):
        x, normals = make_pair(rng, covered, 0.3, size)
        slopes = cut(x, normals)[4][0]
        inputs = [(x, 0), (x, 1), (normals, 0), (normals, 1), (x, 2), (x, 3)]
        for k, ((array, node), axis) in enumerate(itertools.product(inputs, (0, 1))):
            h = 1e-6 * (size if array is x else 1.0)
            start, sides = array[node, axis], []
            for step in (-h, h):
                array[node, axis] = start + step
                sides.append(cut(x, normals)[2][0])
            array[node, axis] = start
            difference = (sides[1] - sides[0]) / (2 * h)
            columns = slice(4, 8) if array is normals else [*range(4), *range(8, 12)]
            scale = abs(slopes[:, columns]).max(1)
            assert (abs(slopes[:, k] - difference) <= 1e-6 * scale).all()


def test_values_do_not_depend_on_derivatives():
    """The line search's residual and the tangent's are of the same segments, to the last bit."""
    rng = np.random.default_rng(2)
    for covered in INTERVALS.values():
        x, normals = make_pair(rng, covered)
        with_, without = cut(x, normals), cut(x, normals, differentiate=False)
        for a, b in zip(with_[:4], without[:4], strict=True):
            np.testing.assert_array_equal(a, b)


def test_frame():
    """A rotation by a right angle changes nothing, a shift by a thousand only round-off."""
    x, normals = make_pair(np.random.default_rng(1), (-0.4, 1.3))
    _, interval, integrals, _, slopes = cut(x, normals)
    quarter = np.array(((0.0, 1.0), (-1.0, 0.0)))
    turned = cut(x @ quarter, normals @ quarter)
    np.testing.assert_allclose(turned[1], interval, rtol=1e-14)
    np.testing.assert_allclose(turned[2], integrals, rtol=1e-13)
    shifted = cut(x + 1e3, normals)
    np.testing.assert_allclose(shifted[2], integrals, rtol=0, atol=1e-11)
    np.testing.assert_allclose(shifted[4], slopes, rtol=0, atol=1e-10)
    by_position = slopes[0][:, [0, 2, 8, 10]] + 1j * slopes[0][:, [1, 3, 9, 11]]
    np.testing.assert_allclose(by_position.sum(1), 0, atol=1e-14)  # no integral sees the origin


@pytest.mark.parametrize("offset", [0.0, 1e3])
def test_ends_that_no_normal_reaches(offset):
    """A rigid plane is one long facet; the normals of a curved side may all miss its far ends."""
    x = np.array([[0, 0], [0.02, 0.01], [20, -0.001], [-20, -0.001]]) + offset
    tilt = np.array((-1.58, -1.50))
    normals = np.vstack((np.column_stack((np.cos(tilt), np.sin(tilt))), np.zeros((2, 2))))
    count, interval, integrals, _, _ = cut(x, normals)
    assert count == 1
    np.testing.assert_array_equal(interval, [[-1, 1]])
    expected = quadrature(x - offset, normals, 3)[1]
    np.testing.assert_allclose(integrals[0], expected, rtol=0, atol=1e-9 * offset / 1e3 + 1e-15)


@pytest.mark.parametrize("covered", [(1.0, 1.5), (-2.0, -1.0), (1.2, 1.5), (0.4, 0.4), (0.5, -0.5)])
def test_nothing_covered(covered):
    """Beside the facet, only touching its end, of no extent, or with the body on the wrong side."""
    x, normals = make_pair(np.random.default_rng(3), covered, turn=0.0)
    count, interval, integrals, distance, slopes = cut(x, normals)
    assert count == 0
    for array in (interval, integrals, distance, slopes):
        assert not array.any()


@pytest.mark.parametrize("width", [1e-3, 1e-6, 1e-9, 1e-12])
def test_thin_covers(width):
    """Barely covered facets keep their relative accuracy, which the rim rule relies on."""
    x = np.array([[1.0, 0], [0, 0], [-0.5, 0.1], [width, 0.1]])  # over the last bit before b
    normals = np.array([[0.0, 1], [0, 1], [0, 0], [0, 0]])
    _, interval, integrals, distance, slopes = cut(x, normals)
    exact = width - width**2 / 2, width**2 / 2, width**2 / 2 - width**3 / 3
    assert 1.0 - interval[0, 0] == pytest.approx(2 * width, rel=1e-3)
    found = integrals[0]
    assert found[1] + found[2] == pytest.approx(exact[0], rel=1e-3)
    assert found[0] + found[1] == pytest.approx(exact[1], rel=1e-3)
    assert found[1] == pytest.approx(exact[2], rel=1e-3)
    assert found[6] == pytest.approx(0.1 * exact[0], rel=1e-3)
    assert distance[0] == pytest.approx(0.1, rel=1e-12)
    moved = slopes[0, :, 10]  # d to the right: ∫ N grows by the shape functions at its place
    np.testing.assert_allclose(moved[:3], [width**2, width, 1], rtol=3e-3)


@pytest.mark.parametrize("tilt", [0.0, 1e-17, 1e-16, -1e-16, 1e-15, 1e-13, 1e-11, 1e-6])
def test_facets_along_the_normals(tilt):
    """A wall that stands on a flat surface covers nothing or next to nothing, and never 0 / 0."""
    rng = np.random.default_rng(0)
    for k in range(300):
        angle = rng.uniform(0, 2 * np.pi)
        turn = np.array(((np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))))
        foot = np.array((rng.uniform(-0.1, 1.1), rng.uniform(0, 0.2)))
        top = foot + np.array((tilt, rng.choice((-1.0, 1.0))))
        x = np.array(((1, 0), (0, 0), foot, top)) @ turn * 10.0 ** rng.uniform(-6, 1)
        normals = np.array(((0, 1), (0, 1), (0, 0), (0, 0))) @ turn
        if k % 2:
            x += rng.normal(size=2)
        _, _, integrals, distance, slopes = cut(x, normals)
        length = np.linalg.norm(x[1] - x[0])
        assert np.isfinite(slopes).all() and np.isfinite(distance).all()
        np.testing.assert_array_less(abs(integrals[0, :5]), (2 * abs(tilt) + 1e-7) * length)


def test_degenerate_input_gives_finite_numbers():
    """Facets without length, normals without length or opposite to each other, no pairs at all."""
    x = np.array([[1.0, 0], [0, 0], [0, 0.1], [1, 0.1]])
    n = np.array([[0.0, 1], [0, 1], [0, 0], [0, 0]])
    for node, other in ((0, 1), (2, 3)):
        flat = x.copy()
        flat[node] = flat[other]
        assert cut(flat, n)[0] == 0
    for first in ((0.0, -1.0), (0.0, 0.0), (1.0, 0.0), (-1.0, 0.0)):
        normals = n.copy()
        normals[0] = first
        for array in cut(x, normals)[1:]:
            assert np.isfinite(array).all()
    for node in range(4):
        broken = x.copy()
        broken[node, 1] = np.nan
        assert cut(broken, n)[0] == 0
    assert cut(x, n, pairs=())[0] == 0


def swept_boxes(x, normals, facets, radius):
    corners = np.stack([x[facets] + r * normals[facets] for r in (-radius, radius)])
    return corners.min((0, 2)), corners.max((0, 2))


def expected_pairs(x, normals, nonmortar, mortar, radius):
    """All pairs, one by one: boxes that meet along the axes and across both normals, and edges
    that run against each other."""
    lo, hi = swept_boxes(x, normals, nonmortar, radius)
    low, high = x[mortar].min(1), x[mortar].max(1)
    meet = ((lo[:, None] <= high) & (low <= hi[:, None])).all(2)
    corners = np.stack([x[nonmortar] + r * normals[nonmortar] for r in (-radius, radius)])
    places = itertools.product((low, high), (low, high))
    box = np.stack([np.column_stack((a[:, 0], b[:, 1])) for a, b in places])
    for k in (0, 1):
        across = np.column_stack((-normals[nonmortar[:, k], 1], normals[nonmortar[:, k], 0]))
        own = np.einsum("rekc,ec->erk", corners, across)
        other = np.einsum("bfc,ec->efb", box, across)
        meet &= other.max(2, initial=-np.inf) >= own.min((1, 2))[:, None] - 1e-11
        meet &= other.min(2, initial=np.inf) <= own.max((1, 2))[:, None] + 1e-11
    edges = (x[f[:, 1]] - x[f[:, 0]] for f in (nonmortar, mortar))
    return np.argwhere(meet & (np.einsum("ei,fi->ef", *edges) < 0))


@pytest.mark.parametrize("n_mortar", [0, 1, 2, 3, 4, 5, 8, 9, 16, 17, 33, 64, 65, 250])
def test_pairs_against_all_pairs(n_mortar):
    """The tree must lose no pair at any number of facets, whatever the balance of its leaves."""
    rng = np.random.default_rng(n_mortar)
    for scale in (0.02, 0.2, 2.0):
        n_nonmortar = int(rng.integers(0, 60))
        starts = rng.uniform(-1, 1, (n_nonmortar + n_mortar, 2))
        if n_mortar % 2:
            starts[:, 1] = 0.5  # all in a row: the tree has to split along one axis only
        x = np.vstack((starts, starts + scale * rng.normal(size=starts.shape)))
        facets = np.column_stack((np.arange(len(starts)), np.arange(len(starts)) + len(starts)))
        nonmortar, mortar = np.split(facets, [n_nonmortar])
        normals = rng.normal(size=x.shape)
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        for radius in (1e-6, 0.05, 10.0):
            expected = expected_pairs(x, normals, nonmortar, mortar, radius)
            count, pairs = find(x, normals, nonmortar, mortar, radius, len(expected) + 3)
            assert count == len(expected)
            np.testing.assert_array_equal(pairs[:count], expected)
            assert (pairs[count:] == -7).all()


def test_pairs_beyond_the_capacity_are_counted_but_not_written():
    """The caller learns how much room is needed."""
    x = np.array([[1.0, 0], [0, 0], [0, 0.1], [1, 0.1]])
    normals = np.array([[0.0, 1]] * 4)
    mortar = np.repeat([[2, 3]], 5, axis=0)
    count, pairs = find(x, normals, np.array([[0, 1]]), mortar, 0.2, capacity=2)
    assert count == 5
    np.testing.assert_array_equal(pairs, [[0, 0], [0, 1]])
    assert find(x, normals, np.array([[0, 1]]), mortar, 0.2, capacity=0)[0] == 5


@pytest.mark.parametrize("radius", [0.0, -1.0, np.nan])
def test_bad_radius(radius):
    x, normals = make_pair(np.random.default_rng(0), (-1.0, 1.0))
    assert find(x, normals, *FACETS, radius)[0] == -1


def test_positions_that_are_not_numbers():
    """A diverged iterate must not bring the search down."""
    rng = np.random.default_rng(0)
    for share in (0.05, 0.5, 0.95, 1.0):
        for value in (np.nan, np.inf, -np.inf):
            x = rng.normal(size=(300, 2))
            x[rng.random(300) < share] = value
            chain = np.column_stack((np.arange(149), np.arange(1, 150)))
            count, _ = find(x, rng.normal(size=x.shape), chain, chain + 150, 0.1)
            assert 0 <= count <= 149**2
