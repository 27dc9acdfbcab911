"""Runs that are stopped, killed or given up go on to the numbers of an uninterrupted run."""

import csv
import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.checkpoint.format import Checkpoint, read_checkpoint
from contactfem.errors import ExitCode, Interrupted
from contactfem.results.data import RunResult
from contactfem.run.driver import Invocation, run_case
from contactfem.run.resume import prepare
from contactfem.solvers.newton import NewtonSolver, SolveReport, StepInput

ROOT = Path(__file__).parents[2]
SLIDE = ROOT / "tests/data/warm_slide.toml"
QUIET = ("output.figures=false", "output.fields=false")
TRIANGLES = 'bodies.upper.mesh.cell="triangle"'
WORLD, SELF = MPI.COMM_WORLD, MPI.COMM_SELF


def run(
    folder: Path | None,
    *overrides: str,
    comm: MPI.Comm = SELF,
    steps: int | None = None,
    resumed: Checkpoint | None = None,
    path: Path = SLIDE,
) -> RunResult:
    """Run the case, at most so many steps of it, or go on with it."""
    seen: list[int] = []

    def asked() -> bool:
        seen.append(1)
        return steps is not None and len(seen) > steps

    case = read_case(path, [*QUIET, *overrides])
    return run_case(case, comm, folder, Invocation("contactfem run x", 0.0, asked), resumed)


def stopped(folder: Path, *overrides: str, steps: int, comm: MPI.Comm = SELF) -> Checkpoint:
    """Run some steps, fewer if some are taken twice, be interrupted, and read what is left."""
    with pytest.raises(Interrupted, match=r"stopped after step \d+, t = "):
        run(folder, *overrides, comm=comm, steps=steps)
    return read_checkpoint(folder)[0]


def numbers(value: object) -> Iterator[float]:
    """All numbers in a report but times by the clock."""
    if isinstance(value, dict):
        for key, part in value.items():
            if key not in ("wall", "seconds", "residuals"):
                yield from numbers(part)
    elif isinstance(value, list | tuple):
        for part in value:
            yield from numbers(part)
    elif isinstance(value, int | float):
        yield float(value)


def assert_same(found: RunResult, expected: RunResult, rel: float = 1e-9) -> None:
    """Steps with their decisions, interfaces, pictures and reactions of both runs agree."""
    assert [s.iterations for s in found.steps] == [s.iterations for s in expected.steps]
    for a, b in zip(found.steps, expected.steps, strict=True):
        first, second = (np.array(list(numbers(asdict(step)))) for step in (a, b))
        np.testing.assert_allclose(first, second, rtol=rel, atol=rel * np.abs(second).max())
    for a, b in zip(found.interfaces, expected.interfaces, strict=True):
        assert np.array_equal(a.status, b.status)
        for name in ("x", "pressure", "traction", "slip"):
            scale = np.abs(getattr(b, name)).max()
            atol = rel * scale
            np.testing.assert_allclose(getattr(a, name), getattr(b, name), rtol=0, atol=atol)
        for x, y in zip(a.heat or (), b.heat or (), strict=True):
            np.testing.assert_allclose(x, y, rtol=rel, atol=rel * np.nanmax(np.abs(y)))
    for a, b in zip(found.bodies + found.heat, expected.bodies + expected.heat, strict=True):
        assert np.array_equal(a.points, b.points) and np.array_equal(a.cells, b.cells)
        for name in b.fields:
            scale = np.abs(b.fields[name]).max()
            np.testing.assert_allclose(a.fields[name], b.fields[name], atol=rel * scale)
    forces = [np.concatenate(list(r.reactions.values())) for r in (found, expected)]
    np.testing.assert_allclose(forces[0], forces[1], atol=rel * np.abs(forces[1]).max())


KINDS = {
    "heat": (),
    "mini": (TRIANGLES, 'materials.rubber.bulk_modulus="1 GPa"'),
    "saddle": ('solver.system="saddle"',),
    "augmented": ('interfaces.joint.normal.law="augmented"',),
    "adaptive": (TRIANGLES, 'adaptivity={mechanics="25 %", heat="30 %", time="10 %"}',
                 'time.end="0.1 s"', "output.times=[]"),
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_a_stopped_run_goes_on_as_if_nothing_had_been(tmp_path, kind):
    """Contact, friction, heat and its ringing, multipliers, bubbles, new meshes, step control."""
    whole = run(None, *KINDS[kind])
    half = len(whole.steps) // 2
    checkpoint = stopped(tmp_path, *KINDS[kind], steps=half)
    assert 2 < len(checkpoint.progress.reports) <= half
    assert_same(run(tmp_path, *KINDS[kind], resumed=checkpoint), whole)
    if kind == "adaptive":
        errors = [step.errors for step in whole.steps if step.errors is not None]
        assert sum(len(e.remeshes) for e in errors) >= 2 and sum(e.repeats for e in errors) >= 2
        assert checkpoint.progress.pending and "before" in checkpoint.state


def test_without_heat(tmp_path):
    """And from the very start, where there are no conditions yet."""
    path, parts = ROOT / "cases/block.toml", ("time.step=0.25 s", "bodies.block.mesh.nx=16",
                                              "bodies.block.mesh.ny=16")  # fmt: skip
    whole = run(None, *parts, path=path)
    assert whole.converged and whole.steps[-1].stick > 0 and whole.steps[-1].slip > 0
    for steps in (0, 2):
        with pytest.raises(Interrupted):
            run(tmp_path, *parts, steps=steps, path=path)
        checkpoint = read_checkpoint(tmp_path)[0]
        assert_same(run(tmp_path, *parts, resumed=checkpoint, path=path), whole)


def test_on_one_rank_it_is_the_same_to_the_last_bit(tmp_path):
    """As long as no matrix has grown, whose unknowns would then be eliminated in another order."""
    whole = run(None)
    again = run(tmp_path, resumed=stopped(tmp_path, steps=3))
    for a, b in zip(again.interfaces, whole.interfaces, strict=True):
        assert np.array_equal(a.pressure, b.pressure) and np.array_equal(a.slip, b.slip)
    assert [s.forces for s in again.steps] == [s.forces for s in whole.steps]
    assert [s.residuals for s in again.steps] == [s.residuals for s in whole.steps]


@pytest.mark.mpi
@pytest.mark.parametrize("kind", ["heat", "mini", "saddle"])
def test_on_other_numbers_of_ranks(tmp_path, kind):
    """From one rank fewer to all, and from all to one."""
    folder = Path(WORLD.bcast(str(tmp_path)))
    whole = run(None, *KINDS[kind])
    fewer = max(WORLD.size - 1, 1)
    part = WORLD.Split(WORLD.rank < fewer)
    if WORLD.rank < fewer:
        stopped(folder, *KINDS[kind], steps=5, comm=part)
    WORLD.barrier()
    checkpoint = read_checkpoint(folder)[0]
    with pytest.raises(Interrupted):
        bare = checkpoint if WORLD.rank == 0 else replace(checkpoint, state={})
        run(folder, *KINDS[kind], comm=WORLD, steps=4, resumed=bare)
    WORLD.barrier()
    checkpoint = read_checkpoint(folder)[0]
    assert len(checkpoint.progress.reports) == 9
    assert_same(run(None, *KINDS[kind], resumed=checkpoint), whole)


def refusing(monkeypatch: pytest.MonkeyPatch, after: float, above: float) -> None:
    """Make steps fail that end after a time and are longer than a length [s]."""
    original = NewtonSolver.solve

    def solve(self: NewtonSolver, step: StepInput) -> SolveReport:
        report = original(self, step)
        dt = step.histories[0].dt
        if step.t > after and dt > above:
            return SolveReport(False, "refused by the test", report.iterations, report.residuals)
        return report

    monkeypatch.setattr(NewtonSolver, "solve", solve)


def test_a_run_that_gave_up_goes_on_with_smaller_steps(tmp_path, monkeypatch):
    """As if they had been allowed from the start, cut-backs included."""
    refusing(monkeypatch, after=0.7, above=0.02)
    few = ('time.step_min="30 ms"',)
    many = ('time.step_min="5 ms"',)
    given_up = run(tmp_path, *few)
    assert given_up.message.endswith(f"; 'contactfem resume {tmp_path}' goes on from there")
    assert not given_up.converged and "step_min" in given_up.message
    assert "refused by the test" in given_up.message
    found = prepare(tmp_path, many)
    assert found.case is not None and found.case.time.step_min == 5e-3
    resumed = run(tmp_path, *many, resumed=found.checkpoint)
    whole = run(None, *many)
    assert resumed.converged and max(s.cutbacks for s in whole.steps) >= 3
    assert_same(resumed, whole)


def test_giving_up_again_writes_the_same_state(tmp_path, monkeypatch):
    """Pictures and tables of a run that is resumed in vain are those of its checkpoint."""
    refusing(monkeypatch, after=0.5, above=0.0)
    first = run(tmp_path)
    second = run(tmp_path, resumed=read_checkpoint(tmp_path)[0])
    assert not first.converged and first.message == second.message
    assert_same(second, first, rel=1e-12)


def test_step_control_is_kept(tmp_path):
    """Half-way to a longer step, with a step that was clipped at a time of output."""
    settings = ('time.end="0.5 s"', 'time.step="10 ms"', 'time.step_max="80 ms"',
                'output.times=["133 ms"]')  # fmt: skip
    whole = run(None, *settings)
    for steps in (1, 6):
        folder = tmp_path / str(steps)
        again = run(folder, *settings, resumed=stopped(folder, *settings, steps=steps))
        assert [s.t for s in again.steps] == [s.t for s in whole.steps]


# What follows are whole processes.


def command(verb: str, *arguments: str) -> list[str]:
    return [sys.executable, "-m", "contactfem", verb, *arguments]


def processed(verb: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command(verb, *arguments), capture_output=True, text=True, timeout=120, cwd=ROOT
    )


STEPS = ('time.end="0.5 s"', 'time.step="10 ms"', 'time.step_max="10 ms"', "output.times=[]",
         *QUIET)  # fmt: skip


def settings(*overrides: str) -> list[str]:
    return [word for text in overrides for word in ("--set", text)]


def started(verb: str, folder: Path) -> subprocess.Popen[str]:
    where = ["--out", str(folder), *settings(*STEPS)] if verb == "run" else []
    target = str(SLIDE) if verb == "run" else str(folder)
    return subprocess.Popen(
        command(verb, target, *where),
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT,
    )  # fmt: skip


def history(folder: Path) -> tuple[list[str], np.ndarray]:
    with (folder / "history.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    return header, np.array(rows, float)


def assert_same_history(folder: Path, whole: Path) -> None:
    """To 1e-9 of the largest value of the same unit, but for the wall-clock."""
    header, expected = history(whole)
    again, found = history(folder)
    assert again == header and found.shape == expected.shape
    for name in header:
        if name not in ("wall [s]", "residual"):
            unit = name.partition("[")[2]
            same = [k for k, other in enumerate(header) if other.partition("[")[2] == unit]
            scale = np.abs(expected[:, same]).max() if unit else 1.0
            k = header.index(name)
            np.testing.assert_allclose(
                found[:, k], expected[:, k], rtol=0, atol=1e-9 * scale, err_msg=name
            )


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    """Folder of an uninterrupted run."""
    folder = tmp_path_factory.mktemp("whole")
    done = processed("run", str(SLIDE), "--out", str(folder), *settings(*STEPS))
    assert done.returncode == 0, done.stderr
    return folder


def wait_for(path: Path, process: subprocess.Popen[str]) -> None:
    deadline = time.monotonic() + 60
    while not path.exists() and process.poll() is None:
        assert time.monotonic() < deadline
        time.sleep(0.005)


@pytest.mark.parametrize("kills", [3, pytest.param(20, marks=pytest.mark.slow)])
def test_killed_at_random_moments(whole, tmp_path, kills):
    """Without warning, also while it starts again or writes; every time it goes on."""
    chance = random.Random(kills)
    done, folder = 0, tmp_path / "0"
    verb = "run"
    while done < kills:
        process = started(verb, folder)
        wait_for(folder / "checkpoint.npz", process)
        try:
            process.wait(chance.uniform(0.0, 3.0))
        except subprocess.TimeoutExpired:
            process.kill()
            done += 1
        out, err = process.communicate()
        assert process.returncode in (-signal.SIGKILL, 0), out + err
        verb = "resume"
        if process.returncode == 0:
            assert_same_history(folder, whole)
            folder, verb = tmp_path / str(done), "run"
    if verb == "resume":
        finished = processed("resume", str(folder))
        assert finished.returncode == 0, finished.stderr
        assert_same_history(folder, whole)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_stopped_by_a_signal(whole, tmp_path, number):
    """It ends the step, says what to do in one line, and goes on from there."""
    process = started("run", tmp_path)
    wait_for(tmp_path / "checkpoint.npz", process)
    process.send_signal(number)
    _, err = process.communicate(timeout=60)
    assert process.returncode == ExitCode.INTERRUPTED
    first, second = err.splitlines()
    assert first.startswith(f"{number.name}: finishing this step")
    assert second.startswith(f"{tmp_path}: stopped after step ")
    assert second.endswith(f"; 'contactfem resume {tmp_path}' goes on from there")
    assert not (tmp_path / "summary.json").exists()
    resumed = processed("resume", str(tmp_path))
    assert resumed.returncode == 0 and resumed.stdout.startswith(f"{tmp_path}: resumed after step ")
    assert_same_history(tmp_path, whole)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert len(summary["steps"]) == 50
    assert summary["command"].endswith(f"; contactfem resume {tmp_path}")
    idle = processed("resume", str(tmp_path))
    assert idle.returncode == 0
    assert idle.stdout == f"{tmp_path}: the run has come to its end; there is nothing to do\n"


def test_a_second_signal_ends_it_at_once(tmp_path):
    process = started("run", tmp_path)
    wait_for(tmp_path / "checkpoint.npz", process)
    process.send_signal(signal.SIGTERM)
    assert process.stderr is not None
    assert process.stderr.readline().startswith("SIGTERM: finishing")
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=60)
    assert process.returncode in (-signal.SIGTERM, ExitCode.INTERRUPTED)


def test_one_rank_of_two_is_told_to_stop(whole, tmp_path):
    """All ranks agree; mpirun passes SIGUSR1 on. Then one rank goes on alone."""
    where = ["--out", str(tmp_path), *settings(*STEPS)]
    process = subprocess.Popen(
        ["mpirun", "-n", "2", *command("run", str(SLIDE), *where)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT,
    )  # fmt: skip
    wait_for(tmp_path / "checkpoint.npz", process)
    os.kill(process.pid, signal.SIGUSR1)
    _, err = process.communicate(timeout=60)
    assert process.returncode == ExitCode.INTERRUPTED
    assert err.count("stopped after step") == 1
    assert processed("resume", str(tmp_path)).returncode == 0
    assert_same_history(tmp_path, whole)
