"""What `contactfem report` prints and returns."""

import io
import json
import math
from pathlib import Path

import pytest
from rich.console import Console

from contactfem.errors import CaseError
from contactfem.output.report.report import allowed_text, report
from contactfem.output.tables import read_summary
from contactfem.output.writer import OutputWriter


@pytest.fixture
def finished(make_run, tmp_path):
    """Finish a run in a directory of its own."""

    def finish(name: str, **changes) -> Path:
        output = type("Output", (), {"fields": True, "figures": False, "times": ()})
        run = make_run(output=output, **changes)
        writer = OutputWriter(tmp_path / name, run.case, "contactfem run cm.toml")
        writer.finish(run)
        return tmp_path / name

    return finish


def printed(directories: list[Path]) -> tuple[int, str]:
    stream = io.StringIO()
    code = report(directories, Console(file=stream, width=200))
    return code, stream.getvalue()


def test_one_run_in_full(finished):
    code, text = printed([finished("good")])
    assert code == 0
    assert "Two half cylinders in partial slip" in text
    assert "contactfem run cm.toml" in text
    assert text.count(" met ") == 4
    assert "9.351351 MPa" in text
    assert "9.35135 ± 0.281 MPa" in text
    assert "5.0e-14" in text
    assert "  search" in text
    assert "133 %" in text


@pytest.mark.parametrize("title", ["[/]", "a [bold]b[/bold]", "x [nope"])
def test_markup_in_a_title_is_shown_as_it_is(finished, title):
    run = finished("m[red]", title=title)
    assert title in printed([run])[1]
    assert "m[red]" in printed([run])[1]
    assert "m[red]" in printed([run, run])[1]


def test_control_characters_of_a_title_do_not_reach_the_terminal(finished):
    assert "\x1b" not in printed([finished("c", title="a\x1b[31mb")])[1]


def test_a_miss_is_marked_and_returned(finished, expecting):
    bad = finished("bad", expect={"iterations.mean": expecting(max=2.0)})
    code, text = printed([bad])
    assert code == 1
    assert "missed" in text
    assert "<= 2" in text
    good = finished("good")
    code, text = printed([good, bad])
    assert code == 1
    assert "4 of 4" in text
    assert "0 of 1" in text
    assert printed([good, good])[0] == 0


def test_many_steps_are_cut_in_the_middle(finished):
    directory = finished("long")
    path = directory / "summary.json"
    summary = json.loads(path.read_text())
    summary["steps"] = [summary["steps"][0] | {"step": 1000 + k} for k in range(100)]
    path.write_text(json.dumps(summary))
    _, text = printed([directory])
    assert "1000" in text
    assert "1099" in text
    assert "1050" not in text
    assert "..." in text


def test_what_is_not_a_finished_run_is_said(tmp_path):
    with pytest.raises(CaseError, match="no such directory"):
        report([tmp_path / "nowhere"])
    with pytest.raises(CaseError, match="has not finished"):
        report([tmp_path])
    (tmp_path / "summary.json").write_text("{broken")
    with pytest.raises(CaseError, match="not a summary"):
        read_summary(tmp_path)
    (tmp_path / "summary.json").write_text('{"title": 1}')
    with pytest.raises(CaseError, match="no 'steps'"):
        read_summary(tmp_path)


@pytest.mark.parametrize(
    ("low", "high", "unit", "text"),
    [
        (None, 0.045, "", "<= 0.045"),
        (2e6, None, "Pa", ">= 2 MPa"),
        (9e6, 11e6, "Pa", "10 ± 1 MPa"),
        (-1e-3, -1e-3, "m", "-1 ± 0 mm"),
        (-math.inf, 1.0, "", "<= 1"),
        (1.0, math.inf, "", ">= 1"),
    ],
)
def test_bounds_read_well(low, high, unit, text):
    assert allowed_text(low, high, unit) == text
