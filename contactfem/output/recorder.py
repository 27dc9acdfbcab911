"""Output of a run while it goes: terminal, tables, fields."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Self

from mpi4py import MPI

from contactfem.case.schema import Case
from contactfem.checkpoint.format import Progress
from contactfem.common.timers import Timers
from contactfem.discretisation.discretise import Discretisation
from contactfem.discretisation.state import State
from contactfem.errors import WriteError
from contactfem.output.figures.frames import Snapshot, clear_snapshots, write_snapshot
from contactfem.output.gather import body_pictures, heat_pictures, interface_tables
from contactfem.results.data import Failure, MeshErrors, RunResult, StepReport

if TYPE_CHECKING:
    from contactfem.audit.look import AuditState
    from contactfem.output.field_file import FieldFile
    from contactfem.output.fields import FieldWriter, HeatFieldWriter
    from contactfem.output.figures.painter import Painter
    from contactfem.output.terminal import Reporter
    from contactfem.output.writer import OutputWriter

OnStep = Callable[[StepReport, Discretisation, State], object]


class Recorder:
    """Writes the results of a run into its folder, as far as the case asks for them.

    Attributes:
        failures: Steps that failed so far.
        segment: Number of the field files: new meshes, and a run that is resumed, begin others.

    Args:
        case: The case.
        comm: All ranks.
        out: Folder, None to write nothing.
        discretisation: Bodies and interfaces.
        timers: Where time is booked.
        command: The command that repeats the run.
        resumed: How far the run had come, if it is not a new one.
        on_step: Called on all ranks after every accepted step.
    """

    def __init__(
        self,
        case: Case,
        comm: MPI.Comm,
        out: Path | None,
        discretisation: Discretisation,
        timers: Timers,
        command: str,
        resumed: Progress | None,
        on_step: OnStep | None = None,
    ) -> None:
        self._case, self._discretisation, self._timers = case, discretisation, timers
        steps = None if resumed is None else resumed.recorded
        last = steps[-1].t if steps else 0.0
        self._times = [t for t in case.output.times if not _reached(t, last)]
        self._out, self._on_step = out, on_step
        self.segment = 1 if resumed is None else resumed.segment + 1
        self.failures = [] if resumed is None else list(resumed.failures)
        every = case.time.end / max(case.output.snapshots, 1)
        moments = [every * (k + 1) for k in range(case.output.snapshots)]
        self._moments = [t for t in moments if not _reached(t, last)]
        self._pictures = len(moments) - len(self._moments)
        self._field_file: FieldFile | None = None
        self._fields: FieldWriter | None = None
        self._heat_fields: HeatFieldWriter | None = None
        self._writer: OutputWriter | None = None
        self._voice: Reporter | None = None
        self._painter: Painter | None = None
        if out is None:
            return
        with timers.book("output"):
            if comm.rank == 0:
                from contactfem.check.check import account
                from contactfem.output.terminal import Reporter
                from contactfem.output.writer import OutputWriter

                draw = None
                if case.output.figures:
                    from contactfem.output.figures.painter import Painter

                    self._painter = Painter()
                    draw = self._painter.draw
                self._writer = OutputWriter(out, case, command, account(case), steps, draw)
                if steps is None:
                    clear_snapshots(out)
                self._voice = Reporter(case, bar=comm.size == 1)
                for failure in self.failures:
                    self._writer.failure(failure)
                self._clear_fields(out)
            comm.barrier()  # the folder is there
            if case.output.fields == "vtkhdf":
                from contactfem.output.field_file import FieldFile

                self._field_file = FieldFile(case, comm, out, None if steps is None else last)
            self._open_fields(out)

    def _clear_fields(self, out: Path) -> None:
        """Remove the field files of an earlier run, or of what a resumed one does again."""
        if self._case.output.fields == "vtx":
            from contactfem.output.fields import remove_later

            names = [*self._case.bodies, *(f"{name}_heat" for name in self._case.bodies)]
            remove_later(out, names, max(self.segment, 2))

    def _open_fields(self, out: Path) -> None:
        """Open the field files of the present meshes where a file is for one mesh; collective."""
        if self._case.output.fields != "vtx":
            return
        from contactfem.output.fields import FieldWriter, HeatFieldWriter

        suffix = f"_{self.segment}" if self.segment > 1 else ""
        discretisation = self._discretisation
        if self._case.mechanics:
            displacements = {name: b.displacement for name, b in discretisation.bodies.items()}
            self._fields = FieldWriter(out, displacements, suffix)
        if discretisation.heat is not None:
            self._heat_fields = HeatFieldWriter(out, discretisation.heat.bodies, suffix)

    def __enter__(self) -> Self:
        """Open for the time of a run."""
        if self._voice is not None:
            self._voice.__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the field files and leave the terminal in order."""
        if self._voice is not None:
            self._voice.__exit__(kind, error, trace)
        for files in (self._fields, self._heat_fields, self._painter):
            if files is not None:
                files.close()

    def step(self, report: StepReport, state: State, errors: Sequence[MeshErrors] = ()) -> None:
        """Record an accepted step; collective.

        Args:
            report: The step.
            state: The state at its end.
            errors: Errors of the cells, where meshes adapt.

        Raises:
            WriteError: That cannot be done, on the first rank.
        """
        with self._timers.book("output"), self._writing():
            if self._writer is not None:
                self._writer.step(report)
            if self._voice is not None:
                self._voice.step(report)
            if self._times and _reached(self._times[0], report.t):
                self._times.pop(0)
                tables = interface_tables(self._discretisation, state)
                if self._writer is not None:
                    self._writer.interfaces(tables, report.t)
            self._picture(report.t, state)
            if self._field_file is not None:
                self._field_file.write(report.t, self._discretisation, state, errors)
            if self._fields is not None:
                stress = {
                    name: body.cell_stress() for name, body in self._discretisation.bodies.items()
                }
                self._fields.write(report.t, stress)
            if self._heat_fields is not None:
                self._heat_fields.write(report.t)
        if self._on_step is not None:
            self._on_step(report, self._discretisation, state)

    def _picture(self, t: float, state: State) -> None:
        """Write a snapshot if one is due at a time [s]; collective."""
        due = [moment for moment in self._moments if moment <= t * (1.0 + 1e-12)]
        if not due or self._out is None:
            return
        self._moments = self._moments[len(due) :]
        bodies = body_pictures(self._discretisation)
        heat = heat_pictures(self._discretisation, state)
        if bodies:
            self._pictures += 1
            write_snapshot(self._out, self._pictures, Snapshot(t, tuple(bodies), tuple(heat)))

    def remeshed(self, discretisation: Discretisation) -> None:
        """Go on with new meshes, whose fields go into new files; collective."""
        self._discretisation = discretisation
        for files in (self._fields, self._heat_fields):
            if files is not None:
                files.close()
        self.segment += 1
        if self._out is not None:
            with self._timers.book("output"):
                self._open_fields(self._out)

    def failure(self, t: float, reason: str, dt: float) -> None:
        """Say that the step to a time t [s] failed, why, and with which step dt [s] it goes on."""
        self.failures.append(Failure(t, reason, dt))
        if self._writer is not None:
            self._writer.failure(self.failures[-1])
        if self._voice is not None:
            self._voice.say(f"step to t = {t:g} s failed: {reason}; again with {dt:g} s")

    def warning(self, text: str) -> None:
        """Say what is doubtful though the run goes on."""
        if self._voice is not None:
            self._voice.say(f"WARNING: {text}")

    def state(self, state: AuditState | None) -> None:
        """Write the last accepted state, on the first rank, to be looked at again.

        Args:
            state: The state; None where there is none.

        Raises:
            WriteError: That cannot be done.
        """
        if self._out is not None and state is not None:
            from contactfem.audit.files import write_state

            with self._timers.book("output"), self._writing():
                write_state(self._out, state)

    def finish(self, result: RunResult) -> None:
        """Write the end of the run, on the first rank.

        Raises:
            WriteError: That cannot be done.
        """
        if self._writer is not None:
            with self._writing():
                self._writer.finish(result)

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Say in one line that there is no room or no permission left."""
        try:
            yield
        except OSError as error:
            place = error.filename or self._out
            raise WriteError(f"{place}: cannot be written: {error.strerror}") from None


def _reached(time: float, t: float) -> bool:
    """Whether a time is reached at t, but for round-off."""
    return t >= time * (1.0 - 1e-12)
