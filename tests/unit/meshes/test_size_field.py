"""Size fields: linear inside, nearest outside, graded, and the number of cells they ask for."""

import numpy as np
import pytest

from contactfem.common.typing import Floats
from contactfem.errors import MeshError
from contactfem.meshes.block import Block
from contactfem.meshes.disk import Ring
from contactfem.meshes.size_field import SizeField, size_field

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
HALVES = np.array([[0, 1, 3], [0, 3, 2]])


def block(**more: object) -> Block:
    return Block(**{"width": 2.0, "height": 1.0, "nx": 13, "ny": 7} | more)


def linear(x: Floats) -> Floats:
    return 0.3 + 0.05 * x[:, 0] + 0.02 * x[:, 1]


@pytest.mark.parametrize(
    "table",
    [
        {"cell": "quadrilateral"},
        {"cell": "triangle", "pattern": "crossed"},
        {"grading": (1e3, 0.1)},
    ],
)
def test_linear_fields_are_exact(table: dict[str, object]) -> None:
    """On triangles and on halved quadrilaterals, at more points than are looked for at once."""
    data = block(**table).build()
    field = size_field(data, linear(data.points))
    x = np.random.default_rng(1).random((1200, 2)) * [2.0, 1.0]
    np.testing.assert_allclose(field.at(x), linear(x), rtol=1e-12)
    np.testing.assert_allclose(field.at(data.points), linear(data.points), rtol=1e-12)
    assert field.at(np.empty((0, 2))).shape == (0,)


def test_outside_it_is_the_size_at_the_nearest_point() -> None:
    data = block().build()
    field = size_field(data, linear(data.points))
    x = np.array([[0.77, -0.4], [2.5, 0.21], [3.0, 3.0], [-1.0, 0.4]])
    np.testing.assert_allclose(field.at(x), linear(np.clip(x, 0.0, [2.0, 1.0])), rtol=1e-12)
    hole = Ring(inner_radius=1.0, outer_radius=2.0, facets=40, layers=4).build()
    radius = np.hypot(*hole.points.T)
    inside = size_field(hole, radius).at(np.array([[0.3, 0.1], [0.0, -0.9]]))
    np.testing.assert_allclose(inside, radius.min(), rtol=1e-2)


def test_number_of_cells_is_the_integral() -> None:
    """Against ∫ 4 / (√3 h²) dA by halves of a fine array, and for nearly equal sizes."""
    sizes = np.array([0.3, 0.03, 0.2, 0.2])
    field = SizeField(SQUARE, HALVES, sizes)
    middle = (np.arange(1000) + 0.5) / 1000
    x, y = middle[:, None], middle[None]
    below = sizes[0] + (sizes[1] - sizes[0]) * x + (sizes[3] - sizes[1]) * y
    above = sizes[0] + (sizes[2] - sizes[0]) * y + (sizes[3] - sizes[2]) * x
    density = np.where(y < x, below, above) ** -2.0
    expected = 4 / np.sqrt(3) * density.mean()
    assert field.number_of_cells() == pytest.approx(expected, rel=1e-4)
    even = SizeField(SQUARE, HALVES, np.full(4, 0.01))
    assert even.number_of_cells() == pytest.approx(4e4 / np.sqrt(3), rel=1e-12)
    for change in (1e-9, 0.99e-6, 1.01e-6):  # on either side of where the quotient is taken
        near = SizeField(SQUARE, HALVES, 0.01 + change * np.array([0.0, 1.0, 1.0, 2.0]))
        exact = 4 / np.sqrt(3) * (0.01 + change) ** -2
        assert near.number_of_cells() == pytest.approx(exact, rel=3e-8)


def test_graded_sizes_rise_no_faster_and_are_the_largest() -> None:
    """From one small node they are the way along the edges; graded again they stay."""
    data = block(cell="triangle").build()
    sizes = np.full(len(data.points), 0.9)
    sizes[0] = 1e-3
    graded = size_field(data, sizes).graded(0.3)
    on_bottom = data.points[:, 1] == 0.0
    along = 1e-3 + 0.3 * data.points[on_bottom, 0]
    np.testing.assert_allclose(graded.sizes[on_bottom], along, rtol=1e-12)
    a, b = data.cells[:, [0, 1, 2]].ravel(), data.cells[:, [1, 2, 0]].ravel()
    steep = np.abs(graded.sizes[a] - graded.sizes[b]) / np.hypot(
        *(data.points[a] - data.points[b]).T
    )
    assert 0.3 * (1 - 1e-9) < steep.max() < 0.3 * (1 + 1e-9)
    assert np.array_equal(graded.graded(0.3).sizes, graded.sizes)
    gentle = size_field(data, linear(data.points))
    assert np.array_equal(gentle.graded(0.1).sizes, gentle.sizes)


def test_sizes_around_points() -> None:
    data = block(cell="triangle").build()
    field = size_field(data, np.full(len(data.points), 0.9))
    limited = field.limited(np.array([[1.0, 0.0], [1.0, 0.02]]), np.array([0.2, 0.1]), 0.3)
    node = np.argmin(np.hypot(*(data.points - [1.0, 0.0]).T))
    distance = np.hypot(*(data.points[node] - [1.0, 0.02]))
    assert limited.sizes[node] == pytest.approx(0.1 + 0.3 * distance, rel=1e-12)
    assert limited.sizes.min() == limited.sizes[node]


@pytest.mark.parametrize(
    ("points", "cells", "sizes", "words"),
    [
        (SQUARE, HALVES, np.ones(3), "3 sizes are given for 4 points"),
        (SQUARE, HALVES, np.array([1.0, 1.0, 0.0, 1.0]), "finite and positive"),
        (SQUARE, HALVES, np.array([1.0, 1.0, np.nan, 1.0]), "finite and positive"),
        (SQUARE, HALVES, np.array([1.0, 1.0, np.inf, 1.0]), "finite and positive"),
        (np.c_[SQUARE, np.ones(4)], HALVES, np.ones(4), "triangles of a plane mesh"),
        (SQUARE, np.array([[0, 1, 2, 3]]), np.ones(4), "triangles of a plane mesh"),
        (SQUARE, np.empty((0, 3), dtype=np.int64), np.ones(4), "triangles of a plane mesh"),
    ],
)
def test_unusable_fields(points: Floats, cells: Floats, sizes: Floats, words: str) -> None:
    with pytest.raises(MeshError, match=words):
        SizeField(points, cells.astype(np.int64), sizes)
