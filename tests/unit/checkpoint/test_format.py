"""Checkpoint files: whole or refused, the last good one kept, errors said in one line."""

import errno
import json
import resource
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from contactfem.adaptivity.decisions import MeshHistory
from contactfem.checkpoint import archive
from contactfem.checkpoint import format as checkpoint
from contactfem.checkpoint.archive import read_archive, write_archive
from contactfem.checkpoint.format import (
    Checkpoint,
    Origin,
    Progress,
    read_checkpoint,
    write_checkpoint,
)
from contactfem.errors import CaseError, CheckpointError
from contactfem.results.data import Failure, HeatStep, StepReport
from contactfem.run.resume import prepare

ROOT = Path(__file__).parents[3]
SLIDE = ROOT / "tests/data/warm_slide.toml"
HEAT = HeatStep(2, 1e-7, 0.1, 20.0, 3.0, {"a.b": 1 / 3}, 0.0, 0.1, 0.0, 0.0, 1e-17, {"j": 2.0},
                float("nan"), "")  # fmt: skip
STEP = StepReport(1, 0.1 + 0.2, 0.1, 5, 0, (1.0, 1e-13), 1, 2, 3, {"j": (1 / 3, -2e-300)}, 0.1, 0.2,
                  {"j": 1e-3}, HEAT)  # fmt: skip


def some(steps: int = 1, path: str = "/cases/x.toml") -> Checkpoint:
    reports = tuple(replace(STEP, step=k + 1, t=0.1 * (k + 1)) for k in range(steps))
    lasting = MeshHistory(1 / 3, 0.1, {"heat": 3}, {"heat": 4}), MeshHistory()
    failures = (Failure(0.5, "why", 0.25),)
    progress = Progress(
        0.1, 0.2, (5, 7), True, reports, failures, ("so",), (1e3,), 2, True, lasting
    )
    origin = Origin(path, {"title": "x", "time": {"end": "1 s"}}, "contactfem run x.toml")
    tree = {"state": {"u": np.arange(5.0), "kind": np.array("triangle")}, "none": np.empty((0, 3))}
    return Checkpoint(origin, progress, {"newton": 1 / 3}, tree)


def test_what_is_written_is_read(tmp_path):
    """To the last bit, numbers that are not finite included."""
    write_checkpoint(tmp_path, some())
    found, warning = read_checkpoint(tmp_path)
    assert warning == ""
    assert repr(found.progress) == repr(some().progress)
    assert (found.origin, found.seconds) == (some().origin, some().seconds)
    assert np.array_equal(found.state["state"]["u"], np.arange(5.0))
    assert str(found.state["state"]["kind"]) == "triangle"
    assert found.state["none"].shape == (0, 3)
    assert [step.step for step in found.progress.recorded] == []
    assert [path.name for path in tmp_path.iterdir()] == ["checkpoint.npz"]


def test_a_damaged_file_is_never_taken_for_a_whole_one(tmp_path):
    path = tmp_path / "a.npz"
    head, tree = {"t": 1 / 3}, {"a": {"b": np.arange(9.0)}, "c": np.eye(2)}
    write_archive(path, head, tree)
    whole, expected = path.read_bytes(), repr(read_archive(path))
    refused = 0
    for k in range(len(whole)):
        path.write_bytes(whole[:k] + bytes((whole[k] ^ 0xFF,)) + whole[k + 1 :])
        try:
            assert repr(read_archive(path)) == expected  # a date, for instance
        except CheckpointError as error:
            assert str(error).startswith(f"{path}: ") and "\n" not in str(error)
            refused += 1
    assert refused > 0.5 * len(whole)
    for k in range(0, len(whole), 7):
        path.write_bytes(whole[:k])
        with pytest.raises(CheckpointError, match=r"a\.npz: "):
            read_archive(path)


def test_the_last_good_one_is_kept_and_taken(tmp_path):
    for steps in (1, 2, 3):
        write_checkpoint(tmp_path, some(steps))
    assert len(read_checkpoint(tmp_path)[0].progress.reports) == 3
    last = tmp_path / "checkpoint.npz"
    last.write_bytes(last.read_bytes()[:-500])
    found, warning = read_checkpoint(tmp_path)
    assert len(found.progress.reports) == 2
    assert (
        warning == f"{last}: is damaged, or was never a checkpoint; taking checkpoint.previous.npz"
    )
    last.unlink()  # between two renamings
    assert len(read_checkpoint(tmp_path)[0].progress.reports) == 2
    last.write_text("nothing")
    (tmp_path / "checkpoint.previous.npz").write_text("nothing")
    with pytest.raises(CheckpointError) as caught:
        read_checkpoint(tmp_path)
    assert str(caught.value).splitlines() == [
        f"{tmp_path / name}: is damaged, or was never a checkpoint"
        for name in ("checkpoint.npz", "checkpoint.previous.npz")
    ]


def test_another_format_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(checkpoint, "FORMAT", 99)
    monkeypatch.setattr(checkpoint, "__version__", "9.9")
    write_checkpoint(tmp_path, some())
    monkeypatch.undo()
    with pytest.raises(CheckpointError, match=r"has format 99, of contactfem 9\.9; this is "):
        read_checkpoint(tmp_path)


def test_other_contents_of_the_same_format_are_refused(tmp_path):
    path = tmp_path / "checkpoint.npz"
    write_archive(path, {"format": checkpoint.FORMAT, "version": "0.0", "origin": {}}, {})
    with pytest.raises(CheckpointError, match=r"contactfem 0\.0 wrote other things into it than "):
        read_checkpoint(tmp_path)


@contextmanager
def little_room() -> Iterator[None]:
    """No file may be longer than 300 bytes inside, as on a full disk; nor what pytest prints to."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (300, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_a_full_disk_leaves_what_was_there(tmp_path):
    write_checkpoint(tmp_path, some(1))
    with little_room(), pytest.raises(OSError) as caught:
        write_checkpoint(tmp_path, some(2))
    assert caught.value.errno == errno.EFBIG
    assert [path.name for path in tmp_path.iterdir()] == ["checkpoint.npz"]
    assert len(read_checkpoint(tmp_path)[0].progress.reports) == 1


class Crash:
    """A function whose n-th call is the last thing that happens."""

    def __init__(self, function, nth):
        self.function, self.left = function, nth

    def __call__(self, *arguments):
        self.left -= 1
        if self.left == 0:
            raise KeyboardInterrupt
        return self.function(*arguments)


def test_it_is_on_the_disk_before_the_old_one_goes(tmp_path, monkeypatch):
    """A crash at any call leaves a checkpoint that can be read: the last one or the new one."""
    for name in ("fsync", "replace"):
        for nth in (1, 2, 3):
            folder = tmp_path / f"{name}{nth}"
            folder.mkdir()
            for steps in (1, 2):
                write_checkpoint(folder, some(steps))
            monkeypatch.setattr(archive.os, name, Crash(getattr(archive.os, name), nth))
            with suppress(KeyboardInterrupt):
                write_checkpoint(folder, some(3))
            monkeypatch.undo()
            assert len(read_checkpoint(folder)[0].progress.reports) in (2, 3)


def test_what_may_be_changed(tmp_path):
    path = tmp_path / "gone.toml"  # the file itself is not read again
    contents = {
        "title": "x",
        "time": {"end": "1 s", "step": "0.1 s"},
        "materials": {"m": {"youngs_modulus": "1 MPa", "poisson_ratio": 0.3}},
        "bodies": {"b": {"material": "m", "mesh": {"builder": "block", "width": "1 mm",
                                                   "height": "1 mm", "nx": 2, "ny": 2}}},
        "conditions": [{"on": "b.bottom", "displacement": ["0 mm", "0 mm"]}],
    }  # fmt: skip
    written = some()
    write_checkpoint(tmp_path, replace(written, origin=Origin(str(path), contents, "run")))
    found = prepare(tmp_path, [])
    assert found.case is not None and found.case.time.step_max == 0.1
    assert found.checkpoint is not None and found.checkpoint.progress.easy == (5, 7)
    changed = prepare(tmp_path, ["time.step=0.01 s", "solver.max_cutbacks=20"])
    assert changed.case is not None and changed.case.solver.max_cutbacks == 20
    assert changed.checkpoint is not None
    assert (changed.checkpoint.progress.dt, changed.checkpoint.progress.ramp_end) == (0.01, 0.2)
    for text in ("materials.m.poisson_ratio=0.4", "solver.system=saddle", "timeout=3"):
        with pytest.raises(
            CaseError, match="cannot be changed in a run that goes on; can be: time"
        ):
            prepare(tmp_path, [text])
    with pytest.raises(CaseError, match=r"gone.toml: time.end = 1 m: is a length"):
        prepare(tmp_path, ["time.end=1 m"])
    ended = prepare(tmp_path, ["time.end=0.1 s"])
    assert ended.case is None and ended.says.endswith("t = 0.1 s; there is nothing to do")


def resume(folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "contactfem", "resume", str(folder)],
        capture_output=True, text=True, timeout=60, cwd=ROOT,
    )  # fmt: skip


def test_nothing_to_resume_from(tmp_path):
    missing = resume(tmp_path / "missing")
    assert (missing.returncode, missing.stdout) == (2, "")
    assert missing.stderr == (
        f"{tmp_path / 'missing'}: no such directory; a run makes it: contactfem run CASE\n"
    )
    (tmp_path / "summary.json").write_text(
        json.dumps({"title": "", "steps": [], "verdicts": [], "passed": False, "converged": False})
    )
    empty = resume(tmp_path)
    assert empty.returncode == 2
    assert empty.stderr.startswith(f"{tmp_path}: no checkpoint.npz: ")
    assert len(empty.stderr.splitlines()) == 1


LIMITED = """
import resource, sys
from mpi4py import MPI  # which needs room itself
from contactfem.cli.main import main
resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))
sys.exit(main(sys.argv[1:]))
"""


def limited(limit: int, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", LIMITED.format(limit=limit), *arguments],
        capture_output=True, text=True, timeout=120, cwd=ROOT,
    )  # fmt: skip


QUIET = ["--set", "output.fields=false", "--set", "output.figures=false"]
SHORT = ["--set", "time.end=0.15 s", "--set", "output.times=[]", *QUIET]


def test_a_run_outlives_a_checkpoint_that_cannot_be_written(tmp_path):
    """And says so each time; a run that cannot write its results ends with one line."""
    done = limited(50_000, "run", str(SLIDE), "--out", str(tmp_path), *SHORT)
    assert done.returncode == 0, done.stderr
    line = f"WARNING: {tmp_path / 'checkpoint.npz'}: not written: File too large"
    assert done.stdout.splitlines().count(line) == 3
    failed = limited(1000, "run", str(SLIDE), "--out", str(tmp_path), *SHORT)
    assert failed.returncode == 3
    assert failed.stderr.splitlines()[0].endswith("cannot be written: File too large")
    assert "Traceback" not in failed.stderr
