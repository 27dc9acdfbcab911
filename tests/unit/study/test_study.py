"""Studies: targets, tables and pictures of made-up runs, and small ones from end to end."""

import csv
import io
import json
import math
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from rich.console import Console

import contactfem.study.study
from contactfem.case.read import read_case
from contactfem.case.settings import Study as Table
from contactfem.cli.main import main
from contactfem.errors import CaseError
from contactfem.study.figure import draw_study
from contactfem.study.process import Outcome, command_of, run_member
from contactfem.study.runs import Curve, Member
from contactfem.study.study import Study, run_study, target_of
from contactfem.study.table import Target, csv_text, json_ready, rows_of, slopes_of

CASE = """
title = "A block pressed on a plane"
strain = "small"
time = { end = "1 s", step = "1 s" }
materials.soft = { youngs_modulus = "1000 N/mm^2", poisson_ratio = 0.3 }
bodies.block.material = "soft"
bodies.block.mesh = { builder = "block", width = "2 mm", height = "1 mm", nx = 4, ny = 2 }
obstacles.plane = { shape = "plane", point = ["0 mm", "0 mm"], normal = [0.0, 1.0] }
interfaces.sole = { nonmortar = "block.bottom", mortar = "plane" }
conditions = [
  { on = "block.top", displacement = ["0 um", "-5 um"] },
]
expect."sole.force_y" = { max = 0.0 }
"""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "block.toml"
    path.write_text(CASE)
    return path


def outcome(value: float, unknowns: int = 100, seconds: float = 1.0, message: str = "") -> Outcome:
    timings = {"total": seconds + 1.5, "import": 1.0, "jit": 0.5, "newton": seconds}
    return Outcome(message, {"x": value}, unknowns, 1, 3, timings, seconds + 2.0, 2e8)


def runs(curve: Curve, values: list[float]) -> list[tuple[Member, Outcome, str]]:
    """Runs of order 2 in unknowns^-1/2 that take seconds as unknowns^1.5."""
    return [
        (Member(curve, k, 2.0**k), outcome(value, 100 * 4**k, 0.1 * 8**k), f"command {k}")
        for k, value in enumerate(values)
    ]


FIRST, SECOND = Curve("dual", None, ()), Curve("standard", "standard", (), 2)
ERRORS = runs(FIRST, [0.16, 0.04, 0.01]) + runs(SECOND, [0.32, 0.16, 0.08])


def test_errors_orders_and_slopes() -> None:
    rows = rows_of(Target("x", True), ERRORS)
    assert [row.error for row in rows] == [0.16, 0.04, 0.01, 0.32, 0.16, 0.08]
    assert [row.order for row in rows] == pytest.approx(
        [math.nan, 2, 2, math.nan, 1, 1], nan_ok=True
    )
    slopes = slopes_of(rows[:3])
    assert vars(slopes) == pytest.approx({"order": 2.0, "unknowns": -1.0, "seconds": -2 / 3})


def test_seconds_are_without_imports_and_compilation() -> None:
    assert outcome(0.0, seconds=0.7).seconds == pytest.approx(0.7)
    assert math.isnan(Outcome("no").seconds)


def test_a_quantity_is_compared_with_its_reference() -> None:
    rows = rows_of(Target("x", False, 0.02), runs(FIRST, [0.022, 0.021]))
    assert [row.error for row in rows] == pytest.approx([0.1, 0.05])
    assert rows[0].value == 0.022


def test_a_quantity_is_compared_with_the_finest_run_of_the_first_curve() -> None:
    some = runs(FIRST, [5.0, 4.5, 4.0]) + runs(SECOND, [6.0, 4.0 + 1e-12, 3.0])
    rows = rows_of(Target("x", False), some)
    assert [row.error for row in rows] == pytest.approx(
        [0.25, 0.125, math.nan, 0.5, math.nan, 0.25], nan_ok=True
    )
    assert math.isnan(rows[4].order)


def test_without_the_finest_run_there_is_no_reference() -> None:
    some = runs(FIRST, [5.0, 4.5])
    some[1] = (some[1][0], Outcome("gave up"), "")
    assert all(math.isnan(row.error) for row in rows_of(Target("x", False), some))


def test_a_run_that_gave_up_has_no_error() -> None:
    some = runs(FIRST, [0.4, 0.2, 0.1])
    some[1] = (some[1][0], replace(some[1][1], message="no equilibrium"), "")
    rows = rows_of(Target("x", True), some)
    assert [row.error for row in rows] == pytest.approx([0.4, math.nan, 0.1], nan_ok=True)
    assert rows[2].order == pytest.approx(1.0)


def test_tables() -> None:
    some = [*ERRORS[:2], (ERRORS[2][0], Outcome("no,\nat all"), "command")]
    rows = rows_of(Target("x", True), some)
    table = list(csv.DictReader(io.StringIO(csv_text(rows))))
    assert [row["level"] for row in table] == ["0", "1", "2"]
    assert float(table[1]["error"]) == 0.04 and float(table[1]["order"]) == pytest.approx(2.0)
    assert float(table[1]["seconds [s]"]) == pytest.approx(0.8)
    assert float(table[1]["newton [s]"]) == pytest.approx(0.8)
    assert table[2]["message"] == "no,\nat all" and table[2]["error"] == "nan"
    found = json.loads(
        json.dumps(json_ready(Target("x", True), rows, {"case": "c"}), allow_nan=False)
    )
    assert found["case"] == "c" and found["error"] == "x" and found["reference"] is None
    assert found["runs"][1]["command"] == "command 1"
    assert found["runs"][1]["error"] == 0.04
    assert found["runs"][2]["error"] is None
    assert found["slopes"]["dual"]["unknowns"] == pytest.approx(-1.0)


def test_picture(tmp_path: Path) -> None:
    rows = rows_of(Target("x", True), ERRORS)
    picture = draw_study(tmp_path / "a.png", "title", Target("x", True), rows)
    assert picture is not None and picture.read_bytes()[:4] == b"\x89PNG"
    assert picture.stat().st_size > 10_000
    same = [(member, replace(out, unknowns=7), words) for member, out, words in ERRORS]
    assert draw_study(picture, "title", Target("x", True), rows_of(Target("x", True), same))
    nothing = rows_of(Target("y", True), ERRORS)
    assert draw_study(tmp_path / "b.png", "title", Target("y", True), nothing) is None
    assert not (tmp_path / "b.png").exists()


def test_targets(path: Path) -> None:
    case = read_case(path)
    assert target_of(case, Table(quantity="sole.force_y", reference=-2.0)) == Target(
        "sole.force_y", False, -2.0
    )
    with pytest.raises(CaseError, match=r"errors: none, as no interface has a closed_form"):
        target_of(case, None)
    with pytest.raises(CaseError, match=r"(?s)expects: sole\.force_y\n.*of sole: pressure_max,"):
        target_of(case, None)
    with pytest.raises(CaseError, match=r"study: nothing measures 'sole.forcey'; did you mean"):
        target_of(case, Table(quantity="sole.forcey"))
    said = read_case(path, ['study={quantity = "sole.force_y", reference = "2 N/mm"}'])
    assert target_of(said, None).reference == 2000.0


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("{}", "give either an error or a quantity"),
        ('{error = "a", quantity = "b"}', "give either an error or a quantity"),
        ('{error = "a", reference = 1.0}', "a reference goes with a quantity"),
    ],
)
def test_wrong_tables(path: Path, table: str, words: str) -> None:
    with pytest.raises(CaseError, match=words):
        read_case(path, [f"study={table}"])


def test_a_case_cannot_study_what_nothing_measures(path: Path, capsys) -> None:
    path.write_text(CASE + '[study]\nerror = "sole.pressure_error_l2"\n')
    assert main(["check", str(path)]) == 2
    assert "study: nothing measures 'sole.pressure_error_l2'" in capsys.readouterr().err


def test_failures_are_rows(path: Path, tmp_path: Path, monkeypatch) -> None:
    """The family goes on; the first run of a curve is made twice, unless it fails."""
    seen: list[Path] = []

    def fake(member: Member, _: Path, out: Path, __: float) -> Outcome:
        seen.append(out)
        if member.problem or (member.curve.variant is None and member.level == 1):
            return Outcome(member.problem or "stopped after 1 s")
        return replace(outcome(1.0), values={"sole.force_y": 2.0 + 2.0**-member.level})

    monkeypatch.setattr(contactfem.study.study, "run_member", fake)
    base = Curve("", None, ())
    vary = ("solver.system=condensed,sadle",)
    study = Study(path, tmp_path / "out", base, vary, (1,), 3, ("space",), 9.0, "command")
    stream = io.StringIO()
    code = run_study(study, Target("sole.force_y", False, 2.0), Console(file=stream))
    assert code == 1
    text = stream.getvalue()
    assert "system = condensed, level 1: failed: stopped after 1 s" in text
    assert "system = sadle" in text and "must be one of" in text
    assert [out.name for out in seen] == [
        "curve_1_level_0", "curve_1_level_0", "curve_1_level_1", "curve_1_level_2",
        "curve_2_level_0", "curve_2_level_1", "curve_2_level_2",
    ]  # fmt: skip
    table = list(csv.DictReader((tmp_path / "out" / "study.csv").open()))
    assert [row["error"] for row in table] == ["0.5", "nan", "0.125", "nan", "nan", "nan"]
    assert float(table[2]["order"]) == pytest.approx(1.0)
    assert (tmp_path / "out" / "study.png").is_file()


def test_one_run(path: Path, tmp_path: Path) -> None:
    member = Member(Curve("", None, ()), 0, 1.0, ("conditions.0.displacement.y=-10 um",))
    found = run_member(member, path, tmp_path / "run", 120.0)
    assert found.message == ""
    assert found.unknowns == 20  # two components at all nodes but those on top
    assert found.iterations >= 1 and found.steps == 1
    assert found.values["sole.force_y"] < -1e4
    assert 0.0 < found.seconds < found.timings["total"] < found.wall < 120.0
    assert 5e7 < found.memory < 5e9
    assert not (tmp_path / "run" / "figures" / "interface_sole.png").exists()
    words = command_of(member, path, tmp_path / "run")
    assert words.startswith("contactfem run ") and "'conditions.0.displacement.y=-10 um'" in words


def test_runs_are_not_judged(path: Path) -> None:
    """What a case expects may be unknown to a run with other changes."""
    assert "expect=false" in command_of(Member(Curve("", None, ()), 0, 1.0), path, path.parent)
    assert read_case(path, ("expect=false",)).expect == {}


@pytest.mark.parametrize("program", ["true", "false"])
def test_results_of_an_earlier_study_are_not_shown(
    program: str, path: Path, tmp_path: Path, monkeypatch
) -> None:
    """A program that writes nothing stands for a run that fails at once, whatever it says."""
    stale = {"title": "", "steps": [], "verdicts": [], "passed": True, "converged": True}
    stale |= {"sizes": {"unknowns": 7}, "values": {}, "newton_iterations": 0, "timings": {}}
    (tmp_path / "summary.json").write_text(json.dumps(stale))
    monkeypatch.setattr(sys, "executable", shutil.which(program))
    found = run_member(Member(Curve("", None, ()), 0, 1.0), path, tmp_path, 60.0)
    assert found.message.startswith("ended with code")
    assert found.unknowns == 0


def test_runs_that_fail(path: Path, tmp_path: Path) -> None:
    """A bad case says its error, one that takes too long is stopped with what it started."""
    bad = Member(Curve("", None, ()), 0, 1.0, ("bodies.block.mesh.nx=0",))
    found = run_member(bad, path, tmp_path / "run", 120.0)
    assert "bodies.block.mesh.nx = 0" in found.message
    assert math.isnan(found.seconds)
    slow = Member(Curve("", None, ()), 0, 1.0, ())
    found = run_member(slow, path, tmp_path / "slow", 0.05)
    assert found.message == "stopped after 0.05 s"
    assert found.wall < 20.0


def test_the_command_refuses_to_run_under_mpirun(path: Path, monkeypatch, capsys) -> None:
    monkeypatch.setenv("OMPI_COMM_WORLD_SIZE", "2")
    assert main(["study", str(path), "--levels", "1", "--quantity", "sole.force_y"]) == 2
    assert "--ranks" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["--levels", "0"], [], ["--levels", "1", "--ranks", "1,x"]])
def test_wrong_words(path: Path, words: list[str], capsys) -> None:
    with pytest.raises(SystemExit):
        main(["study", str(path), *words])
    assert "--" in capsys.readouterr().err


@pytest.mark.slow
def test_a_small_study(path: Path, tmp_path: Path, monkeypatch, capsys) -> None:
    """The force of a block between rough plates falls to its limit; two ranks find the same."""
    monkeypatch.delenv("OMPI_COMM_WORLD_SIZE", raising=False)
    words = ["study", str(path), "--levels", "3", "--quantity", "sole.force_y", "--ranks", "1,2"]
    assert main([*words, "--out", str(tmp_path / "out")]) == 0
    assert "2 ranks" in capsys.readouterr().out
    found = json.loads((tmp_path / "out" / "study.json").read_text())
    one, two = found["runs"][:3], found["runs"][3:]
    assert [run["unknowns"] for run in one] == [20, 72, 272]
    assert [run["value"] for run in two] == pytest.approx([run["value"] for run in one], rel=1e-9)
    errors = [run["error"] for run in one]
    assert errors[2] is None and 0.0 < errors[1] < errors[0] < 0.1
    assert (tmp_path / "out" / "study.png").is_file()
