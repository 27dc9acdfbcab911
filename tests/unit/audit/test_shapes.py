"""What is inside bodies and obstacles, and which cells are turned over."""

import numpy as np
import pytest

from contactfem.audit import shapes
from contactfem.audit.shapes import BodyShape, ObstacleShape


def grid(nx: int = 4, ny: int = 3, width: float = 2.0, height: float = 1.5) -> BodyShape:
    """A block of quadrilaterals with a corner at the origin."""
    x, y = np.meshgrid(np.linspace(0, width, nx + 1), np.linspace(0, height, ny + 1))
    points = np.column_stack((x.ravel(), y.ravel()))
    corner = (np.arange(ny)[:, None] * (nx + 1) + np.arange(nx)).ravel()
    cells = np.column_stack((corner, corner + 1, corner + nx + 1, corner + nx + 2))
    return BodyShape("block", points, points, cells, "quadrilateral")


def box(n: int = 2) -> BodyShape:
    """A unit cube of hexahedra."""
    t = np.linspace(0.0, 1.0, n + 1)
    z, y, x = np.meshgrid(t, t, t, indexing="ij")
    points = np.column_stack((x.ravel(), y.ravel(), z.ravel()))
    k = np.arange(n)
    first = (k[:, None, None] * (n + 1) ** 2 + k[:, None] * (n + 1) + k).ravel()
    steps = [a + b * (n + 1) + c * (n + 1) ** 2 for c in (0, 1) for b in (0, 1) for a in (0, 1)]
    return BodyShape("box", points, points, first[:, None] + np.array(steps), "hexahedron")


POINTS = np.array([(0.3, 0.2), (1.0, 0.7), (2.1, 0.5), (1.9, 1.4), (-0.1, 0.1), (1.0, 1.6)])
DEPTHS = np.array([0.2, 0.7, 0.0, 0.1, 0.0, 0.0])


@pytest.mark.parametrize("few", [0, 10**9])
def test_depth_is_the_distance_to_the_boundary(few: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shapes, "FEW", few)  # by cells and a tree, or by crossings
    np.testing.assert_allclose(grid().depth(POINTS), DEPTHS, atol=1e-14)


@pytest.mark.parametrize("few", [0, 10**9])
def test_depth_goes_with_the_body(few: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shapes, "FEW", few)
    c, s = np.cos(0.6), np.sin(0.6)
    turn = np.array(((c, -s), (s, c)))
    body = grid()
    moved = body.moved(1e3 + body.x @ turn.T)
    np.testing.assert_allclose(moved.depth(1e3 + POINTS @ turn.T), DEPTHS, atol=1e-11)


def test_depth_in_three_dimensions() -> None:
    points = np.array([(0.5, 0.5, 0.1), (0.5, 0.5, 1.1), (0.2, 0.4, 0.6)])
    np.testing.assert_allclose(box().depth(points), (0.1, 0.0, 0.2), atol=1e-14)


@pytest.mark.parametrize("body", [grid(), box()], ids=lambda body: body.name)
def test_no_cell_of_a_mesh_as_it_is_read_is_turned_over(body: BodyShape) -> None:
    assert len(body.turned_over()) == 0
    mirrored = body.x.copy()
    mirrored[:, 0] *= -1.0
    assert len(body.moved(mirrored).turned_over()) == len(body.cells)


def test_a_corner_that_is_pushed_through_its_cell_turns_it_over() -> None:
    body = grid()
    x = body.x.copy()
    x[0] = (0.45, 0.45)  # of a cell of 0.5: beyond its diagonal
    assert list(body.moved(x).turned_over()) == [0]


def test_depth_in_obstacles() -> None:
    points = np.array([(0.0, -0.3), (0.0, 0.2), (3.0, 0.0)])
    plane = ObstacleShape("floor", "plane", np.array(((7.0, 0.0), (0.0, 1.0))))
    disk = ObstacleShape("disk", "circle", np.zeros((1, 2)), 1.0)
    hollow = ObstacleShape("hollow", "circle", np.zeros((1, 2)), 1.0, inside=True)
    np.testing.assert_allclose(plane.depth(points), (0.3, 0.0, 0.0), atol=1e-15)
    np.testing.assert_allclose(disk.depth(points), (0.7, 0.8, 0.0), atol=1e-15)
    np.testing.assert_allclose(hollow.depth(points), (0.0, 0.0, 2.0), atol=1e-15)


def test_depth_behind_a_chain() -> None:
    # a groove that opens upwards, walked with its solid on the left
    groove = np.array([(1.0, 1.0), (1.0, 0.0), (-1.0, 0.0), (-1.0, 1.0)])
    chain = ObstacleShape("groove", "polyline", groove)
    points = np.array([(0.0, 0.5), (0.0, -0.2), (1.3, 0.5), (1.1, -0.1), (1.2, 1.4)])
    expected = (0.0, 0.2, 0.3, np.hypot(0.1, 0.1), 0.0)  # nothing is known beyond its ends
    np.testing.assert_allclose(chain.depth(points), expected, atol=1e-14)


def test_depth_behind_a_closed_chain() -> None:
    square = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)])
    chain = ObstacleShape("peg", "polyline", square, closed=True)
    points = np.array([(1.0, 1.9), (-0.1, 1.0), (0.05, 0.5), (-0.1, -0.1)])
    np.testing.assert_allclose(chain.depth(points), (0.1, 0.0, 0.05, 0.0), atol=1e-14)
