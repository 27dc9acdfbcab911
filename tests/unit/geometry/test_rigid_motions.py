"""Rigid motions that conditions leave free."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contactfem.geometry.rigid_motions import free_rigid_modes, name_modes, rigid_modes

LEFT = np.array([[0.0, 0.0], [0.0, 1.0]])
BOTTOM = np.array([[0.0, 0.0], [2.0, 0.0]])
CENTER, SIZE = np.array([1.0, 0.5]), 2.0


def names(points, mask, *, rotation_held=False):
    prescribed = np.broadcast_to(np.array(mask, dtype=bool), points.shape)
    modes = free_rigid_modes(points, prescribed, CENTER, SIZE, rotation_held=rotation_held)
    return name_modes(modes, CENTER, SIZE)


@pytest.mark.parametrize(
    ("points", "mask", "free"),
    [
        (LEFT, [1, 1], []),
        (LEFT, [1, 0], ["y"]),
        (BOTTOM, [0, 1], ["x"]),
        (BOTTOM, [1, 0], ["y", "rotation"]),
        (LEFT[:1], [1, 1], ["rotation about (0, 0) m"]),
        (LEFT[1:], [1, 1], ["rotation about (0, 1) m"]),
        (np.empty((0, 2)), [1, 1], ["x", "y", "rotation"]),
        (BOTTOM, [0, 0], ["x", "y", "rotation"]),
    ],
)
def test_what_supports_leave_free(points, mask, free):
    assert names(points, mask) == free


def test_a_line_off_the_centre_leaves_a_rotation_about_itself():
    # u_x = 0 on y = 0: the rotation must be about a point of that line
    prescribed = np.array([[True, False], [True, False]])
    modes = free_rigid_modes(BOTTOM, prescribed, CENTER, SIZE)
    moved = rigid_modes(BOTTOM, CENTER, SIZE)[:, 0, :] @ modes.T
    assert moved == pytest.approx(np.zeros((2, 2)), abs=1e-14)


def test_a_grip_holds_the_rotation_only():
    assert names(np.empty((0, 2)), [0, 0], rotation_held=True) == ["x", "y"]
    assert names(BOTTOM, [1, 0], rotation_held=True) == ["y"]


def test_roller_and_corner_hold_a_body():
    points = np.array([[2.0, 0.0], [2.0, 1.0], [2.0, 0.0]])
    prescribed = np.array([[True, False], [True, False], [False, True]])
    assert len(free_rigid_modes(points, prescribed, CENTER, SIZE)) == 0


@given(
    st.lists(
        st.tuples(st.integers(0, 4), st.integers(0, 4), st.booleans(), st.booleans()), max_size=6
    ),
    st.floats(0.01, 1e3),
)
def test_free_motions_move_nothing_prescribed_and_are_all_there_are(rows, scale):
    points = scale * np.array([row[:2] for row in rows], dtype=float).reshape(-1, 2)
    prescribed = np.array([row[2:] for row in rows], dtype=bool).reshape(-1, 2)
    center, size = scale * np.array([2.0, 2.0]), 5.0 * scale
    modes = free_rigid_modes(points, prescribed, center, size)
    constraints = rigid_modes(points, center, size)[prescribed]
    assert np.abs(constraints @ modes.T).max(initial=0.0) < 1e-12
    rank = np.linalg.matrix_rank(constraints, tol=1e-9) if len(constraints) else 0
    assert len(modes) == 3 - rank
    assert modes @ modes.T == pytest.approx(np.eye(len(modes)), abs=1e-12)
    assert len(name_modes(modes, center, size)) == len(modes)


def test_rigid_motions_do_not_strain():
    rng = np.random.default_rng(1)
    for dim, count in ((2, 3), (3, 6)):
        points = rng.normal(size=(5, dim))
        modes = rigid_modes(points, rng.normal(size=dim), 3.0)
        assert modes.shape == (5, dim, count)
        edges = points[:, None] - points[None]
        moved = modes[:, None] - modes[None]
        assert np.einsum("abd,abdm->abm", edges, moved) == pytest.approx(0.0, abs=1e-14)
        assert np.linalg.matrix_rank(modes.reshape(-1, count)) == count


def test_3d_supports():
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    center = np.array([0.5, 0.5, 0.5])
    on_plane = np.broadcast_to([False, False, True], corners.shape)
    modes = free_rigid_modes(corners, on_plane, center, 1.0)
    assert name_modes(modes, center, 1.0) == ["x", "y", "1 rotation"]
    fixed = np.broadcast_to([True, True, True], corners.shape)
    assert len(free_rigid_modes(corners, fixed, center, 1.0)) == 0
    modes = free_rigid_modes(corners[:1], fixed[:1], center, 1.0)
    assert name_modes(modes, center, 1.0) == ["3 rotations"]
