"""One run in its own process, to measure time and memory."""

from __future__ import annotations

import math
import os
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from contactfem.errors import CaseError, ExitCode
from contactfem.output.tables import SUMMARY, read_summary
from contactfem.study.runs import Member

QUIET = ("output.fields=false", "output.figures=false", "expect=false")
ASIDE = ("import", "jit", "output")  # phases that are not the price of an answer
PAUSE = 0.02  # seconds between two looks at the process
GRACE = 5.0  # seconds that a process has to end by itself
OUTPUT, ERRORS = "output.log", "errors.log"
KIBIBYTE = 1024.0  # the unit of ru_maxrss on Linux


@dataclass(frozen=True)
class Outcome:
    """What became of a run.

    Attributes:
        message: why there is no answer, else empty.
        values: measured numbers by name [SI]; those that were not finite are NaN.
        unknowns: displacements, if solved for, and temperatures.
        steps: accepted steps.
        iterations: Newton iterations of these.
        timings: seconds per phase [s].
        wall: from the start of the process to its end [s].
        memory: largest resident memory of one of its processes [bytes].
    """

    message: str
    values: Mapping[str, float] = field(default_factory=dict)
    unknowns: int = 0
    steps: int = 0
    iterations: int = 0
    timings: Mapping[str, float] = field(default_factory=dict)
    wall: float = math.nan
    memory: float = math.nan

    @property
    def seconds(self) -> float:
        """Wall time without imports, compilation of forms and output [s]."""
        aside = sum(self.timings.get(phase, 0.0) for phase in ASIDE)
        return self.timings.get("total", math.nan) - aside


def words_of(member: Member, path: Path, out: Path) -> list[str]:
    """Arguments of contactfem that make a run, which is not judged: what is varied may not fit."""
    words = ["run", str(path), "--out", str(out)]
    if member.curve.variant is not None:
        words += ["--variant", member.curve.variant]
    for text in (*member.overrides, *QUIET):
        words += ["--set", text]
    return words


def command_of(member: Member, path: Path, out: Path) -> str:
    """The command that repeats a run, for people."""
    ranks = ["mpirun", "-n", str(member.curve.ranks)] if member.curve.ranks > 1 else []
    return shlex.join([*ranks, "contactfem", *words_of(member, path, out)])


def run_member(member: Member, path: Path, out: Path, patience: float) -> Outcome:
    """Run one member of a family and wait for it.

    Args:
        member: the run.
        path: the case file.
        out: folder for its results, made if missing.
        patience: seconds after which it is stopped [s].

    Returns:
        What became of it; a run that fails says why.
    """
    if member.problem:
        return Outcome(member.problem)
    out.mkdir(parents=True, exist_ok=True)
    (out / SUMMARY).unlink(missing_ok=True)  # of an earlier study; a failed run must not show it
    ranks = ["mpirun", "-n", str(member.curve.ranks)] if member.curve.ranks > 1 else []
    words = [*ranks, sys.executable, "-m", "contactfem", *words_of(member, path, out)]
    code, wall, memory = _watched(words, out, patience)
    if code is None:
        return Outcome(f"stopped after {patience:g} s", wall=wall, memory=memory)
    if code not in (ExitCode.DONE, ExitCode.GAVE_UP):
        return Outcome(_reason(out / ERRORS, code), wall=wall, memory=memory)
    try:
        summary = read_summary(out)
    except CaseError:
        return Outcome(_reason(out / ERRORS, code), wall=wall, memory=memory)
    return _outcome(summary, member.mechanics, wall, memory)


def _watched(words: Sequence[str], out: Path, patience: float) -> tuple[int | None, float, float]:
    """Exit code (None if it had to be stopped), wall time [s] and memory [bytes] of a process."""
    start, limits = (
        time.perf_counter(),
        [(patience, signal.SIGTERM), (patience + GRACE, signal.SIGKILL)],
    )
    with (out / OUTPUT).open("w") as output, (out / ERRORS).open("w") as errors:
        process = subprocess.Popen(  # in a group of its own, to be stopped with all that it started
            words, stdin=subprocess.DEVNULL, stdout=output, stderr=errors, start_new_session=True
        )
        try:
            while not (memory := _reaped(process)):
                if limits and time.perf_counter() - start > limits[0][0]:
                    os.killpg(process.pid, limits.pop(0)[1])
                time.sleep(PAUSE)
        except BaseException:
            _end(process)
            raise
    code = process.returncode if len(limits) == 2 else None
    return code, time.perf_counter() - start, memory * KIBIBYTE


def _reaped(process: subprocess.Popen[bytes]) -> int:
    """Largest memory of a process and those that it waited for [KiB]; 0 while it runs."""
    pid, status, usage = os.wait4(process.pid, os.WNOHANG)
    if not pid:
        return 0
    process.returncode = os.waitstatus_to_exitcode(status)
    return usage.ru_maxrss


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a process: mpirun ends its ranks when it is asked to, but not when it is killed."""
    os.killpg(process.pid, signal.SIGTERM)
    try:
        process.wait(GRACE)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _reason(errors: Path, code: int) -> str:
    """The last thing that a run said before it failed, without what mpirun adds."""
    said = errors.read_text(errors="replace").partition("\n-----")[0].strip().splitlines()
    return said[-1] if said else f"ended with code {code}"


def _outcome(summary: Mapping[str, Any], mechanics: bool, wall: float, memory: float) -> Outcome:
    """What the summary of a run says."""
    sizes, values = summary["sizes"], summary["values"]
    displacements = sizes["unknowns"] if mechanics else 0
    return Outcome(
        message="" if summary["converged"] else str(summary["message"]),
        values={k: math.nan if v is None else float(v) for k, v in values.items()},
        unknowns=displacements + sizes.get("temperatures", 0),
        steps=len(summary["steps"]),
        iterations=summary["newton_iterations"],
        timings=summary["timings"],
        wall=wall,
        memory=memory,
    )
