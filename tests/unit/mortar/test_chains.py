"""Surfaces cut at corners: which facet a corner belongs to, and exact derivatives all the same."""

from dataclasses import replace

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.mortar.chains import corners, cut_at_corners
from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.mortar_operators import Weights, mortar_operators
from contactfem.mortar.search_range import SearchRange

BOX = np.array([[0, 0], [0.4, 0], [1, 0], [1, 0.7], [0.6, 0.7], [0, 0.7], [0, 0.3]], float)
TRACK = np.array([[1.3, -0.01], [0.7, -0.02], [0.2, -0.01], [-0.3, -0.02]])


def box(mortar=TRACK, points=BOX, **more):
    """The skin of a box, counter-clockwise, and a mortar side."""
    n, m = len(points), len(mortar)
    facets = np.column_stack((np.arange(n), (np.arange(n) + 1) % n))
    other = n + np.column_stack((np.arange(m - 1), np.arange(1, m)))
    X = np.vstack((points, mortar))
    return InterfaceMesh(n, facets, other, X, np.ones(X.shape, bool), **more)


def operators_of(mesh, x, reach=5.0):
    facets = np.arange(len(mesh.nonmortar))
    return mortar_operators(MPI.COMM_SELF, mesh, x, facets, SearchRange.within(reach, len(facets)))


def test_corners_turn_by_more_than_a_feature_angle():
    """Not the nodes on straight sides, nor those of a round polygon."""
    assert set(corners(box())[:, 0]) == {0, 2, 3, 5}
    for n, count in ((12, 0), (13, 0), (11, 11)):
        angle = 2 * np.pi * np.arange(n) / n
        ring = box(points=np.column_stack((np.cos(angle), np.sin(angle))))
        assert len(corners(ring)) == count


def test_a_corner_has_the_normal_of_the_facet_that_faces_the_mortar_side():
    """Those at the sole; at the upper ones the mean stays, as at all nodes without a corner."""
    mesh = box()
    found = operators_of(mesh, mesh.X)
    r = np.sqrt(0.5)
    expected = [[0, -1], [0, -1], [0, -1], [r, r], [0, 1], [-r, r], [-1, 0]]
    np.testing.assert_allclose(found.normals.n, expected, atol=1e-14)
    np.testing.assert_allclose(found.D, [0.2, 0.5, 0.3, 0, 0, 0, 0], atol=1e-14)
    np.testing.assert_allclose(found.coverage[:3], 1.0, rtol=1e-14)
    np.testing.assert_allclose(found.M.sum(axis=1).A1, found.D, atol=1e-14)


def test_the_nearer_of_two_chains_keeps_its_corner():
    """A box near a wall and nearer to the floor, and the other way round."""
    wall = np.array([[1.1, 1.5], [1.1, -0.01], [-0.5, -0.01]])
    for shift, normal in ((0.0, (0, -1)), (0.095, (1, 0))):
        points = BOX + np.array((shift, 0.0 if shift == 0.0 else 0.1))
        mesh = box(wall, points)
        np.testing.assert_allclose(operators_of(mesh, mesh.X).normals.n[2], normal, atol=1e-14)


def test_a_side_of_one_facet_is_cut_at_both_ends():
    """Between floor and ceiling all corners of a box of four facets leave their sides."""
    press = np.array([[-0.3, 0.71], [1.3, 0.71], [1.3, -0.01], [-0.3, -0.01]])
    mesh = box(press, BOX[[0, 2, 3, 5]])
    found = operators_of(mesh, mesh.X)
    np.testing.assert_allclose(found.normals.n, [[0, -1], [0, -1], [0, 1], [0, 1]], atol=1e-14)
    np.testing.assert_allclose(found.D, 0.5, rtol=1e-14)
    np.testing.assert_allclose(found.gap, 0.01, rtol=1e-12)


def test_a_corner_that_points_at_a_body_keeps_its_mean_normal():
    """Neither chain is nearer: it meets what is beyond it."""
    tip = np.array([[1.5, 0.3], [1.05, -0.05], [0.7, -0.5]])
    mesh = box(tip, BOX * (1.0, 10 / 7))
    x = mesh.X
    assert cut_at_corners(mesh, x, SearchRange.within(0.01, len(mesh.nonmortar))) is mesh


def test_a_held_corner_keeps_the_chain_that_can_move():
    """Held in y it cannot act on the floor."""
    wall = np.array([[1.1, 1.5], [1.1, -0.01], [-0.5, -0.01]])
    mesh = box(wall)
    mesh.free[2, 1] = False
    found = operators_of(mesh, mesh.X)
    np.testing.assert_allclose(found.normals.n[2], (1, 0), atol=1e-14)


@pytest.mark.parametrize("axisymmetric", [False, True])
@pytest.mark.parametrize("basis", ["dual", "standard"])
def test_derivatives(basis, axisymmetric):
    """Of D, gap, forces, jumps, normals and lengths by differences at a random state."""
    rng = np.random.default_rng(2)
    mesh = replace(box(), basis=basis, axisymmetric=axisymmetric, X=np.add(box().X, (1.0, 0.0)))
    x, n = mesh.X + 0.01 * rng.normal(size=mesh.X.shape), mesh.n_nonmortar
    now = operators_of(mesh, x)
    active, multiplier = now.D > 0.0, rng.normal(size=(n, 2))
    assert active[[0, 2]].all() and now.surface is not mesh
    weights = Weights(active, rng.normal(size=(n, 2)), rng.normal(size=(n, 2)),
                      rng.normal(size=(n, 2, 2)), multiplier)  # fmt: skip

    def values(y):
        o = operators_of(mesh, y)
        jump = o.M @ y - o.D[:, None] * y[:n]
        gap = np.where(active, o.gap, 0.0)[:, None]
        sums = weights.D * o.D[:, None] + weights.gap * gap
        sums = (sums + np.einsum("jki,ji->jk", weights.jump, jump)) * active[:, None]
        forces = -(o.M.T @ (multiplier * active[:, None]))
        return np.concatenate((forces.ravel(), sums.ravel(), o.D)), o.normals.n, o.full

    exact = now.derivative(weights).scipy()
    for _ in range(3):
        v = rng.normal(size=x.shape)
        ahead, behind = values(x + 1e-6 * v), values(x - 1e-6 * v)
        found = exact @ v.ravel(), now.normals.derivative @ v.ravel()
        found += (now.full_derivative.scipy() @ v.ravel(),)
        for one, a, b in zip(found, ahead, behind, strict=True):
            difference = (a - b).ravel() / 2e-6
            np.testing.assert_allclose(one, difference, rtol=0, atol=1e-7 * abs(one).max())
