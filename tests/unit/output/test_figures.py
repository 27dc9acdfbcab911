"""Figures: every one is drawn, and shows what its name says."""

from types import SimpleNamespace

import numpy as np
import pytest

from contactfem.geometry.cells import cell_edges, triangles
from contactfem.output.figures.all_figures import draw_all
from contactfem.output.figures.bodies import stress_of
from contactfem.output.figures.deformation import magnification


def size_of(path) -> tuple[int, int]:
    """Width and height from the header of a PNG file."""
    header = path.read_bytes()[:24]
    assert header[:8] == b"\x89PNG\r\n\x1a\n"
    return int.from_bytes(header[16:20]), int.from_bytes(header[20:24])


def test_all_figures_of_a_frictional_run(make_run, tmp_path):
    paths = draw_all(make_run(), tmp_path)
    names = {path.name for path in paths}
    assert names == {
        "interface_sole.png",
        "stress_yy.png",
        "stress_xy.png",
        "history.png",
        "convergence.png",
    }
    for path in paths:
        width, height = size_of(path)
        assert width > 600
        assert height > 300
    assert {path.name for path in tmp_path.iterdir()} == names


def test_only_what_there_is_to_show(make_run, tmp_path, changed):
    frictionless = {"sole": SimpleNamespace(mortar="lower.top", friction=None)}
    run = make_run(interfaces=frictionless, closed_form={})
    short = changed(run, steps=run.steps[:1], bodies=())
    names = {path.name for path in draw_all(short, tmp_path)}
    assert names == {"interface_sole.png", "convergence.png"}
    nothing = changed(run, steps=(), bodies=(), interfaces=())
    assert draw_all(nothing, tmp_path) == []


def test_interfaces_without_contact_can_be_drawn(make_run, table, tmp_path, changed):
    none = changed(
        table,
        status=np.zeros(61, dtype=np.int8),
        pressure=np.zeros(61),
        traction=np.zeros(61),
        X=table.X[:, ::-1].copy(),
        gap=np.zeros(61),
    )
    run = changed(make_run(none, closed_form={}), bodies=(), steps=())
    assert len(draw_all(run, tmp_path)) == 1


def test_cells_to_triangles_and_outline():
    square = np.array([[0, 1, 3, 4], [1, 2, 4, 5]])  # two quadrilaterals side by side
    area = 0.0
    points = np.array([[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]], dtype=float)
    for a, b, c in points[triangles(square)]:
        u, v = b - a, c - a
        area += 0.5 * (u[0] * v[1] - u[1] * v[0])
    assert area == 2.0
    edges, outline = cell_edges(square)
    assert len(edges) == 7
    assert len(outline) == 6
    assert [1, 4] not in outline.tolist()
    assert len(cell_edges(triangles(square))[0]) == 9


def test_stress_components(make_run):
    body = make_run().bodies[0]
    assert np.array_equal(stress_of(body, "xy"), body.fields["stress"][:, 3])
    assert stress_of(body, "von_mises").min() >= 0.0


@pytest.mark.parametrize(("factor", "expected"), [(1.0, 10.0), (1e-3, 1e4), (20.0, 1.0)])
def test_small_displacements_are_magnified_by_round_factors(make_run, changed, factor, expected):
    run = make_run()
    bodies = tuple(changed(b, displacement=0.5 * factor * b.displacement) for b in run.bodies)
    assert magnification(changed(run, bodies=bodies)) == pytest.approx(expected)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_gap_that_was_there_is_not_falsified(make_run, table, changed, sign):
    """With a curved side, magnified displacements would let the bodies overlap or part."""
    curve = sign * 100.0 * table.X[:, 0] ** 2
    run = make_run(changed(table, X=table.X + np.stack([0.0 * curve, curve], 1)))
    bodies = tuple(changed(b, displacement=1e-2 * b.displacement) for b in run.bodies)
    assert magnification(changed(run, bodies=bodies)) == 1.0


def test_a_plane_at_a_distance_is_not_magnified(make_run):
    def run_above(height):
        plane = SimpleNamespace(shape="plane", point=(0.0, -height), normal=(0.0, 1.0))
        side = SimpleNamespace(mortar="floor", friction=None)
        return make_run(obstacles={"floor": plane}, interfaces={"sole": side})

    assert magnification(run_above(0.0)) > 1.0
    assert magnification(run_above(1e-4)) == 1.0
