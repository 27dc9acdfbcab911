"""Terminal output of a run: one line a step."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, TextIO

from contactfem.common.text import percent
from contactfem.common.unit_display import engineering
from contactfem.results.data import Observables, StepReport

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

    from contactfem.case.schema import Case


SILENCE = 20.0  # seconds between two estimates of what is left


def step_line(report: StepReport, force_unit: str = "N/m") -> str:
    """Say in one line how a step went.

    Args:
        report: the step.
        force_unit: SI unit of its forces.

    Returns:
        The line.
    """
    forces = _forces(report.forces, force_unit)
    cuts = f"  cut-backs {report.cutbacks}" if report.cutbacks else ""
    nodes = report.open + report.stick + report.slip
    status = f"open {report.open}  stick {report.stick}  slip {report.slip}  " if nodes else ""
    newton = f"iterations {report.iterations:2d}  " if report.residuals else ""
    head = f"step {report.step:4d}  t = {engineering(report.t, 's', 4)}  "
    return f"{head}{newton}{status}{forces}{_heat(report)}{_errors(report)}{cuts}".rstrip()


def _forces(forces: Mapping[str, tuple[float, ...]], unit: str) -> str:
    """All components of the force of every interface."""
    return "  ".join(
        f"{name} ({', '.join(engineering(part, unit, 4) for part in force)})"
        for name, force in forces.items()
    )


def _errors(report: StepReport) -> str:
    """Estimated errors of a step, and how often it was taken again for them."""
    if report.errors is None:
        return ""
    found = {name: getattr(report.errors, name) for name in ("mechanics", "heat", "time")}
    parts = [f"{name} {percent(eta, 2)}" for name, eta in found.items() if eta is not None]
    again = f"  taken {report.errors.repeats + 1} times" if report.errors.repeats else ""
    return (f"  errors: {', '.join(parts)}" if parts else "") + again


def remesh_lines(report: StepReport, force_unit: str = "N/m") -> list[str]:
    """Say in a line for each problem which new meshes were made for a step, and what they changed.

    Args:
        report: the step.
        force_unit: SI unit of its forces.

    Returns:
        The lines.
    """
    new = report.errors.remeshes if report.errors is not None else ()
    lines: dict[tuple[str, float, str], list[str]] = {}
    for one in new:
        cells = f"{one.body} {one.cells_before} to {one.cells_after} cells"
        lines.setdefault((one.problem, one.seconds, one.reason), []).append(cells)
    change = report.errors.change if report.errors is not None else None
    return [
        f"new meshes for {problem} in {seconds:.2g} s: {', '.join(cells)}"
        + (f" ({reason})" if reason else "")
        for (problem, seconds, reason), cells in lines.items()
    ] + ([f"they change {text}"] if change and (text := _change(change, force_unit)) else [])


def _change(change: Observables, force_unit: str) -> str:
    """What new meshes changed of a step."""
    heat = {"hottest": change.temperature_max, "mean temperature": change.temperature_mean}
    parts = [_forces(change.forces, force_unit)]
    parts += [f"{name} {value:.3g} K" for name, value in heat.items() if value is not None]
    return "  ".join(part for part in parts if part)


def _heat(report: StepReport) -> str:
    """Temperatures and passes of a step, and whether the time scheme rings."""
    if report.heat is None:
        return ""
    heat = report.heat
    passes = f", {heat.passes} passes" if heat.passes > 1 else ""
    return f"  {heat.temperature_min:.5g} to {heat.temperature_max:.5g} K{passes}"


def duration(seconds: float) -> str:
    """A time that is only known roughly, in words.

    Args:
        seconds: the time [s].

    Returns:
        For instance "40 s", "12 min" or "3.5 h".
    """
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"


class Remaining:
    """Says every now and then how long a run may still take, at the pace it had so far."""

    def __init__(self, end: float, clock: Callable[[], float] = time.monotonic) -> None:
        """Start the clock.

        Args:
            end: time at the end of the run [s].
            clock: what the clock shows [s].
        """
        self._end = end
        self._clock = clock
        self._begun = self._said = clock()
        self._first: float | None = None

    def words(self, report: StepReport) -> str:
        """What is left after a step; empty if that was said a short while ago, or nothing is left.

        Args:
            report: the step.

        Returns:
            For instance "  about 12 min left".
        """
        if self._first is None:
            self._first = report.t - report.dt
        now = self._clock()
        left = (self._end - report.t) / (report.t - self._first) * (now - self._begun)
        if now - self._said < SILENCE or left <= 0.0:
            return ""
        self._said = now
        return f"  about {duration(left)} left"


class Reporter:
    """Tells how a run gets on; used as a context, so that the terminal is left in order."""

    def __init__(
        self,
        case: Case,
        stream: TextIO | None = None,
        bar: bool = True,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Prepare; nothing is printed yet.

        Args:
            case: the case that is run.
            stream: where to, standard output by default.
            bar: whether to draw a bar on a terminal; mpirun shows one to rank 0 that is none.
            clock: what the clock shows [s].
        """
        self._bar = bar
        self._end = case.time.end
        self._force_unit = case.force_unit
        self._stream = sys.stdout if stream is None else stream
        self._rang = False
        self._remaining = Remaining(case.time.end, clock)
        self._progress: Progress | None = None
        self._task: TaskID | None = None

    def __enter__(self) -> Reporter:
        """Show the bar if there is a terminal to show it on."""
        if self._bar and self._stream.isatty():
            from rich.console import Console
            from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

            columns = (TextColumn("{task.fields[t]:>10}"), BarColumn(), TimeRemainingColumn())
            console = Console(file=self._stream, highlight=False)
            self._progress = Progress(*columns, console=console, transient=True)
            self._task = self._progress.add_task("", total=self._end, t="t = 0 s")
            self._progress.start()
        return self

    def __exit__(self, *exception: object) -> None:
        """Remove the bar."""
        if self._progress is not None:
            self._progress.stop()

    def say(self, text: str) -> None:
        """Print a line above the bar.

        Args:
            text: the line.
        """
        if self._progress is not None:
            self._progress.console.print(text, markup=False, soft_wrap=True)
        else:
            self._stream.write(f"{text}\n")
            self._stream.flush()

    def step(self, report: StepReport) -> None:
        """Print an accepted step and move the bar.

        Args:
            report: the step.
        """
        for line in remesh_lines(report, self._force_unit):
            self.say(line)
        left = self._remaining.words(report) if self._progress is None else ""
        self.say(step_line(report, self._force_unit) + left)
        rings = report.heat.rings if report.heat is not None else ""
        if rings and not self._rang:
            self.say(f"WARNING: {rings}")
        self._rang = bool(rings)
        if self._progress is not None and self._task is not None:
            now = f"t = {engineering(report.t, 's', 4)}"
            self._progress.update(self._task, completed=report.t, t=now)
