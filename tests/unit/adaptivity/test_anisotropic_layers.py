"""Rows of flat cells along surfaces: what they fill, how thick they are, and where they end."""

import numpy as np
import pytest
from pydantic import TypeAdapter

from contactfem.common.typing import Floats
from contactfem.meshes import Builder, MeshSpec
from contactfem.meshes.data import MeshData, jacobians
from contactfem.meshes.layers import GROWTH, RATIO, Layers
from contactfem.meshes.size_field import SizeField, size_field

BLOCK = {"builder": "block", "width": "2 m", "height": "1 m", "nx": 40, "ny": 20}
BLOCK |= {"cell": "triangle"}
RING = {"builder": "ring", "inner_radius": "2 m", "outer_radius": "3 m", "facets": 96, "layers": 16}
THIN = 1e-3


def spec(table: dict[str, object]) -> Builder:
    return TypeAdapter(MeshSpec).validate_python(table, context={"strict_units": True})


def layers(*groups: str, aspect: float = 20.0, longest: float = np.inf, rows: int = 0) -> Layers:
    return Layers(frozenset(groups), aspect, longest, rows)


def below(data: MeshData, growth: float) -> SizeField:
    """Thin at y = 1, thicker with the distance from there."""
    return size_field(data, THIN + growth * (1.0 - data.points[:, 1]))


def areas(data: MeshData) -> Floats:
    return 0.5 * jacobians(data.points, data.cells, "triangle").ravel()


def shape(data: MeshData) -> tuple[Floats, Floats]:
    """Longest edges of all cells, and the heights above them."""
    ring = data.points[np.roll(data.cells, -1, axis=1)] - data.points[data.cells]
    longest = np.linalg.norm(ring, axis=2).max(axis=1)
    return longest, 2.0 * areas(data) / longest


@pytest.fixture(scope="module")
def layered() -> MeshData:
    body = spec(BLOCK)
    return body.adapted(below(body.build(), 0.2), (), layers("top"))


def test_the_body_stays_what_it_is(layered: MeshData) -> None:
    plain = spec(BLOCK).build()
    assert areas(layered).sum() == pytest.approx(2.0, rel=1e-12)
    assert areas(layered).min() > 0.0
    assert set(layered.groups) == set(plain.groups)
    top = layered.points[np.unique(layered.groups["top"])]
    assert (top[:, 1] == 1.0).all()


def test_first_rows_are_as_thin_and_as_long_as_asked_for(layered: MeshData) -> None:
    """In the middle; towards the ends of the surface facets become as long as cells are thick."""
    x = np.sort(layered.points[layered.points[:, 1] == 1.0, 0])
    facet, middle = np.diff(x), 0.5 * (x[1:] + x[:-1])
    inner = np.abs(middle - 1.0) < 0.8
    np.testing.assert_allclose(facet[inner], 20.0 * THIN, rtol=0.05)
    assert facet[0] < 3.0 * THIN
    assert facet[-1] < 3.0 * THIN
    assert (np.diff(facet) < 1.5 * GROWTH * facet[1:] + THIN).all()
    y = 1.0 - layered.points[np.abs(layered.points[:, 0] - 1.0) < 0.3, 1]
    rows = np.unique(np.round(y[(y > 0.0) & (y < 3.0 * THIN)], 9))
    np.testing.assert_allclose(rows[:2], np.cumsum([THIN, THIN * 1.2]), rtol=0.02)


def test_flat_cells_are_few(layered: MeshData) -> None:
    """The same field with equilateral triangles needs more than five times as many."""
    body = spec(BLOCK)
    plain = body.adapted(below(body.build(), 0.2))
    assert 5 * len(layered.cells) < len(plain.cells)
    longest, height = shape(layered)
    assert (longest / height).max() < 1.2 * 20.0
    assert np.quantile(height, 0.02) == pytest.approx(THIN, rel=0.3)


def test_rows_follow_sizes_that_stay_small() -> None:
    """Where the field does not grow rows do not either, and the region behind has its sizes."""
    body = spec(BLOCK)
    data = body.build()
    wanted = np.where(data.points[:, 1] > 0.8 - 1e-9, 0.01, 0.1)
    found = body.adapted(size_field(data, wanted), (), layers("top", aspect=5.0))
    y = 1.0 - found.points[np.abs(found.points[:, 0] - 1.0) < 0.3, 1]
    rows = np.unique(np.round(y[y < 0.15], 9))
    assert np.diff(rows).max() < 0.0135
    assert len(found.cells) > 2.0 * 2.0 * 0.2 / (0.05 * 0.01)


def test_a_whole_circle_has_rows_without_an_end() -> None:
    body = spec(RING)
    data = body.build()
    away = np.hypot(*data.points.T) - 2.0
    found = body.adapted(size_field(data, 0.01 + 0.2 * away), (), layers("inner"))
    radius = np.hypot(*found.points.T)
    counts = [np.sum(np.abs(radius - 2.0018 - y) < 2e-3) for y in (0.0, 0.0104)]
    assert counts[0] == counts[1] == pytest.approx(2.0 * np.pi * 2.0 / 0.2, rel=0.1)


def test_regular_rows_without_flat_cells() -> None:
    """Three rows of squares, halved; all their nodes but those at the ends have six neighbours."""
    body = spec(BLOCK)
    data = body.build()
    field = size_field(data, np.full(len(data.points), 0.05))
    found = body.adapted(field, (), layers("top", aspect=1.0, rows=3))
    middle = np.abs(found.points[:, 0] - 1.0) < 0.7
    for row in (1, 2):
        nodes = np.flatnonzero(middle & (np.abs(found.points[:, 1] - 1.0 + 0.05 * row) < 1e-9))
        assert len(nodes) == pytest.approx(1.4 / 0.05, abs=2)
        assert (np.bincount(found.cells.ravel())[nodes] == 6).all()


def test_the_same_without_layers() -> None:
    body = spec(BLOCK)
    field = below(body.build(), 0.5)
    first = body.adapted(field)
    second = body.adapted(field, (), layers("elsewhere"))
    np.testing.assert_array_equal(first.points, second.points)
    np.testing.assert_array_equal(first.cells, second.cells)


def test_thickness_changes_step_by_step_along_the_surface() -> None:
    """From thin to thick within a facet: rows still do not turn over."""
    body = spec(BLOCK)
    data = body.build()
    jump = np.where(data.points[:, 0] < 1.0, THIN, 30.0 * THIN)
    field = size_field(data, jump + 0.2 * (1.0 - data.points[:, 1]))
    found = body.adapted(field, (), layers("top", longest=0.03))
    assert areas(found).min() > 0.0
    assert areas(found).sum() == pytest.approx(2.0, rel=1e-12)
    first = found.points[found.cells][:, :, 1].max(axis=1) > 1.0 - 1e-12
    x, height = found.points[found.cells][first].mean(axis=1)[:, 0], shape(found)[1][first]
    assert np.median(height[x < 0.9]) == pytest.approx(THIN, rel=0.2)
    assert np.median(height[x > 1.5]) > 5.0 * THIN


def test_rows_leave_room_for_those_of_the_other_side() -> None:
    """Twelve rows of a twentieth of a strip's width from both sides would not fit."""
    body = spec(BLOCK | {"height": "0.2 m", "ny": 8})
    data = body.build()
    field = size_field(data, np.full(len(data.points), 0.01))
    found = body.adapted(field, (), layers("top", "bottom", aspect=1.0, rows=12))
    assert areas(found).sum() == pytest.approx(0.4, rel=1e-12)
    assert areas(found).min() > 0.0
    middle = np.abs(found.points[:, 0] - 1.0) < 0.5
    y = np.unique(np.round(found.points[middle & (found.points[:, 1] < 0.055), 1], 9))
    np.testing.assert_allclose(y[:5], 0.01 * np.arange(5), atol=1e-9)


def test_rows_inside_a_circle_end_before_they_meet() -> None:
    body = spec({"builder": "disk", "radius": "1 m", "facets": 64, "layers": 12})
    data = body.build()
    field = size_field(data, np.full(len(data.points), 0.15))
    group = next(iter(data.groups))
    found = body.adapted(field, (), layers(group, aspect=1.0, rows=12))
    assert areas(found).min() > 0.0
    assert len(found.cells) > np.pi / (0.433 * 0.15**2)


def test_ratio_of_rows() -> None:
    """No row is more than a quarter thicker than the one before."""
    body = spec(BLOCK)
    found = body.adapted(below(body.build(), 1.0), (), layers("top"))
    y = np.sort(1.0 - found.points[np.abs(found.points[:, 0] - 1.0) < 0.02, 1])
    rows = np.unique(np.round(y[y < 0.05], 8))
    assert (np.diff(rows)[1:8] / np.diff(rows)[:7]).max() < RATIO * 1.01
