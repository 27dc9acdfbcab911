"""Folders of runs: one run at a time, all of its times, and nothing that is damaged is taken."""

# ruff: noqa: E501

import fcntl
import json
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.checkpoint.archive import read_archive, write_archive
from contactfem.checkpoint.checkpointer import Checkpointer
from contactfem.cli.main import main
from contactfem.errors import CaseError, CheckpointError, ContactfemError
from contactfem.run.driver import run_case
from contactfem.run.resume import prepare

CASE = """
title = "a warm block on a plane"
strain = "small"
time = { end = "4 s", step = "1 s" }
output = { figures = false, fields = false, checkpoint_every = 1 }
heat = {}
materials.m = { youngs_modulus = "10 MPa", poisson_ratio = 0.0, expansion = "1e-5 1/K", density = "1000 kg/m^3", heat_capacity = "1000 J/kg/K", conductivity = "1 W/m/K" }
bodies.b = { material = "m", mesh = { builder = "block", width = "2 mm", height = "1 mm", nx = 2, ny = 1 } }
obstacles.o = { shape = "plane", point = ["0 mm", "0 mm"], normal = [0.0, 1.0], temperature = "10 K" }
interfaces.c = { nonmortar = "b.bottom", mortar = "o", friction = { coefficient = 0.2 }, heat = { law = "constant", conductance = "100 W/m^2/K" } }
conditions = [{ on = "b.top", displacement = { x = "0 mm", y = [["0 s", "0 mm"], ["4 s", "-0.1 mm"]] } }]
"""


def written(folder: Path, text: str = CASE) -> Path:
    path = folder / "case.toml"
    path.write_text(text)
    return path


def finished(folder: Path, text: str = CASE) -> Path:
    out = folder / "out"
    result = run_case(read_case(written(folder, text)), MPI.COMM_SELF, out)
    assert result.converged, result.message
    return out


def test_one_run_at_a_time_writes_into_a_folder(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    case = read_case(written(tmp_path))
    with (out / ".lock").open("w") as file:
        file.write("4711\n")
        file.flush()
        fcntl.flock(file, fcntl.LOCK_EX)
        with pytest.raises(CaseError, match="another run \\(process 4711\\) writes into it"):
            run_case(case, MPI.COMM_SELF, out)
        assert not (out / "history.csv").exists()
    assert run_case(case, MPI.COMM_SELF, out).converged
    assert not (out / ".lock").exists()


def test_times_that_agree_to_six_digits_are_all_there(tmp_path: Path) -> None:
    text = CASE.replace("checkpoint_every = 1", 'times = ["1.000001 s", "1.0000004 s", "3 s"]')
    text = text.replace('"1.000001 s", "1.0000004 s"', '"1.0000004 s", "1.000001 s"')
    out = finished(tmp_path, text)
    names = {path.name for path in out.glob("interface_c_t=*.csv")}
    assert names == {f"interface_c_t={t}.csv" for t in ("1.0000004", "1.000001", "3")}


def test_the_first_checkpoint_is_due_after_a_minute(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = [0.0]
    monkeypatch.setattr("contactfem.checkpoint.checkpointer.time.monotonic", lambda: clock[0])
    case = read_case(written(tmp_path, CASE.replace(", checkpoint_every = 1", "")))
    keeper = Checkpointer(case, MPI.COMM_SELF, tmp_path, None, None, 0.0, bool)  # type: ignore[arg-type]
    assert not keeper._is_due(0)
    clock[0] = 59.0
    assert not keeper._is_due(1)
    clock[0] = 61.0
    assert keeper._is_due(2)
    keeper._step, keeper._time, keeper._any = 2, 61.0, True
    clock[0] = 300.0
    assert not keeper._is_due(3)


def test_a_full_disk_ends_with_3(tmp_path: Path) -> None:
    """A file may be 400 kB: fields do not fit, everything else does."""
    written(tmp_path, CASE.replace("fields = false", 'fields = "vtx"'))
    program = "from contactfem.cli.main import main; raise SystemExit(main())"
    command = f"ulimit -f 400; exec {sys.executable} -c '{program}' run case.toml --out out"
    done = subprocess.run(
        ["bash", "-c", command], cwd=tmp_path, capture_output=True, text=True, timeout=200
    )
    assert done.returncode == 3, done.stderr
    assert "no space left" in done.stderr
    assert "Traceback" not in done.stderr


def leaves(tree: dict, where: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    found = []
    for name, part in tree.items():
        found += leaves(part, (*where, name)) if isinstance(part, dict) else [(*where, name)]
    return found


def forge(tree: dict, rng: np.random.Generator) -> str:
    """Change one array of a state as no program would have written it."""
    path = leaves(tree)[rng.integers(len(leaves(tree)))]
    place = tree
    for name in path[:-1]:
        place = place[name]
    array, kind = place[path[-1]], rng.integers(6)
    if kind == 0:
        del place[path[-1]]
    elif kind == 1:
        place[path[-1]] = array.astype(str)
    elif kind == 2:
        place[path[-1]] = np.zeros((3, 5, 2))
    elif kind == 3 and array.dtype.kind == "f":
        place[path[-1]] = np.full_like(array, np.nan)
    elif kind == 4 and array.ndim:
        place[path[-1]] = np.concatenate((array, array))
    else:
        place[path[-1]] = array + 10**6 if array.dtype.kind in "iu" else array[..., None]
    return f"{'/'.join(path)}: {kind}"


@pytest.mark.parametrize("seed", range(40))
def test_a_forged_checkpoint_ends_in_one_line(
    finished_once: Path, tmp_path: Path, seed: int
) -> None:
    """Sizes, kinds and numbers that do not fit: an error with exit code 2, or a run that goes on."""
    head, tree = read_archive(finished_once / "checkpoint.npz")
    what = forge(tree, np.random.default_rng(seed))
    write_archive(tmp_path / "checkpoint.npz", head, tree)
    try:
        resumption = prepare(tmp_path, ['time.end="6 s"'])
        assert resumption.case is not None
        run_case(resumption.case, MPI.COMM_SELF, tmp_path, resumed=resumption.checkpoint)
    except ContactfemError as error:
        assert len(str(error).splitlines()) == 1, what
        assert error.exit_code in (2, 3), what


@pytest.mark.parametrize("seed", range(30))
def test_a_damaged_checkpoint_ends_in_one_line(
    finished_once: Path, tmp_path: Path, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    data = bytearray((finished_once / "checkpoint.npz").read_bytes())
    for place in rng.integers(0, len(data), 4):
        data[place] = rng.integers(256)
    (tmp_path / "checkpoint.npz").write_bytes(data[: rng.integers(1, 2 * len(data))])
    try:
        prepare(tmp_path, ['time.end="6 s"'])
    except CheckpointError as error:
        assert len(str(error).splitlines()) == 1


def test_a_header_of_a_huge_array_takes_no_memory(finished_once: Path, tmp_path: Path) -> None:
    head, tree = read_archive(finished_once / "checkpoint.npz")
    tree["state"]["others"] = np.zeros(7)
    write_archive(tmp_path / "whole.npz", head, tree)
    assert b"'shape': (7,), }         " in (tmp_path / "whole.npz").read_bytes()
    with (
        zipfile.ZipFile(tmp_path / "whole.npz") as old,
        zipfile.ZipFile(tmp_path / "checkpoint.npz", "w") as new,
    ):
        for info in old.infolist():
            forged = old.read(info).replace(
                b"'shape': (7,), }         ", b"'shape': (7777777777,), }"
            )
            new.writestr(info.filename, forged)
    with pytest.raises(CheckpointError, match="damaged"):
        prepare(tmp_path, ['time.end="6 s"'])


@pytest.fixture(scope="module")
def finished_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return finished(tmp_path_factory.mktemp("run"))


@pytest.mark.parametrize("seed", range(40))
def test_a_damaged_summary_ends_in_one_line(
    finished_once: Path, tmp_path: Path, seed: int, capsys: pytest.CaptureFixture[str]
) -> None:
    rng = np.random.default_rng(seed)
    summary = json.loads((finished_once / "summary.json").read_text())
    key = list(summary)[rng.integers(len(summary))]
    summary[key] = [None, 3, "x", [1], {"a": None}, [[[]]], float("nan")][rng.integers(7)]
    (tmp_path / "summary.json").write_text(json.dumps(summary))
    assert main(["report", str(tmp_path)]) in (0, 1, 2), key
    said = capsys.readouterr()
    assert "Traceback" not in said.err + said.out
