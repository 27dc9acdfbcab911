"""Patch recovery: what it reproduces exactly, and where each polynomial comes from."""

import numpy as np
import pytest
from verification.p1_conduction import double_areas, jittered

from contactfem.adaptivity.recovery.patches import patches

SLOPES = np.array([[3.0, -1.0, 0.5, 2.0], [1.0, 4.0, -2.0, 0.3]])


def linear(x):
    """Four components that are linear in x."""
    return x @ SLOPES + [1.0, -2.0, 0.0, 5.0]


def quads(nx, ny, angle=0.0, jitter=0.0):
    """Quadrilaterals of the unit square, turned."""
    i, j = np.meshgrid(np.arange(nx + 1), np.arange(ny + 1))
    x = np.stack((i / nx, j / ny), -1).reshape(-1, 2)
    inside = ((x > 0) & (x < 1)).all(1)
    noise = np.random.default_rng(1).uniform(-1, 1, (inside.sum(), 2))
    x[inside] += jitter * noise / [nx, ny]
    c, s = np.cos(angle), np.sin(angle)
    first = (np.arange(nx) + (nx + 1) * np.arange(ny)[:, None]).ravel()
    return x @ [[c, s], [-s, c]], first[:, None] + [0, 1, nx + 1, nx + 2]


def meshes():
    plate = jittered((9, 7), jitter=0.25)
    stretched = jittered((12, 10), size=(1.0, 0.05))
    return {
        "triangles": (plate.points, plate.cells),
        "far away": (plate.points + 1e3, plate.cells),
        "tiny": (1e-6 * plate.points, plate.cells),
        "stretched": (stretched.points @ [[0.6, 0.8], [-0.8, 0.6]], stretched.cells),
        "quadrilaterals": quads(6, 5, jitter=0.2),
        "turned quadrilaterals": quads(6, 6, angle=np.pi / 4),
    }


@pytest.mark.parametrize("name", meshes())
def test_linear_fields_are_exact_at_all_vertices(name):
    points, cells = meshes()[name]
    found = patches(points, cells).fit(linear(points[cells].mean(1)))[:, 0]
    exact = linear(points)
    assert np.abs(found - exact).max() < 1e-12 * max(1.0, np.abs(exact).max())


@pytest.mark.parametrize("name", meshes())
def test_polynomials_are_exact_away_from_their_vertices_too(name):
    points, cells = meshes()[name]
    fits = patches(points, cells)
    rows = np.arange(len(points))
    x = points + 0.7 * fits.sizes[:, None] * [1.0, -0.4]
    found = np.einsum("kb,kbc->kc", fits.basis(rows, x), fits.fit(linear(points[cells].mean(1))))
    assert np.abs(found - linear(x)).max() < 1e-11 * max(1.0, np.abs(linear(x)).max())


def test_quadrilaterals_keep_the_product_term():
    points, cells = quads(8, 8)
    sample, exact = (x[:, :1] * x[:, 1:] for x in (points[cells].mean(1), points))
    assert np.abs(patches(points, cells).fit(sample)[:, 0] - exact).max() < 1e-12


def test_interior_vertices_use_their_own_cells():
    """Against a fit of one vertex by numpy; the compliance is that of its samples."""
    plate = jittered((9, 7))
    samples = np.random.default_rng(3).normal(size=(len(plate.cells), 2))
    fits = patches(plate.points, plate.cells)
    vertex = int(np.argmin(np.abs(plate.points - 0.5).sum(1)))
    cells = np.flatnonzero((plate.cells == vertex).any(1))
    offset = plate.points[plate.cells[cells]].mean(1) - plate.points[vertex]
    P = np.column_stack((np.ones(len(cells)), offset / fits.sizes[vertex]))
    expected = np.linalg.lstsq(P, samples[cells], rcond=None)[0]
    np.testing.assert_allclose(fits.fit(samples)[vertex], expected, atol=1e-12)
    np.testing.assert_allclose(fits.compliance[vertex], np.linalg.inv(P.T @ P), atol=1e-12)


def test_boundary_vertices_take_the_patches_of_their_neighbours():
    """Least squares over all of these patches, cells counting once in each."""
    plate = jittered((9, 7))
    samples = np.random.default_rng(3).normal(size=(len(plate.cells), 2))
    fits = patches(plate.points, plate.cells)
    edge = plate.at_edge(1, 0.0)
    vertex = int(edge[4])
    around = np.unique(plate.cells[(plate.cells == vertex).any(1)])
    inner = around[(plate.points[around] > 0).all(1) & (plate.points[around] < 1).all(1)]
    assert len(inner) >= 2
    cells = np.concatenate([np.flatnonzero((plate.cells == i).any(1)) for i in inner])
    offset = plate.points[plate.cells[cells]].mean(1) - plate.points[vertex]
    P = np.column_stack((np.ones(len(cells)), offset / fits.sizes[vertex]))
    expected = np.linalg.lstsq(P, samples[cells], rcond=None)[0]
    np.testing.assert_allclose(fits.fit(samples)[vertex], expected, atol=1e-12)
    compliance = len(inner) * np.linalg.inv(P.T @ P)
    np.testing.assert_allclose(fits.compliance[vertex], compliance, rtol=1e-10)


def test_chosen_vertices_do_not_depend_on_the_others():
    plate = jittered((12, 12))
    samples = np.random.default_rng(3).normal(size=(len(plate.cells), 2))
    whole = patches(plate.points, plate.cells)
    some = np.random.default_rng(4).permutation(len(plate.points))[:20]
    part = patches(plate.points, plate.cells, some)
    np.testing.assert_array_equal(part.vertices, some)
    np.testing.assert_allclose(part.fit(samples), whole.fit(samples)[some], atol=1e-12)
    np.testing.assert_allclose(part.compliance, whole.compliance[some], atol=1e-12)
    assert patches(plate.points, plate.cells, some[:0]).fit(samples).shape == (0, 3, 2)


@pytest.mark.parametrize("layer", [quads(5, 1), quads(1, 1)], ids=["strip", "one cell"])
def test_thin_bodies_keep_constants(layer):
    points, cells = layer
    found = patches(points, cells).fit(np.full((len(cells), 1), 7.0))
    np.testing.assert_allclose(found[:, 0], 7.0, atol=1e-12)


def test_a_grid_turned_by_45_degrees_is_not_singular():
    points, cells = quads(6, 6, angle=np.pi / 4)
    fits = patches(points, cells)
    assert np.abs(fits.compliance).max() < 100.0
    assert double_areas(points[cells[:, [0, 1, 3]]]).min() > 0.0
