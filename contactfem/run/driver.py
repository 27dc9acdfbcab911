"""`run_case`: set up, step, gather the result."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from mpi4py import MPI

from contactfem.case.body_meshes import mesh_remarks
from contactfem.case.schema import Case
from contactfem.check.side_summary import stiff_and_fine
from contactfem.checkpoint.checkpointer import Checkpointer
from contactfem.checkpoint.format import NAME, Checkpoint, Origin, intact
from contactfem.checkpoint.state_io import meshes
from contactfem.common.text import about
from contactfem.common.timers import Timers
from contactfem.discretisation.discretise import Discretisation, discretise
from contactfem.discretisation.state import State
from contactfem.fem.form_cache import compiling
from contactfem.fem.petsc_options import HEAT, MECHANICS, available, forget
from contactfem.geometry.side_comparison import Facets
from contactfem.output.folder_lock import locked
from contactfem.output.recorder import OnStep, Recorder
from contactfem.results.data import RunResult
from contactfem.run.loop_parts import newton_solver
from contactfem.run.result import outcome
from contactfem.run.time_loop import Loop


@dataclass(frozen=True)
class Invocation:
    """How a run was started.

    Attributes:
        command: The command that repeats it.
        import_seconds: What imports took before it [s].
        asked: Whether this process is asked to stop.
    """

    command: str
    import_seconds: float
    asked: Callable[[], bool] = bool


@dataclass(frozen=True)
class Solved:
    """Result of a run and what it was found on.

    Attributes:
        result: The result.
        discretisation: The equations on their last meshes.
        state: The last good state.
    """

    result: RunResult
    discretisation: Discretisation
    state: State


def run_case(
    case: Case,
    comm: MPI.Comm,
    out: Path | None,
    invocation: Invocation | None = None,
    resumed: Checkpoint | None = None,
) -> RunResult:
    """Solve a case; collective. Arguments and errors as for `solve_case`.

    Returns:
        Its result.
    """
    return solve_case(case, comm, out, invocation, resumed).result


def solve_case(
    case: Case,
    comm: MPI.Comm,
    out: Path | None,
    invocation: Invocation | None = None,
    resumed: Checkpoint | None = None,
    on_step: OnStep | None = None,
) -> Solved:
    """Solve a case from time zero, or from a checkpoint, to its end; collective.

    Args:
        case: The case.
        comm: All ranks.
        out: Folder for the results, None to write nothing.
        invocation: How it was started, from the command line.
        resumed: Where to go on from; its state only counts on the first rank.
        on_step: Called on all ranks after every accepted step.

    Returns:
        The results, with the equations they belong to; pictures and probes on the first rank only.
        If the solver gave up they are those of the last good state, with the reason in `message`.

    Raises:
        CaseError: The case does not fit its meshes.
        Interrupted: The run was asked to stop, and its state is written.
        WriteError: Results cannot be written.
    """
    invocation = invocation or Invocation(f"contactfem run {case.path}", 0.0)
    with about(case.path), locked(out, comm):
        try:
            return _run(case, comm, out, invocation, resumed, on_step)
        finally:
            forget(MECHANICS, HEAT)


def _run(
    case: Case,
    comm: MPI.Comm,
    out: Path | None,
    invocation: Invocation,
    resumed: Checkpoint | None,
    on_step: OnStep | None,
) -> Solved:
    """Solve a case or the rest of it; collective."""
    before = dict(resumed.seconds) if resumed is not None else {}
    start = time.perf_counter() - invocation.import_seconds - before.pop("total", 0.0)
    timers = Timers()
    for phase, seconds in (*before.items(), ("import", invocation.import_seconds)):
        timers.add(phase, seconds)
    progress = resumed.progress if resumed is not None else None
    case, notes = _with_available_solvers(case)
    with compiling(comm):
        given = None
        if resumed is not None:
            with intact(str(out / NAME) if out is not None else resumed.origin.path):
                given = meshes(resumed.state)
        discretisation = discretise(case, comm, timers, given)
        solver = newton_solver(case, discretisation, timers) if case.mechanics else None
        origin = Origin(str(case.path.absolute()), case.contents, invocation.command)
        keeper = Checkpointer(case, comm, out, origin, timers, start, invocation.asked)
        recorder = Recorder(
            case, comm, out, discretisation, timers, origin.command, progress, on_step
        )
        with recorder:
            for note in notes:
                recorder.warning(note)
            loop = Loop(case, discretisation, solver, recorder, keeper, timers, progress)
            if resumed is not None:
                with intact(resumed.origin.path if out is None else str(out / NAME)):
                    loop.restore(resumed)
            else:
                for text in (*_mesh_doubts(case, comm), *_side_doubts(case, discretisation)):
                    loop.warn(text)
            message = loop.run()
            loop.flush()
            last = loop.discretisation, loop.state, loop.progress()
            result = outcome(case, *last, timers, start, message)
            if loop.adaptation is not None:
                first, present = loop.adaptation.first_meshes, loop.adaptation.last_meshes
                result = replace(result, first_meshes=first, last_meshes=present)
            result = replace(result, wrong=loop.wrong)
            if loop.verification is not None:
                recorder.state(loop.verification.last)
            recorder.finish(result)
    return Solved(result, loop.discretisation, loop.state)


def _with_available_solvers(case: Case) -> tuple[Case, list[str]]:
    """The case with linear solvers that this PETSc has, and what is said of others."""
    options, note = available(case.solver.petsc, "solver.petsc")
    changes: dict[str, object] = {"solver": case.solver.model_copy(update={"petsc": options})}
    notes = [note]
    if case.heat is not None:
        options, note = available(case.heat.petsc, "heat.petsc")
        changes["heat"] = case.heat.model_copy(update={"petsc": options})
        notes.append(note)
    notes = [note for note in notes if note]
    return (case.model_copy(update=changes) if notes else case), notes


def _mesh_doubts(case: Case, comm: MPI.Comm) -> list[str]:
    """What is doubtful about meshes from files, which the first rank has read; collective."""
    doubts = []
    if comm.rank == 0:
        doubts = [f"{where}: {text}" for where, text, doubtful in mesh_remarks(case) if doubtful]
    found: list[str] = comm.bcast(doubts)
    return found


def _side_doubts(case: Case, discretisation: Discretisation) -> Iterator[str]:
    """What is doubtful about the choice of nonmortar sides; the same on all ranks."""
    for interface in discretisation.interfaces:
        sides, mesh = case.interfaces[interface.name], interface.nodes.mesh
        if sides.mortar in case.obstacles:
            continue
        tensor = [0, 1] if mesh.dim == 2 else [0, 1, 3, 2]
        first, second = (Facets(mesh.X, f[:, tensor]) for f in (mesh.nonmortar, mesh.mortar))
        if text := stiff_and_fine(case, sides, (first, second)):
            yield f"interfaces.{interface.name}: {text}"
