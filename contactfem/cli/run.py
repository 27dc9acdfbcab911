"""`contactfem run` and `contactfem resume`."""

import shlex
import sys
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from mpi4py import MPI

from contactfem.case.body_meshes import mesh_remarks
from contactfem.case.python_code import refuse_code
from contactfem.case.read import read_case
from contactfem.case.schema import Case
from contactfem.check.check import check_bodies, describe
from contactfem.checkpoint.format import Checkpoint
from contactfem.common.text import one_line, printable
from contactfem.common.timers import seconds_since_start
from contactfem.errors import ContactfemError, ExitCode
from contactfem.results.expectations import check_names
from contactfem.run.resume import Resumption, prepare
from contactfem.run.signals import StopSignals

PATIENCE = 10.0  # seconds that a rank which failed waits for the others to fail as well


def run_command(
    path: Path,
    overrides: Sequence[str],
    variant: str | None,
    out: Path | None,
    *,
    no_code: bool = False,
) -> int:
    """Run a case, one of its variants, or with "all" the case and all of its variants.

    Args:
        path: the case file.
        overrides: "a.b.c=value" each.
        variant: a variant's name, "all", or None for the case itself.
        out: folder to write to; None for runs/CASE[-VARIANT].
        no_code: whether a case that runs Python of its own is refused.

    Returns:
        The largest exit code, the same on all ranks.
    """
    return _guarded(lambda comm: _run_all(comm, path, overrides, variant, out, no_code))


def resume_command(folder: Path, overrides: Sequence[str], *, no_code: bool = False) -> int:
    """Go on with a run that was stopped, killed or given up.

    Args:
        folder: its folder.
        overrides: "a.b.c=value" each, of how it is solved and written.
        no_code: whether a case that runs Python of its own is refused.

    Returns:
        Exit code, the same on all ranks.
    """
    return _guarded(lambda comm: _resume(comm, folder, overrides, no_code))


def _guarded(command: Callable[[MPI.Comm], int]) -> int:
    """Exit code of a command, or of the error that it ends with, which is said once."""
    comm = MPI.COMM_WORLD
    failures = comm.Dup()  # its traffic cannot be mistaken for that of the computation
    try:
        return command(comm)
    except ContactfemError as error:
        if comm.rank == 0:
            print(printable(error), file=sys.stderr, flush=True)
        if not _all_here(failures):
            if comm.rank:
                print(f"rank {comm.rank}: {printable(error)}", file=sys.stderr, flush=True)
            comm.Abort(error.exit_code)
        return error.exit_code
    except Exception:
        print(f"rank {comm.rank}: {traceback.format_exc()}", file=sys.stderr, flush=True)
        if comm.size > 1:
            comm.Abort(ExitCode.BUG)  # the other ranks wait for this one and would do so for ever
        return ExitCode.BUG


def _all_here(comm: MPI.Comm) -> bool:
    """Whether all ranks come here within a while."""
    request = comm.Ibarrier()
    deadline = time.monotonic() + PATIENCE
    while not (done := bool(request.Test())) and time.monotonic() < deadline:
        time.sleep(0.01)
    return done


def _run_all(
    comm: MPI.Comm,
    path: Path,
    overrides: Sequence[str],
    variant: str | None,
    out: Path | None,
    no_code: bool,
) -> int:
    if variant != "all":
        return _run_one(
            comm, _read(comm, path, overrides, variant, no_code), _folder(path, variant, out)
        )
    base = _read(comm, path, overrides, None, no_code)
    codes = []
    for name in (None, *base.variants):
        case = _read(comm, path, overrides, name, no_code)
        folder = _folder(path, name, out and out / _stem(path, name))
        codes.append(_run_one(comm, case, folder, first=name is None))
    return max(codes)


def _stem(path: Path, variant: str | None) -> str:
    return f"{path.stem}-{variant}" if variant else path.stem


def _folder(path: Path, variant: str | None, out: Path | None) -> Path:
    return out if out is not None else Path("runs") / _stem(path, variant)


def _read(
    comm: MPI.Comm, path: Path, overrides: Sequence[str], variant: str | None, no_code: bool
) -> Case:
    """Read on rank 0, so that all ranks see the same file.

    Raises:
        CaseError: on all ranks alike.
    """

    def found() -> Case:
        case = read_case(path, overrides, variant)
        if no_code:
            refuse_code(case)
        check_names(case)
        check_bodies(case)
        return case

    return _on_first(comm, found)


def _on_first[T](comm: MPI.Comm, work: Callable[[], T]) -> T:
    """What work gives on rank 0, on all ranks; collective.

    Raises:
        ContactfemError: that of rank 0, on all ranks alike.
    """
    answer: T | ContactfemError | None = None
    if comm.rank == 0:
        try:
            answer = work()
        except ContactfemError as error:
            answer = error
    answer = comm.bcast(answer)
    if isinstance(answer, ContactfemError):
        raise answer
    return answer  # type: ignore[return-value]


def _resume(comm: MPI.Comm, folder: Path, overrides: Sequence[str], no_code: bool) -> int:
    """Go on with a run; its state stays on rank 0."""
    state: dict[str, Any] = {}

    def found() -> Resumption:
        resumption = prepare(folder, overrides)
        if resumption.checkpoint is not None:
            state.update(resumption.checkpoint.state)
            return replace(resumption, checkpoint=replace(resumption.checkpoint, state={}))
        return resumption

    resumption = _on_first(comm, found)
    if comm.rank == 0:
        print(printable(resumption.says), flush=True)
    if resumption.case is None or resumption.checkpoint is None:
        return ExitCode.DONE
    checkpoint = replace(resumption.checkpoint, state=state)
    if no_code:
        refuse_code(resumption.case)
    return _run_one(comm, resumption.case, folder, checkpoint=checkpoint)


def _run_one(
    comm: MPI.Comm,
    case: Case,
    out: Path,
    first: bool = True,
    checkpoint: Checkpoint | None = None,
) -> int:
    """Run one case and say how it went; the first one also pays for the imports."""
    from contactfem.run.driver import Invocation, run_case

    if comm.rank == 0:
        print(describe(case), flush=True)
        for where, text, doubtful in mesh_remarks(case) if checkpoint is None else ():
            if not doubtful:  # doubts are said by the run itself
                print(one_line(f"{where}: {text}"), flush=True)
    imports = seconds_since_start() if first else 0.0
    command = _command(comm)
    if checkpoint is not None:
        command = f"{checkpoint.origin.command}; {command}"
    with StopSignals(tell=comm.rank == 0) as asked:
        result = run_case(case, comm, out, Invocation(command, imports, asked), checkpoint)
    passed = True
    if comm.rank == 0:
        passed = _closing(out, plain=comm.size > 1)
        if result.message:
            print(printable(result.message), file=sys.stderr, flush=True)
    passed = bool(comm.bcast(passed))
    if not result.converged:
        return ExitCode.WRONG if result.wrong else ExitCode.GAVE_UP
    return ExitCode.DONE if passed else ExitCode.MISSED


def _command(comm: MPI.Comm) -> str:
    """The command line that was given, as it can be given again."""
    words = shlex.join(["contactfem", *sys.argv[1:]])
    return words if comm.size == 1 else f"mpirun -n {comm.size} {words}"


def _closing(out: Path, *, plain: bool) -> bool:
    """Print what was expected and what came; whether all expectations are met.

    mpirun shows a terminal even where there is none, so colour would get into files: `plain`.
    """
    from contactfem.output.report.report import verdict_lines
    from contactfem.output.tables import read_summary

    summary = read_summary(out)
    for line in verdict_lines(summary, colour=not plain and sys.stdout.isatty()):
        print(line)
    print(f"results in {out}", flush=True)
    return all(verdict["passed"] for verdict in summary["verdicts"])
