"""Numbers, tables, lines and figures about errors, of a made-up run."""

import csv
from dataclasses import asdict, replace

import numpy as np
import pytest

from contactfem.case.settings import Adaptivity
from contactfem.output.figures.errors import draw_errors
from contactfem.output.figures.meshes import draw_meshes
from contactfem.output.report.adaptivity import error_table, remesh_table, uniform_table
from contactfem.output.terminal import remesh_lines, step_line
from contactfem.output.writer import OutputWriter
from contactfem.results.data import ErrorStep, MeshErrors, Observables, Remeshing
from contactfem.results.error_measures import errors_of_costs, errors_of_steps, uniform_costs


def errors(eta, cells, remeshes=(), repeats=0):
    return ErrorStep(
        eta, eta**2, None, None, 0.5 * eta, 0.25 * eta**2, cells, {}, tuple(remeshes), repeats, ()
    )


@pytest.fixture
def run(make_run):
    """Four steps: new meshes of both bodies in the first one, of one body in the third."""
    result = make_run(adaptivity=Adaptivity(tolerance=0.05))
    both = [
        Remeshing(0.0, "mechanics", "lower", 100, 400, "too large", 2.0, 0.08),
        Remeshing(0.0, "mechanics", "upper", 50, 70, "too large", 2.0, 0.08),
    ]
    one = [Remeshing(0.5, "mechanics", "upper", 70, 90, "too large", 1.0, 0.06)]
    found = [
        errors(0.04, {"lower": 400, "upper": 70}, both),
        errors(0.045, {"lower": 400, "upper": 70}, repeats=2),
        errors(0.035, {"lower": 400, "upper": 90}, one),
        errors(0.04, {"lower": 400, "upper": 90}),
    ]
    steps = [replace(s, errors=e, wall=3.0) for s, e in zip(result.steps, found, strict=True)]
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    cells = np.array([[0, 1, 2], [0, 2, 3]])
    mesh = MeshErrors(0.25, "mechanics", "lower", points, cells, np.array([1e-3, 1e-5]))
    return replace(result, steps=tuple(steps), first_meshes=(mesh,), last_meshes=(mesh, mesh))


def test_numbers(run):
    values = errors_of_steps(run.steps)
    assert values["error.mechanics.last"] == 0.04
    assert values["error.mechanics.max"] == 0.045
    assert values["error.time.max"] == 0.0225
    assert "error.heat.last" not in values
    assert (values["remeshes"], values["steps.repeated"]) == (2, 2)
    assert (values["cells.lower"], values["cells.upper"]) == (400, 90)
    costs = errors_of_costs({"estimate": 0.9, "remesh": 3.0}, run.steps)
    assert costs["cost.estimate_share"] == pytest.approx(0.1)  # of the 9 s without new meshes
    assert costs["cost.remesh_steps"] == pytest.approx(1.5 / (9.0 / 4))


def test_the_same_error_on_a_uniform_mesh(run):
    (cost,) = uniform_costs(run.steps)
    assert (cost.first_eta, cost.first_cells, cost.cells) == (0.08, 150, 490)
    assert cost.uniform_cells == pytest.approx(150 * 4.0, rel=0.01)


def test_tables(run):
    summary = {
        "steps": [asdict(step) for step in run.steps],
        "uniform": [asdict(cost) for cost in uniform_costs(run.steps)],
    }
    assert error_table(summary).row_count == 2
    assert remesh_table(summary).row_count == 3
    assert uniform_table(summary).row_count == 1
    assert error_table({"steps": []}).row_count == 0


def test_lines(run):
    first, second, *_ = run.steps
    assert "errors: mechanics 4 %, time 2 %" in step_line(first)
    assert "taken 3 times" in step_line(second)
    assert remesh_lines(first) == [
        "new meshes for mechanics in 2 s: lower 100 to 400 cells, upper 50 to 70 cells (too large)"
    ]
    assert remesh_lines(second) == []


def test_what_new_meshes_change_is_said(run):
    first, *_ = run.steps
    before = Observables({"sole": (1000.0, -5000.0)}, 80.0, 12.0)
    change = Observables({"sole": (1020.0, -5000.0)}, 79.5, 12.0).minus(before)
    assert change == Observables({"sole": (20.0, 0.0)}, -0.5, 0.0)
    changed = replace(first, errors=replace(first.errors, change=change))
    assert remesh_lines(changed)[1:] == [
        "they change sole (0.02 N/mm, 0 N/m)  hottest -0.5 K  mean temperature 0 K"
    ]
    assert change.minus(replace(before, temperature_max=None)).temperature_max is None


def test_history_says_errors_and_cells(run, tmp_path):
    writer = OutputWriter(tmp_path, run.case, "")
    for step in run.steps:
        writer.step(step)
    with (tmp_path / "history.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["error.mechanics"] for row in rows] == ["0.04", "0.045", "0.035", "0.04"]
    assert [row["error.heat"] for row in rows] == [""] * 4
    assert rows[1]["error.time"] == "0.0225"
    assert [row["cells"] for row in rows] == ["470", "470", "490", "490"]
    assert [row["thermal_cells"] for row in rows] == ["0"] * 4


def test_figures(run, tmp_path):
    for path in (
        draw_errors(run, tmp_path / "errors.png"),
        draw_meshes(run, "mechanics", tmp_path / "meshes.png"),
    ):
        assert path.stat().st_size > 10_000
