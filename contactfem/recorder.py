"""What a run says and writes while it goes: terminal, tables and field files."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Self

from mpi4py import MPI

from contactfem.case import Case
from contactfem.discretise import Discretisation
from contactfem.gathering import interface_tables
from contactfem.results import RunResult, StepReport
from contactfem.state import State
from contactfem.timers import Timers

if TYPE_CHECKING:
    from contactfem.fields import FieldWriter, HeatFieldWriter
    from contactfem.output import OutputWriter
    from contactfem.terminal import Reporter


class Recorder:
    """Writes the results of a run into its folder, as far as the case asks for them.

    Args:
        case: The case.
        comm: All ranks.
        out: Folder, None to write nothing.
        discretisation: Bodies and interfaces.
        timers: Where time is booked.
        command: The command that repeats the run.
    """

    def __init__(
        self,
        case: Case,
        comm: MPI.Comm,
        out: Path | None,
        discretisation: Discretisation,
        timers: Timers,
        command: str,
    ) -> None:
        self._case, self._discretisation, self._timers = case, discretisation, timers
        self._times = list(case.output.times)
        self._out, self._segment = out, 1
        self._fields: FieldWriter | None = None
        self._heat_fields: HeatFieldWriter | None = None
        self._writer: OutputWriter | None = None
        self._voice: Reporter | None = None
        if out is None:
            return
        with timers.book("output"):
            if comm.rank == 0:
                from contactfem.check import account
                from contactfem.output import OutputWriter
                from contactfem.terminal import Reporter

                self._writer = OutputWriter(out, case, command, account(case))
                self._voice = Reporter(case, bar=comm.size == 1)
            if case.output.fields:
                comm.barrier()  # the folder is there
                self._open_fields(out)

    def _open_fields(self, out: Path) -> None:
        """Open the field files of the present meshes; collective."""
        from contactfem.fields import FieldWriter, HeatFieldWriter

        suffix = f"_{self._segment}" if self._segment > 1 else ""
        discretisation = self._discretisation
        displacements = {name: body.displacement for name, body in discretisation.bodies.items()}
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
        for files in (self._fields, self._heat_fields):
            if files is not None:
                files.close()

    def step(self, report: StepReport, state: State) -> None:
        """Record an accepted step; collective."""
        with self._timers.book("output"):
            if self._writer is not None:
                self._writer.step(report)
            if self._voice is not None:
                self._voice.step(report)
            if self._times and report.t >= self._times[0] * (1.0 - 1e-12):
                self._times.pop(0)
                tables = interface_tables(self._discretisation, state)
                if self._writer is not None:
                    self._writer.interfaces(tables, report.t)
            if self._fields is not None:
                stress = {
                    name: body.cell_stress() for name, body in self._discretisation.bodies.items()
                }
                self._fields.write(report.t, stress)
            if self._heat_fields is not None:
                self._heat_fields.write(report.t)

    def remeshed(self, discretisation: Discretisation) -> None:
        """Go on with new meshes, whose fields go into new files; collective."""
        self._discretisation = discretisation
        for files in (self._fields, self._heat_fields):
            if files is not None:
                files.close()
        self._segment += 1
        if self._fields is not None and self._out is not None:
            with self._timers.book("output"):
                self._open_fields(self._out)

    def failure(self, t: float, reason: str, dt: float) -> None:
        """Say that the step to a time t [s] failed, why, and with which step dt [s] it goes on."""
        if self._writer is not None:
            from contactfem.output import Failure

            self._writer.failure(Failure(t, reason, dt))
        if self._voice is not None:
            self._voice.say(f"step to t = {t:g} s failed: {reason}; again with {dt:g} s")

    def warning(self, text: str) -> None:
        """Say what is doubtful about a step that is accepted."""
        if self._voice is not None:
            self._voice.say(f"WARNING: {text}")

    def finish(self, result: RunResult) -> None:
        """Write the end of the run, on the first rank."""
        if self._writer is not None:
            self._writer.finish(result)
