"""Nodal normals of surfaces in space."""

import numpy as np
import pytest
from spatial_surfaces import grid, neighbours

from contactfem.mortar.spatial_normals import averaged_normals


def normals_of(facets, x, free=None):
    free = np.ones(x.shape, bool) if free is None else free
    return averaged_normals(facets, x, free, neighbours(facets, len(x)))


def mixed(n):
    """A grid with every other cell split into triangles."""
    X, quads = grid(n, 4)
    split = np.arange(len(quads)) % 2 == 0
    halves = [quads[split][:, [0, 1, 2, 2]], quads[split][:, [0, 2, 3, 3]]]
    return X, np.vstack((quads[~split], *halves))


@pytest.mark.parametrize("kind", [3, 4])
def test_exact_on_a_sphere(kind):
    X, facets = grid(6, kind)
    inner = (abs(X[:, :2]) < 0.49).all(1)
    x = np.column_stack((X[:, :2], np.sqrt(1.0 - (X[:, :2] ** 2).sum(1))))
    n, _, _ = normals_of(facets, x)
    np.testing.assert_allclose(n[inner], x[inner], rtol=0, atol=1e-14)


def test_flat_surface():
    X, facets = mixed(4)
    n, _, length = normals_of(facets, X)
    np.testing.assert_allclose(n, np.broadcast_to([0.0, 0, 1], n.shape), atol=1e-15)
    assert (length > 0).all()


def test_derivative():
    X, facets = mixed(4)
    x = X + 0.3 * np.sin(2 * X[:, :1] + X[:, 1:2]) * (0, 0, 1)
    rng, h = np.random.default_rng(0), 1e-4
    free = rng.random(x.shape) > 0.2
    way = rng.normal(size=x.shape)
    _, slopes, _ = normals_of(facets, x, free)
    around = neighbours(facets, len(x))
    places = np.column_stack((np.arange(len(x)), np.maximum(around, 0)))
    found = np.einsum("jiwc,jwc->ji", slopes, way[places])
    f = [normals_of(facets, x + k * h * way, free)[0] for k in (-2, -1, 1, 2)]
    expected = (8 * (f[2] - f[1]) - f[3] + f[0]) / (12 * h)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * abs(expected).max())


def test_symmetry_plane():
    """A quarter of a sphere: at its edges the normals lie in the planes of symmetry."""
    X, facets = grid(5, 4, jitter=0.0)
    X[:, :2] += 0.5
    x = np.column_stack((X[:, :2] * 0.6, np.sqrt(1.0 - 0.36 * (X[:, :2] ** 2).sum(1))))
    free = np.ones(x.shape, bool)
    free[:, :2] = X[:, :2] > 1e-9
    n, _, _ = normals_of(facets, x, free)
    edge = ~free.all(1) & (X[:, :2] < 0.99).all(1)
    np.testing.assert_allclose(n[edge], x[edge], rtol=0, atol=1e-14)
