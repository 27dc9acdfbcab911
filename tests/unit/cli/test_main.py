"""The command line as a user meets it: output, exit codes, what it imports."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from contactfem.cli.main import main
from contactfem.errors import (
    CaseError,
    CheckpointError,
    ContactfemError,
    ExitCode,
    Interrupted,
    MeshError,
    SolverError,
    WriteError,
)
from contactfem.results.data import RunResult

ROOT = Path(__file__).resolve().parents[3]
TWO = ROOT / "tests/data/two_blocks.toml"
FORBIDDEN = ("dolfinx", "mpi4py", "petsc4py", "scipy", "matplotlib", "gmsh", "meshio", "pint")


def python(*arguments):
    return subprocess.run(
        [sys.executable, *arguments], capture_output=True, text=True, timeout=120, cwd=ROOT
    )


@pytest.fixture(autouse=True)
def in_a_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    "code",
    [
        "import contactfem.case.schema",
        f"from contactfem.cli.main import main; assert main(['check', {str(TWO)!r}]) == 0",
        "from contactfem.cli.main import main; assert main(['schema']) == 0",
    ],
    ids=["case", "check", "schema"],
)
def test_reading_a_case_imports_nothing_heavy(code):
    found = python("-c", f"{code}\nimport sys\nprint(sorted(set(sys.modules) & set({FORBIDDEN})))")
    assert found.returncode == 0, found.stderr
    assert found.stdout.splitlines()[-1] == "[]"


def test_check_prints_and_returns_zero(capsys):
    assert main(["check", str(TWO)]) == ExitCode.DONE
    assert capsys.readouterr().out.startswith("A small block pressed onto a larger one\n")


@pytest.mark.parametrize("verb", ["check", "mesh", "run"])
def test_a_bad_case_gives_one_line_and_two(verb, capsys):
    arguments = [verb, str(TWO), "--set", 'time.end="1 m"']
    assert main([*arguments, "--out", "x"] if verb != "check" else arguments) == ExitCode.BAD_CASE
    out, err = capsys.readouterr()
    assert (out, err) == (
        "",
        f"{TWO}: time.end = 1 m: is a length, not a time; give a time such as '0.5 s'\n",
    )


def test_check_reads_the_variants_too(tmp_path, capsys):
    path = tmp_path / "case.toml"
    path.write_text(TWO.read_text() + "\n[variants.wrong]\n'time.stepp' = 3\n")
    assert main(["check", str(path)]) == ExitCode.BAD_CASE
    line = f"{path}: time.stepp: unknown key; did you mean 'step'? (variant wrong)\n"
    assert capsys.readouterr().err == line
    assert main(["check", str(path), "--variant", "fine"]) == ExitCode.DONE


def test_check_knows_what_can_be_measured(capsys):
    assert main(["check", str(TWO), "--set", "expect.stepps={max=3}"]) == ExitCode.BAD_CASE
    assert "did you mean 'steps'?" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [[], ["chek"], ["check"], ["mesh", str(TWO)]])
def test_bad_usage_gives_two(arguments, capsys):
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2
    assert "usage: contactfem" in capsys.readouterr().err


@pytest.mark.parametrize("verb", ["check", "mesh", "run", "resume", "report", "schema"])
def test_every_command_has_help(verb, capsys):
    with pytest.raises(SystemExit) as caught:
        main([verb, "--help"])
    assert caught.value.code == 0
    assert "exit codes: 0 done, 1 an expectation missed, 2 bad case" in capsys.readouterr().out


def test_the_schema_is_json(capsys):
    assert main(["schema"]) == ExitCode.DONE
    assert json.loads(capsys.readouterr().out)["title"] == "Case"


def test_meshes_are_written_and_read_again(tmp_path, capsys):
    assert main(["mesh", str(TWO), "--out", "meshes"]) == ExitCode.DONE
    first, second = capsys.readouterr().out.splitlines()
    assert first == (
        "meshes/upper.msh: 12 points, 6 quadrilaterals, facets: left 2, right 2, bottom 3, top 3"
    )
    assert "20 triangles" in second
    names = sorted(path.name for path in (tmp_path / "meshes").iterdir())
    assert names == ["lower.msh", "lower.png", "upper.msh", "upper.png"]
    again = ["--set", 'bodies.lower.mesh={file="meshes/lower.msh", unit="m"}']
    copy = tmp_path / "case.toml"
    copy.write_text(TWO.read_text())
    assert main(["check", str(copy), *again]) == ExitCode.DONE
    assert "lower.top (mortar): gap 0.5 mm" in capsys.readouterr().out


def test_a_folder_that_cannot_be_made(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main(["mesh", str(TWO), "--out", "file/meshes"]) == ExitCode.BAD_CASE
    assert capsys.readouterr().err == "file/meshes: cannot be written to: Not a directory\n"


def test_report_without_results(capsys):
    assert main(["report", str(TWO)]) == ExitCode.BAD_CASE
    assert capsys.readouterr().err == (
        f"{TWO}: has no results in runs; 'contactfem run {TWO}' makes them\n"
    )


def test_report_of_something_else(tmp_path, capsys):
    (tmp_path / "runs" / "block").mkdir(parents=True)
    assert main(["report", "runs/blok"]) == ExitCode.BAD_CASE
    assert capsys.readouterr().err == (
        "runs/blok: there is no such folder of a run; did you mean 'runs/block'?\n"
    )
    (tmp_path / "cases").mkdir()
    (tmp_path / "cases" / "some.toml").write_text("")
    assert main(["report", "--html", "cases"]) == ExitCode.BAD_CASE
    assert capsys.readouterr().err == "cases: holds case files; --html takes folders of runs\n"
    assert main(["check", "some.toml"]) == ExitCode.BAD_CASE
    line = "some.toml: there is no such file; did you mean 'cases/some.toml'?\n"
    assert capsys.readouterr().err == line
    assert main(["check", "cases"]) == ExitCode.BAD_CASE
    line = "cases: is a folder, not a case file; give one of its files, such as cases/some.toml\n"
    assert capsys.readouterr().err == line


FREE = """
title = "Pressed on one side"
time = { end = "1 s", step = "1 s" }
materials.steel = { youngs_modulus = "210 GPa", poisson_ratio = 0.3 }
bodies.block.material = "steel"
bodies.block.mesh = { builder = "block", width = "1 m", height = "1 m", nx = 1, ny = 1 }
conditions = [{ on = "block.top", pressure = "1 MPa" }]
"""


def test_a_body_that_nothing_holds_is_not_run(tmp_path, capsys):
    (tmp_path / "case.toml").write_text(FREE)
    assert main(["run", "case.toml"]) == ExitCode.BAD_CASE
    assert capsys.readouterr().err == (
        "case.toml: bodies.block: free in x, y, rotation: nothing holds it; prescribe a "
        "displacement, or make it touch something in an interface\n"
    )


def test_a_closed_pipe_is_no_error():
    command = f"{sys.executable} -m contactfem check {TWO} | head -n 1"
    found = subprocess.run(command, shell=True, capture_output=True, text=True, cwd=ROOT)
    assert found.stdout == "A small block pressed onto a larger one\n"
    assert found.stderr == ""


def test_errors_know_their_exit_code():
    bad = [CaseError, MeshError, CheckpointError]
    ended = [SolverError, WriteError, ContactfemError]
    assert [error.exit_code for error in (*bad, *ended, Interrupted)] == [2, 2, 2, 3, 3, 3, 4]


def stand_in(monkeypatch, message, passed, raises=None):
    """Replace the solver by something that has just run."""
    import contactfem.run.driver

    def run_case(case, comm, out, invocation, resumed):
        if raises is not None:
            raise raises
        out.mkdir(parents=True)
        verdict = {
            "key": "steps", "unit": "", "value": 4.0, "low": 4.0, "high": 4.0, "passed": passed,
        }  # fmt: skip
        summary = {"title": case.title, "verdicts": [verdict]}
        (out / "summary.json").write_text(json.dumps(summary))
        return RunResult(case, (), (), (), {}, {}, {}, {}, not message, message)

    monkeypatch.setattr(contactfem.run.driver, "run_case", run_case)
    monkeypatch.setattr("contactfem.output.tables.read_summary", lambda out: json.loads(
        (out / "summary.json").read_text()
    ))  # fmt: skip


@pytest.mark.parametrize(
    ("message", "passed", "code"),
    [("", True, 0), ("", False, 1), ("no equilibrium", True, 3), ("no equilibrium", False, 3)],
)
def test_run_says_how_it_went(monkeypatch, capsys, tmp_path, message, passed, code):
    stand_in(monkeypatch, message, passed)
    assert main(["run", str(TWO)]) == code
    out, err = capsys.readouterr()
    assert out.startswith("A small block pressed onto a larger one\n")
    assert out.endswith("results in runs/two_blocks\n")
    assert err == (f"{message}\n" if message else "")


def test_run_all_goes_through_the_variants(monkeypatch, tmp_path):
    stand_in(monkeypatch, "", True)
    assert main(["run", str(TWO), "--variant", "all"]) == 0
    assert main(["run", str(TWO), "--variant", "all", "--out", "here"]) == 0
    assert main(["run", str(TWO), "--variant", "fine", "--out", "there"]) == 0
    names = ["two_blocks", "two_blocks-fine", "two_blocks-frictionless"]
    assert sorted(path.name for path in (tmp_path / "runs").iterdir()) == names
    assert sorted(path.name for path in (tmp_path / "here").iterdir()) == names
    assert (tmp_path / "there/summary.json").is_file()


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (CaseError("f: x: y"), 2),
        (SolverError("gave up"), 3),
        (Interrupted("stopped"), 4),
        (ZeroDivisionError("oh"), 70),
    ],
)
def test_errors_of_a_run(monkeypatch, capsys, error, code):
    stand_in(monkeypatch, "", True, raises=error)
    assert main(["run", str(TWO)]) == code
    err = capsys.readouterr().err
    assert (err == f"{error}\n") == (code != 70)
    assert ("Traceback" in err) == (code == 70)


ONE_FAILS = """
import sys
import contactfem.cli.run, contactfem.run.driver
from contactfem.cli.main import main
from contactfem.errors import CaseError

def run_case(case, comm, out, invocation, resumed):
    if comm.rank == {rank}:
        raise {error}
    comm.barrier()

contactfem.run.driver.run_case = run_case
contactfem.cli.run.PATIENCE = 0.3
sys.exit(main(["run", {path!r}]))
"""


def on_two_ranks(*arguments):
    command = ["mpirun", "-n", "2", sys.executable, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, cwd=ROOT)


@pytest.mark.parametrize(
    ("rank", "error", "said"),
    [
        (1, "ZeroDivisionError('oh')", "rank 1: Traceback"),
        (0, "ZeroDivisionError('oh')", "rank 0: Traceback"),
        (0, "CaseError('f: x: y')", "f: x: y\n"),
        (1, "CaseError('f: x: y')", "rank 1: f: x: y\n"),
    ],
)
def test_a_rank_that_fails_alone_stops_the_others(rank, error, said):
    found = on_two_ranks("-c", ONE_FAILS.format(rank=rank, error=error, path=str(TWO)))
    assert found.returncode != 0
    assert said in found.stderr
    assert found.stdout.count("A small block") == 1


def test_no_colour_under_mpirun(tmp_path):
    found = on_two_ranks("-m", "contactfem", "run", str(TWO), "--out", str(tmp_path / "out"))
    assert "probe.corner" in found.stdout
    assert "\x1b" not in found.stdout


def test_a_bad_case_is_told_once_on_two_ranks():
    found = on_two_ranks("-m", "contactfem", "run", str(TWO), "--set", "time.end=3 m")
    assert found.returncode == ExitCode.BAD_CASE
    assert found.stderr.count("time.end = 3 m: is a length") == 1
    assert "Traceback" not in found.stderr
