"""Adapted meshes: the exact boundary at the sizes of a field, with the builder's groups."""

from collections.abc import Callable
from itertools import pairwise
from math import pi
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter

from contactfem.common.typing import Floats
from contactfem.errors import MeshError
from contactfem.meshes import BUILDERS, Builder, MeshSpec
from contactfem.meshes.adapted_mesh import adapt
from contactfem.meshes.block import Block
from contactfem.meshes.curves import Curve, Edge, FairCircle
from contactfem.meshes.data import MeshData, boundary_facets, jacobians
from contactfem.meshes.size_field import SizeField, size_field

BLOCK = {"builder": "block", "width": "2 m", "height": "1 m", "nx": 10, "ny": 5}
WAVE = {"builder": "wave", "width": "2 m", "height": "1 m", "nx": 32, "ny": 8}
WAVE |= {"amplitude": "50 mm", "wavelength": "0.8 m", "crest": "0.1 m"}
ROLL = {"builder": "cylinder", "radius": "8 mm", "zone": "0.9 mm", "size": "0.2 mm", "growth": 0.2}
FINE = {"builder": "graded_block", "width": "100 mm", "height": "200 mm", "zone": ["0 mm", "9 mm"]}
FINE |= {"size": "2 mm", "growth": 0.2}
DISK = {"builder": "disk", "radius": "2 m", "center": ["1 m", "2 m"], "facets": 40, "layers": 4}
RING = {"builder": "ring", "inner_radius": "2 m", "outer_radius": "3 m", "facets": 36, "layers": 4}
BODIES: dict[str, dict[str, Any]] = {
    "block": BLOCK,
    "split": BLOCK | {"corner": ["-1 m", "2 m"], "split": ["-0.6 m", "0.6 m"]},
    "wave below": WAVE,
    "wave above": WAVE | {"side": "top", "corner": ["-1 m", "2 m"], "cell": "triangle"},
    "half roll": ROLL,
    "lower half roll": ROLL | {"side": "lower", "point": ["1 mm", "2 mm"]},
    "quarter roll": ROLL | {"part": "quarter"},
    "lower quarter roll": ROLL | {"part": "quarter", "side": "lower", "cell": "quadrilateral"},
    "fine corner": FINE | {"corner": ["1 mm", "-200 mm"], "zone": ["1 mm", "10 mm"]},
    "fine below": FINE | {"zone": ["20 mm", "40 mm"], "side": "bottom"},
    "die": {"builder": "die", "width": "1.2 m", "straight": "0.9 m", "radius": "0.75 m"}
    | {"n_side": 7, "n_arc": 24, "point": ["1 m", "2 m"]},
    "disk": DISK,
    "ring": RING | {"center": ["1 m", "2 m"]},
    "tire": {"builder": "tire", "point": ["1 m", "2 m"]},
}
SOLID = {"box", "extrusion", "graded_box", "revolution"}
BOX = {"builder": "box", "width": "2 m", "height": "1 m", "depth": "3 m", "nx": 3, "ny": 2, "nz": 4}


def spec(**table: Any) -> Builder:
    return TypeAdapter(MeshSpec).validate_python(table, context={"strict_units": True})


def extent(data: MeshData) -> float:
    return float(np.ptp(data.points, axis=0).max())


def uniform(data: MeshData, size: float) -> SizeField:
    """The same size everywhere, as a share of the body's extent."""
    return size_field(data, np.full(len(data.points), size * extent(data)))


def rising(data: MeshData, size: float, growth: float = 0.2) -> SizeField:
    """Fine at the lowest node, growing with the distance from it."""
    away = np.hypot(*(data.points - data.points[np.argmin(data.points[:, 1])]).T)
    return size_field(data, size * extent(data) + growth * away)


FIELDS: dict[str, Callable[[MeshData], SizeField]] = {
    "uniform": lambda data: uniform(data, 0.02),
    "rising": lambda data: rising(data, 0.003),
}


@pytest.fixture(scope="module")
def made() -> Callable[[str, str], tuple[Builder, SizeField, MeshData]]:
    known: dict[tuple[str, str], tuple[Builder, SizeField, MeshData]] = {}

    def make(name: str, kind: str) -> tuple[Builder, SizeField, MeshData]:
        if (name, kind) not in known:
            body = spec(**BODIES[name])
            field = FIELDS[kind](body.build())
            known[name, kind] = body, field, body.adapted(field)
        return known[name, kind]

    return make


def area(data: MeshData) -> float:
    share = 0.5 if data.cell_type == "triangle" else 1.0
    return share * float(jacobians(data.points, data.cells, data.cell_type).mean(axis=1).sum())


def lengths(points: Floats, ends: Any) -> Floats:
    return np.hypot(*(points[ends[:, 1]] - points[ends[:, 0]]).T)


def quality(data: MeshData) -> Floats:
    """Twice the inner over the outer radius of every triangle: 1 if equilateral, 0 if flat."""
    a, b, c = (lengths(data.points, data.cells[:, ends]) for ends in ([0, 1], [1, 2], [2, 0]))
    return (b + c - a) * (c + a - b) * (a + b - c) / (a * b * c)


def distance(x: Floats, curves: list[Curve]) -> Floats:
    """From points to the nearest of a few curves; these by 1000 chords between knots."""
    gap = np.full(len(x), np.inf)
    for curve in curves:
        knots = curve.knots()
        t = np.unique([np.linspace(a, b, 1001) for a, b in pairwise(knots)])
        on = curve.at(t)
        a, along = on[:-1], np.diff(on, axis=0)
        for k, point in enumerate(x):
            part = np.clip(np.sum((point - a) * along, axis=1) / np.sum(along**2, axis=1), 0, 1)
            gap[k] = min(gap[k], np.hypot(*(point - a - part[:, None] * along).T).min())
    return gap


def of_group(body: Builder, name: str) -> list[Curve]:
    return [curve for loop in body.curves() for curve in loop if name in curve.groups]


def test_every_plane_builder_is_tested() -> None:
    assert {table["builder"] for table in BODIES.values()} == set(BUILDERS) - SOLID


@pytest.mark.parametrize("name", BODIES)
def test_outline_lies_on_the_curves(name: str) -> None:
    """The same groups and ends; loops are closed, and walked with the body on their left."""
    body = spec(**BODIES[name])
    outline, size = body.outline(), float(np.ptp(body.extent(), axis=0).max())
    curves = [curve for loop in body.curves() for curve in loop]
    assert {group for curve in curves for group in curve.groups} == set(outline)
    for group, line in outline.items():
        own = of_group(body, group)
        if isinstance(own[0], FairCircle):  # a polygon that is as large as its circle
            t = np.linspace(0.0, 1.0, len(line))
            np.testing.assert_allclose(own[0].nodes(t), line, atol=1e-14 * size)
            continue
        assert distance(line, own).max() < 1e-8 * size
        ends = np.array([[curve.at(np.array([t]))[0] for t in (0.0, 1.0)] for curve in own])
        for end in line[[0, -1]]:
            assert np.hypot(*(ends.reshape(-1, 2) - end).T).min() < 1e-14 * size
    for k, loop in enumerate(body.curves()):
        x = np.concatenate([curve.at(curve.knots())[:-1] for curve in loop])
        dx, dy = (np.roll(x, -1, axis=0) - x).T
        inside = np.sum((x[:, 0] - x[0, 0]) * dy - (x[:, 1] - x[0, 1]) * dx)
        assert inside > 0 if k == 0 else inside < 0
        ends = np.array([curve.at(np.array([0.0, 1.0])) for curve in loop])
        np.testing.assert_allclose(ends[:, 1], np.roll(ends[:, 0], -1, axis=0), atol=1e-14 * size)


@pytest.mark.parametrize("kind", FIELDS)
@pytest.mark.parametrize("name", BODIES)
def test_groups_are_those_of_the_builder(name: str, kind: str, made: Any) -> None:
    """They cover the boundary, parts lie within their wholes, ends and corners stay."""
    body, _, data = made(name, kind)
    before = body.build()
    assert data.cell_type == "triangle"
    assert data.groups.keys() == before.groups.keys()
    boundary = {tuple(f) for f in boundary_facets(data.cells, "triangle").tolist()}
    facets = {group: {tuple(f) for f in fs.tolist()} for group, fs in data.groups.items()}
    parts = {group for group in facets if group.startswith(("contact", "top_"))}
    assert set().union(*facets.values()) == boundary
    assert sum(len(fs) for group, fs in facets.items() if group not in parts) == len(boundary)
    for part in parts:
        wholes = [group for group in facets if group not in parts]
        assert any(facets[part] <= facets[whole] for whole in wholes)
    if name not in ("disk", "ring"):
        for group in facets:
            old, new = before.surface(group).X, data.surface(group).X
            np.testing.assert_allclose(new[[0, -1]], old[[0, -1]], atol=1e-14 * extent(before))


@pytest.mark.parametrize("kind", FIELDS)
@pytest.mark.parametrize("name", [name for name in BODIES if name not in ("disk", "ring")])
def test_nodes_lie_on_the_curves(name: str, kind: str, made: Any) -> None:
    """Within the chords that stand for the curves, and on circles to the last digit."""
    body, _, data = made(name, kind)
    for group in data.groups:
        x = data.surface(group).X
        curves = of_group(body, group)
        assert distance(x, curves).max() < 1e-8 * extent(data)
        arcs = [edge for edge in curves if isinstance(edge, Edge) and edge.centre is not None]
        if len(arcs) == len(curves):
            radii = [np.hypot(*np.subtract(arc.start, arc.centre)) for arc in arcs]
            off = [
                np.abs(np.hypot(*(x - a.centre).T) - r) for a, r in zip(arcs, radii, strict=True)
            ]
            assert np.min(off, axis=0).max() < 4e-15 * (extent(data) + np.abs(x).max())


@pytest.mark.parametrize("kind", FIELDS)
@pytest.mark.parametrize("name", BODIES)
def test_sizes_and_quality(name: str, kind: str, made: Any) -> None:
    """Edges are as long as the field says, no triangle is flat, the number of cells is foreseen."""
    _, field, data = made(name, kind)
    assert quality(data).min() > 0.5
    ends = np.unique(
        np.sort(data.cells[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0
    )
    middle = data.points[ends].mean(axis=1)
    ratio = lengths(data.points, ends) / field.at(middle)
    assert 0.85 < np.median(ratio) < 1.1
    assert np.quantile(ratio, 0.95) < 1.4 and np.quantile(ratio, 0.05) > 0.5
    assert 0.97 < len(data.cells) / field.number_of_cells() < 1.3


@pytest.mark.parametrize("name", BODIES)
def test_facets_are_graded(name: str, made: Any) -> None:
    """They follow the field, and neighbours differ by little more than it grows between them."""
    _, field, data = made(name, "rising")
    facets = boundary_facets(data.cells, "triangle")
    length = lengths(data.points, facets)
    ratio = length / field.at(data.points[facets].mean(axis=1))
    assert 0.9 < np.median(ratio) < 1.1
    assert ratio.max() < 1.5
    for group in data.groups.values():
        chain = lengths(data.points, group)
        joined = group[1:, 0] == group[:-1, 1]
        assert np.max(np.abs(np.diff(np.log(chain)))[joined], initial=0.0) < np.log(2.5)


def exact_area(name: str) -> float:
    """By closed forms: circles, or a polygon and the segments of its arcs."""
    body: Any = spec(**BODIES[name])
    if name == "disk":
        return pi * body.radius**2
    if name == "ring":
        return pi * (body.outer_radius**2 - body.inner_radius**2)
    if "roll" in name:
        return pi * body.radius**2 / (4 if "quarter" in name else 2)
    edges = [edge for loop in body.curves() for edge in loop if isinstance(edge, Edge)]
    total = 0.0
    for edge in edges:
        (x, y), (dx, dy) = edge.start, np.subtract(edge.end, edge.start)
        total += (x * dy - y * dx) / 2
        if edge.centre is not None:
            r, angle = np.hypot(*np.subtract(edge.start, edge.centre)), edge.angle()
            total += r**2 * (angle - np.sin(angle)) / 2
    return total


@pytest.mark.parametrize("name", ["half roll", "lower quarter roll", "die", "tire", "ring"])
def test_area_is_exact_to_second_order(name: str) -> None:
    """Halved sizes leave a quarter of the error."""
    body, exact = spec(**BODIES[name]), exact_area(name)
    before = body.build()
    errors = [abs(area(body.adapted(uniform(before, h))) - exact) for h in (0.06, 0.03, 0.015)]
    assert errors[0] < 1e-2 * exact
    rates = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.all((rates > 1.6) & (rates < 2.4)), rates


def test_area_under_a_wave_is_exact_to_second_order() -> None:
    """The integral of the recess is a (L - λ/2π [sin 2π (x - crest)/λ]) over the width L."""
    body = spec(**WAVE)
    ends = np.sin(2 * pi * (np.array([0.0, 2.0]) - 0.1) / 0.8)
    exact = 2.0 - 0.05 * (2.0 - 0.8 / (2 * pi) * (ends[1] - ends[0]))
    before = body.build()
    errors = [abs(area(body.adapted(uniform(before, h))) - exact) for h in (0.04, 0.02, 0.01)]
    rates = np.log2(np.divide(errors[:-1], errors[1:]))
    assert errors[0] < 2e-3 * exact
    assert np.all((rates > 1.6) & (rates < 2.4)), rates


def test_straight_bodies_keep_their_area(made: Any) -> None:
    for name, exact in {
        "block": 2.0,
        "split": 2.0,
        "fine corner": 0.02,
        "fine below": 0.02,
    }.items():
        assert area(made(name, "rising")[2]) == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize("kind", FIELDS)
def test_touching_circles_are_as_large_as_they_are_said_to_be(kind: str, made: Any) -> None:
    """So that interference is right: also graded polygons, far better than nodes on the circle."""
    for name, group, radius in (("disk", "rim", 2.0), ("ring", "inner", 2.0)):
        _, _, data = made(name, kind)
        x = data.points[data.groups[group]] - [1.0, 2.0]
        (ax, ay), (bx, by) = x[:, 0].T, x[:, 1].T
        angle = np.abs(np.arctan2(ax * by - ay * bx, ax * bx + ay * by))
        assert angle.sum() == pytest.approx(2 * pi, rel=1e-12)
        enclosed = abs(np.sum(ax * by - ay * bx)) / 2
        on_circle = radius**2 * np.sum(angle - np.sin(angle)) / 2
        error = abs(enclosed - pi * radius**2)
        assert error < (1e-12 if kind == "uniform" else 0.05 * on_circle)
        for node in ([2, 0], [0, 2], [-2, 0], [0, -2]):
            assert np.hypot(*(x[:, 0] - node).T).min() < 2 * np.max(angle) ** 2
            assert (
                np.abs(x[:, 0] / np.hypot(*x[:, 0].T)[:, None] - np.divide(node, 2))
                .sum(axis=1)
                .min()
                < 1e-15
            )


@pytest.mark.parametrize("name", BODIES)
def test_sizes_a_thousand_times_smaller(name: str) -> None:
    """At one node of a coarse field, on the boundary; there cells are as small as asked for."""
    body = spec(**BODIES[name])
    before = body.build()
    sizes = np.full(len(before.points), extent(before) / 10)
    node = before.groups[next(iter(before.groups))][0, 0]
    sizes[node] *= 1e-3
    data = body.adapted(size_field(before, sizes))
    nearest = np.argmin(np.hypot(*(data.points - before.points[node]).T))
    around = np.any(data.cells == nearest, axis=1)
    sides = lengths(data.points, data.cells[around][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2))
    offset = np.hypot(*(data.points[nearest] - before.points[node]))
    assert np.median(sides) < 2.0 * (sizes[node] + 0.5 * offset)
    assert quality(data).min() > 0.3
    assert len(data.cells) < 2000


@pytest.mark.parametrize("name", BODIES)
def test_sizes_too_large_for_the_body(name: str) -> None:
    """Curves and short pieces keep their shape; no cell is flat for that."""
    body = spec(**BODIES[name])
    data = body.adapted(uniform(body.build(), 2.0))
    assert quality(data).min() > 0.3
    assert area(data) == pytest.approx(area(body.build()), rel=0.05)


def test_same_mesh_every_time() -> None:
    """Whatever gmsh has made in between."""
    body = spec(**BODIES["tire"])
    field = rising(body.build(), 0.003)
    first = body.adapted(field)
    spec(**DISK).adapted(uniform(spec(**DISK).build(), 0.1))
    second = body.adapted(field)
    assert np.array_equal(first.points, second.points)
    assert np.array_equal(first.cells, second.cells)
    assert all(np.array_equal(first.groups[name], second.groups[name]) for name in first.groups)


def test_kept_points_become_nodes() -> None:
    """Inside, on lines, on arcs, at corners, and once where they are asked for twice."""
    block = spec(**BLOCK)
    keep = [(0.7, 0.4), (1.234, 0.0), (2.0, 1.0), (1.234, 0.0), (0.001, 0.5)]
    data = block.adapted(uniform(block.build(), 0.05), keep)
    for point in [*keep[:4], (0.0, 0.5)]:
        assert np.sort(np.hypot(*(data.points - point).T))[0] < 1e-9
        assert np.sort(np.hypot(*(data.points - point).T))[1] > 0.02
    assert quality(data).min() > 0.3
    disk = spec(**DISK)
    rim = (1 + 2 * np.cos(1.0), 2 + 2 * np.sin(1.0))
    data = disk.adapted(uniform(disk.build(), 0.05), [(1.0, 2.0), rim])
    assert np.hypot(*(data.points - [1.0, 2.0]).T).min() < 1e-15
    x = data.points[np.argmin(np.hypot(*(data.points - rim).T))] - [1.0, 2.0]
    np.testing.assert_allclose(np.arctan2(x[1], x[0]), 1.0, rtol=1e-7)
    assert 2.0 < np.hypot(*x) < 2.003


def test_what_cannot_be_adapted() -> None:
    block, ring = spec(**BLOCK), spec(**RING | {"inner_radius": "2.99 m"})
    field = uniform(block.build(), 0.1)
    with pytest.raises(MeshError, match="only plane bodies"):
        spec(**BOX).adapted(field)
    with pytest.raises(MeshError, match=r"the point \(0.5, 2\) m to keep is not in the body"):
        block.adapted(field, [(0.5, 2.0)])
    with pytest.raises(MeshError, match=r"the sizes ask for .* cells; at most 5000000"):
        block.adapted(uniform(block.build(), 1e-5))
    with pytest.raises(MeshError, match=r"gmsh cannot mesh|cross each other|not on"):
        ring.adapted(uniform(ring.build(), 1.0))
    sides = [Edge((0.0, 0.0), (1.0, 0.0), ("a",)), Edge((1.0, 0.0), (0.0, 0.9), ("b",))]
    with pytest.raises(MeshError, match=r"gap of 0.9 m at \(0, 0.9\) m"):
        adapt((tuple(sides),), field, np.empty((0, 2)))


def test_small_bodies_are_meshed_like_large_ones() -> None:
    """No absolute tolerance counts: a body of 2 m, and one of 2 nm."""
    scale = 2.0**-30
    large, small = (
        Block(width=2.0 * factor, height=factor, nx=10, ny=5) for factor in (1.0, scale)
    )
    data = [body.adapted(uniform(body.build(), 0.05)) for body in (large, small)]
    assert np.array_equal(data[0].points * scale, data[1].points)
    assert np.array_equal(data[0].cells, data[1].cells)
