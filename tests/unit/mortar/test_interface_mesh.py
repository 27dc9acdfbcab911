"""Normals and facet lengths of the nonmortar surface, and their derivatives."""

import numpy as np
import pytest

from contactfem.mortar.interface_mesh import InterfaceMesh, facet_lengths
from contactfem.mortar.normals import line_tangents, nodal_normals


def ring(n: int, radius: float = 2.0) -> InterfaceMesh:
    """Make a closed polygon with its body inside and no mortar side."""
    angle = 2 * np.pi * np.arange(n) / n
    X = radius * np.column_stack((np.cos(angle), np.sin(angle)))
    facets = np.column_stack((np.arange(n), (np.arange(n) + 1) % n))
    return InterfaceMesh(n, facets, np.empty((0, 2), np.int64), X, np.ones((n, 2), bool))


def slope(function, x, direction, h=1e-6):
    """Central difference along a direction of all positions."""
    return (function(x + h * direction) - function(x - h * direction)) / (2 * h)


def test_normals_are_unit_and_outward():
    """On a regular polygon the averaged normals are radial and sign and size cannot hide."""
    for n in (3, 4, 17):
        mesh = ring(n)
        field = nodal_normals(mesh, mesh.X)
        np.testing.assert_allclose(field.n, mesh.X / 2.0, atol=1e-15)
        np.testing.assert_allclose(
            line_tangents(field.n), np.column_stack((field.n[:, 1], -field.n[:, 0]))
        )


def test_normals_average_unit_normals_of_facets():
    """A long facet does not outweigh a short one; an end has the normal of its only facet."""
    X = np.array([[5.0, 0], [0, 0], [-1, 1], [9, 9]])
    facets = np.array([[0, 1], [1, 2]])
    mesh = InterfaceMesh(3, facets, np.empty((0, 2), np.int64), X, np.ones((4, 2), bool))
    r = np.sqrt(0.5)
    middle = np.array((r, 1 + r)) / np.hypot(r, 1 + r)
    np.testing.assert_allclose(nodal_normals(mesh, X).n, [[0, 1], middle, [r, r]], atol=1e-15)


def test_lengths_add_up_to_the_perimeter():
    mesh = ring(7)
    half, _ = facet_lengths(mesh, mesh.X)
    np.testing.assert_allclose(half, 4 * np.sin(np.pi / 7), rtol=1e-14)


@pytest.mark.parametrize("size", [1.0, 1e-3])
@pytest.mark.parametrize("held", [(), ((0, 0), (7, 0), (7, 1), (3, 1))])
def test_derivatives(chains, held, size):
    """Of normals and lengths, by central differences at a random configuration."""
    mesh, x = chains(seed=3, wave=0.2, noise=0.01, held=held)
    x = x * size
    rng = np.random.default_rng(0)
    normals, lengths = nodal_normals(mesh, x), facet_lengths(mesh, x)
    for _ in range(4):
        v = rng.normal(size=x.shape)
        by_normals = slope(lambda y: nodal_normals(mesh, y).n, x, v, 1e-6 * size)
        by_lengths = slope(lambda y: facet_lengths(mesh, y)[0], x, v, 1e-6 * size)
        for difference, exact in (
            (by_normals.ravel(), normals.derivative @ v.ravel()),
            (by_lengths, lengths[1].scipy() @ v.ravel()),
        ):
            np.testing.assert_allclose(exact, difference, rtol=0, atol=1e-7 * abs(exact).max())


def test_normals_do_not_see_frame_or_mortar_side(chains):
    """Derivatives vanish for a shift and for mortar nodes; a rotation turns the normals with it."""
    mesh, x = chains(seed=1)
    field = nodal_normals(mesh, x)
    shift = np.tile((0.3, -0.7), len(x))
    np.testing.assert_allclose(field.derivative @ shift, 0, atol=1e-13)
    assert abs(field.derivative[:, 2 * mesh.n_nonmortar :]).nnz == 0
    spin = np.column_stack((-x[:, 1], x[:, 0])).ravel()
    turned = np.column_stack((-field.n[:, 1], field.n[:, 0])).ravel()
    np.testing.assert_allclose(field.derivative @ spin, turned, atol=1e-12)


def test_symmetry_lines(chains):
    """A node on a symmetry line keeps the normal that the mirrored facet would give it."""
    mesh, x = chains(wave=0.2, held=((0, 0), (7, 0)))
    field = nodal_normals(mesh, x)
    np.testing.assert_array_equal(field.n[[0, 7]], [[0, 1], [0, 1]])
    assert abs(field.derivative[[0, 1, 14, 15]]).max() == 0
    free, _ = chains(wave=0.2)
    np.testing.assert_array_equal(field.n[1:7], nodal_normals(free, x).n[1:7])


def test_who_carries_a_multiplier(chains):
    """Not a node that is held altogether or in the direction in which contact would push it."""
    mesh, _ = chains(held=((0, 0), (0, 1), (2, 1), (4, 0), (7, 0)))
    has_multiplier = [False, True, False, True, True, True, True, True]
    np.testing.assert_array_equal(mesh.has_multiplier, has_multiplier)


def test_neighbours(chains):
    """Previous and next along the walk: an end has one, a ring has no end."""
    mesh, _ = chains(nonmortar=3)
    np.testing.assert_array_equal(mesh.neighbours, [[1, -1], [0, 2], [1, 3], [2, -1]])
    np.testing.assert_array_equal(ring(3).neighbours, [[2, 1], [0, 2], [1, 0]])


def test_neighbours_in_space():
    """Along the edges of facets of four nodes; a triangle has its last node twice."""
    X = np.zeros((5, 3))
    facets = np.array([[0, 1, 2, 3], [1, 4, 2, 2]])
    mesh = InterfaceMesh(5, facets, facets[:0], X, np.ones(X.shape, bool))
    assert mesh.dim == 3
    found = [set(row[row >= 0].tolist()) for row in mesh.neighbours]
    assert found == [{1, 3}, {0, 2, 4}, {1, 3, 4}, {0, 2}, {1, 2}]
