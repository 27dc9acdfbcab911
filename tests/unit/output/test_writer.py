"""Files of a run: whole, parsable, complete to the last digit that matters."""

import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest

from contactfem.output.writer import OutputWriter


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture
def quiet(make_run):
    """Make runs that draw no figures, which is what takes time."""

    def make(*arguments, **changes):
        output = type("Output", (), {"fields": True, "figures": False, "times": ()})
        return make_run(*arguments, output=output, **changes)

    return make


def test_history_can_be_followed_row_by_row(quiet, tmp_path):
    run = quiet()
    writer = OutputWriter(tmp_path / "a" / "run", run.case, "contactfem run x.toml")
    path = tmp_path / "a" / "run" / "history.csv"
    assert rows(path) == []
    for number, step in enumerate(run.steps):
        writer.step(step)
        assert len(rows(path)) == number + 1
    last = rows(path)[-1]
    assert last["step"] == "4"
    assert float(last["t [s]"]) == 1.0
    assert float(last["residual"]) == 5e-14
    assert (last["open"], last["stick"], last["slip"]) == ("20", "30", "11")
    assert float(last["sole.force_x [N/m]"]) == 936.22
    assert float(last["sole.force_y [N/m]"]) == -10e3
    assert float(last["sole.moment_defect"]) == 4e-4


def test_summary_says_it_all(quiet, tmp_path):
    run = quiet()
    writer = OutputWriter(tmp_path, run.case, "contactfem run x.toml")
    verdicts = writer.finish(run)
    assert all(verdict.passed for verdict in verdicts)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["passed"] is True
    assert summary["command"] == "contactfem run x.toml"
    assert summary["case"] == "cattaneo_mindlin.toml"
    assert summary["floor"] == pytest.approx(1.5)
    assert summary["newton_iterations"] == 19
    assert summary["steps"][2]["residuals"] == list(run.steps[2].residuals)
    assert summary["timings"]["total"] > 3.6
    assert summary["timings"]["output"] - 0.1 == pytest.approx(summary["timings"]["total"] - 3.6)
    assert summary["values"]["sole.force_x"] == 936.22
    assert summary["verdicts"][0]["key"] == "sole.pressure_max"
    assert "contactfem" in summary["versions"]
    assert len(rows(tmp_path / "interface_sole.csv")) == 61
    assert len(rows(tmp_path / "interface_sole_mortar.csv")) == 61
    assert not list(tmp_path.rglob("*.part*"))


def test_a_miss_and_a_stop_do_not_pass(quiet, tmp_path, changed, expecting):
    run = quiet(expect={"sole.contact_edge_min": expecting(max=-1.0)})
    OutputWriter(tmp_path, run.case, "").finish(run)
    assert json.loads((tmp_path / "summary.json").read_text())["passed"] is False
    stopped = changed(quiet(expect={}), converged=False, message="gave up", steps=())
    OutputWriter(tmp_path, stopped.case, "").finish(stopped)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert (summary["passed"], summary["message"]) == (False, "gave up")
    assert summary["values"]["iterations.mean"] is None  # NaN is no JSON


def test_a_stop_passes_if_it_is_what_was_expected(quiet, tmp_path, changed, expecting):
    run = quiet(expect={"converged": expecting(max=0.0)})
    stopped = changed(run, converged=False, message="no equilibrium")
    for result, passed in ((stopped, True), (run, False)):
        OutputWriter(tmp_path, run.case, "").finish(result)
        assert json.loads((tmp_path / "summary.json").read_text())["passed"] is passed


def test_times_before_the_end_get_their_own_files(quiet, tmp_path):
    run = quiet()
    writer = OutputWriter(tmp_path, run.case, "")
    writer.interfaces(run.interfaces, t=0.25)
    names = {path.name for path in tmp_path.glob("interface*")}
    assert names == {"interface_sole_t=0.25.csv", "interface_sole_mortar_t=0.25.csv"}


def test_an_obstacle_leaves_no_mortar_file(quiet, table, changed, tmp_path):
    rigid = changed(table, mortar_x=np.empty((0, 2)), mortar_pressure=np.empty(0))
    run = quiet(rigid)
    OutputWriter(tmp_path, run.case, "").interfaces(run.interfaces)
    assert [path.name for path in tmp_path.glob("interface*")] == ["interface_sole.csv"]


def test_a_second_run_leaves_nothing_of_the_first_and_spares_the_rest(quiet, tmp_path):
    run = quiet()
    writer = OutputWriter(tmp_path, run.case, "")
    writer.step(run.steps[0])
    writer.interfaces(run.interfaces, t=0.5)
    writer.finish(run)
    (tmp_path / "figures" / "old.png").write_text("x")
    (tmp_path / "notes.txt").write_text("mine")
    OutputWriter(tmp_path, run.case, "")
    left = {path.name for path in tmp_path.rglob("*") if path.is_file()}
    assert left == {"history.csv", "notes.txt"}
    assert rows(tmp_path / "history.csv") == []


def test_numbers_that_json_cannot_say_are_null(quiet, tmp_path, expecting):
    run = quiet(expect={"steps": expecting(min=1.0)})
    OutputWriter(tmp_path, run.case, "").finish(run)
    verdict = json.loads((tmp_path / "summary.json").read_text())["verdicts"][0]
    assert verdict["high"] is None
    assert not math.isnan(verdict["low"])
