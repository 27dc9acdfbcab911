"""Tables and summary of a run as files."""

from __future__ import annotations

import csv
import io
import json
import math
import os
import platform
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import contactfem
from contactfem.check.check import Account
from contactfem.checkpoint.format import NAME, PREVIOUS
from contactfem.errors import CaseError
from contactfem.results.data import (
    ErrorStep,
    Failure,
    InterfaceTable,
    RunResult,
    Status,
    StepReport,
)
from contactfem.results.error_measures import uniform_costs
from contactfem.results.expectations import Verdict, judge
from contactfem.results.measures import floor_seconds, measure

if TYPE_CHECKING:
    from contactfem.case.schema import Case

SUMMARY, HISTORY, FIGURES = "summary.json", "history.csv", "figures"
STEP_COLUMNS = {
    "step": "step",
    "t": "t [s]",
    "dt": "dt [s]",
    "iterations": "iterations",
    "cutbacks": "cutbacks",
    "open": "open",
    "stick": "stick",
    "slip": "slip",
    "dissipation": "dissipation",
    "wall": "wall [s]",
}
NODE_COLUMNS = {
    "arc": "arc [m]",
    "gap": "gap [m]",
    "pressure": "pressure [Pa]",
    "traction": "traction [Pa]",
    "slip": "slip [m]",
    "status": "status",
    "coverage": "cover",
    "facet_length": "facet_length [m]",
}
HEAT_COLUMNS = {
    "passes": "passes",
    "temperature_min": "temperature_min [K]",
    "temperature_max": "temperature_max [K]",
    "stored": "heat stored",
    "held_sum": "heat held",
    "loads": "heat loads",
    "friction": "heat friction",
    "obstacles": "heat obstacles",
    "strained": "heat strained",
    "defect": "heat defect",
}
ERROR_COLUMNS = ("error.mechanics", "error.heat", "error.time", "cells", "thermal_cells")
SURFACE_HEAT_COLUMNS = {
    "temperature": "temperature [K]",
    "mortar_temperature": "mortar_temperature [K]",
    "flux": "heat_flux [W/m^2]",
    "dissipation": "dissipation [W/m^2]",
}
UNKNOWN = Account()
POSITIONS = ("X [m]", "Y [m]", "x [m]", "y [m]")


def write_whole(path: Path, text: str) -> None:
    """Write a file so that it is there as a whole or not at all.

    Args:
        path: the file; what was there before is replaced.
        text: its content.

    Raises:
        OSError: if it cannot be written.
    """
    draft = path.with_name(f".{path.name}.part")
    try:
        draft.write_text(text, encoding="utf-8")
        os.replace(draft, path)
    except OSError:
        draft.unlink(missing_ok=True)
        raise


def _cell(value: object) -> str:
    return f"{value:.15g}" if isinstance(value, float) else str(value)


def _csv(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([_cell(value) for value in row] for row in rows)
    return text.getvalue()


def interface_csv(table: InterfaceTable) -> str:
    """Table of the nonmortar nodes of an interface, a row each.

    Args:
        table: the interface.

    Returns:
        The text of the file, its header with units.
    """
    columns: list[Sequence[object]] = [
        [float(value) for value in column]
        for column in (*table.X.T, *table.x.T, *(getattr(table, name) for name in NODE_COLUMNS))
    ]
    where = len(POSITIONS) + list(NODE_COLUMNS).index("status")
    columns[where] = [Status(code).name.lower() for code in table.status]
    header = [*POSITIONS, *NODE_COLUMNS.values()]
    if table.heat is not None:
        header += SURFACE_HEAT_COLUMNS.values()
        columns += [[float(v) for v in getattr(table.heat, key)] for key in SURFACE_HEAT_COLUMNS]
    return _csv(header, zip(*columns, strict=True))


def mortar_csv(table: InterfaceTable) -> str:
    """Table of the pressure that the mortar nodes of an interface see.

    Args:
        table: the interface.

    Returns:
        The text of the file, its header with units.
    """
    columns = (*table.mortar_x.T, table.mortar_pressure)
    rows = zip(*([float(value) for value in column] for column in columns), strict=True)
    return _csv(("x [m]", "y [m]", "pressure [Pa]"), rows)


def versions() -> dict[str, str]:
    """Versions of this program and of the libraries that it has loaded.

    Returns:
        Version by name.
    """
    found = {"contactfem": contactfem.__version__, "python": platform.python_version()}
    for name in ("dolfinx", "petsc4py", "mpi4py", "numpy", "gmsh"):
        if name in sys.modules:
            found[name] = str(getattr(sys.modules[name], "__version__", "unknown"))
    return found


def _plain(value: Any) -> Any:
    """Return what JSON can say: null for what is not a finite number."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value


def summarise(
    result: RunResult, values: Mapping[str, float], verdicts: Sequence[Verdict], command: str
) -> dict[str, Any]:
    """Collect the summary of a run.

    Args:
        result: the run.
        values: what was measured on it [SI].
        verdicts: how that was judged.
        command: the command that repeats the run.

    Returns:
        What is written to summary.json.
    """
    ended = result.converged or any(verdict.key == "converged" for verdict in verdicts)
    return {
        "title": result.case.title,
        "case": Path(result.case.path).name,
        "references": result.case.references,
        "command": command,
        "versions": versions(),
        "converged": result.converged,
        "message": result.message,
        "warnings": list(result.warnings),
        "passed": ended and all(verdict.passed for verdict in verdicts),
        "verdicts": [asdict(verdict) for verdict in verdicts],
        "sizes": result.sizes,
        "newton_iterations": sum(step.iterations for step in result.steps),
        "timings": result.timings,
        "floor": floor_seconds(result.timings),
        "force_unit": result.case.force_unit,
        "reactions": result.reactions,
        "values": values,
        "uniform": [asdict(cost) for cost in uniform_costs(result.steps)],
        "steps": [asdict(step) for step in result.steps],
    }


def _error_cells(errors: ErrorStep) -> list[object]:
    """Indicated errors of a step, empty where there is none, and cells of all meshes."""
    found = (errors.mechanics, errors.heat, errors.time)
    return [
        *("" if eta is None else eta for eta in found),
        sum(errors.cells.values()),
        sum(errors.thermal_cells.values()),
    ]


class OutputWriter:
    """Writes the files of one run; made and called on rank 0 only."""

    def __init__(
        self,
        directory: Path,
        case: Case,
        command: str,
        account: Account = UNKNOWN,
        steps: Sequence[StepReport] | None = None,
        draw: Callable[[RunResult, Path], object] | None = None,
    ) -> None:
        """Make the directory and clear it of what an earlier run would leave to confuse.

        Args:
            directory: where the files go; made if it is missing.
            case: the case that is run.
            command: the command that repeats the run.
            account: what the case says, for the summary.
            steps: those that a resumed run has behind it, after which its history goes on; None for
                a new run.
            draw: who draws the pictures of a result into a folder; this process without.

        Raises:
            CaseError: if the directory cannot be made or written to.
        """
        self.directory = Path(directory)
        self.case = case
        self.command = command
        self.account = account
        self.draw = draw
        self.failures: list[Failure] = []
        try:
            (self.directory / FIGURES).mkdir(parents=True, exist_ok=True)
            for stale in self._stale(resumed=steps is not None):
                stale.unlink()
            rows = map(self._row, steps or ())
            write_whole(self.directory / HISTORY, _csv(self._header(), rows))
        except OSError as error:
            raise CaseError(f"{directory}: cannot be written to: {error.strerror}") from None

    def _stale(self, resumed: bool) -> Iterator[Path]:
        """Files of an earlier run that this one will not write again, or not before its end."""
        for pattern in (SUMMARY, "interface_*.csv", f"{FIGURES}/*.png"):
            for path in self.directory.glob(pattern):
                if not (resumed and "_t=" in path.name):
                    yield path
        for name in () if resumed else (NAME, PREVIOUS):
            yield from self.directory.glob(name)

    def _header(self) -> list[str]:
        force, energy = self.case.force_unit, self.case.force_unit.replace("N", "J")
        columns = STEP_COLUMNS | {"dissipation": f"dissipation [{energy}]"}
        header = [*columns.values(), "residual"]
        for name in self.case.interfaces:
            header += [f"{name}.force_x [{force}]", f"{name}.force_y [{force}]"]
            header.append(f"{name}.moment_defect")
        if self.case.heat is not None:
            header += [f"{v} [{energy}]" if "heat" in v else v for v in HEAT_COLUMNS.values()]
            power = force.replace("N", "W")
            header += [f"{name}.heat_flow [{power}]" for name in self.case.interfaces]
        return header + list(ERROR_COLUMNS if self.case.adaptivity is not None else ())

    def _row(self, report: StepReport) -> list[object]:
        row = [getattr(report, name) for name in STEP_COLUMNS]
        row.append(report.residuals[-1] if report.residuals else math.nan)
        for name in self.case.interfaces:
            forces = report.forces.get(name, (0.0, 0.0))
            row += [*forces, report.moment_defects.get(name, 0.0)]
        if report.heat is not None:
            heat = asdict(report.heat) | {"held_sum": sum(report.heat.held.values())}
            row += [heat[name] for name in HEAT_COLUMNS]
            row += [report.heat.flow[name] for name in self.case.interfaces]
        return row + (_error_cells(report.errors) if report.errors is not None else [])

    def step(self, report: StepReport) -> None:
        """Add the row of an accepted step to the history, at once, so that it can be followed.

        Args:
            report: the step.
        """
        with (self.directory / HISTORY).open("a", encoding="utf-8") as file:
            file.write(",".join(map(_cell, self._row(report))) + "\n")

    def failure(self, failure: Failure) -> None:
        """Keep a step that failed, for the summary.

        Args:
            failure: the step.
        """
        self.failures.append(failure)

    def interfaces(self, tables: Iterable[InterfaceTable], t: float | None = None) -> None:
        """Write the nodes of the interfaces.

        Args:
            tables: the interfaces.
            t: time to put into the file names, none at the end of the run [s].
        """
        suffix = "" if t is None else f"_t={t:.6g}"
        for table in tables:
            stem = f"interface_{table.name}"
            write_whole(self.directory / f"{stem}{suffix}.csv", interface_csv(table))
            if len(table.mortar_pressure):
                write_whole(self.directory / f"{stem}_mortar{suffix}.csv", mortar_csv(table))

    def finish(self, result: RunResult) -> list[Verdict]:
        """Write the end of the run, converged or not: interfaces, figures and, last, the summary.

        The time this takes is added to the phases "output" and "total" of the summary.

        Args:
            result: the run.

        Returns:
            The verdicts on what the case expects.
        """
        start = time.perf_counter()
        self.interfaces(result.interfaces)
        values = measure(result)
        verdicts = judge(result.case, values)
        if self.case.output.figures:
            from contactfem.output.figures.all_figures import draw_all

            (self.draw or draw_all)(result, self.directory / FIGURES)
        summary = summarise(result, values, verdicts, self.command) | asdict(self.account)
        summary["failures"] = [asdict(failure) for failure in self.failures]
        spent = time.perf_counter() - start
        for phase in ("output", "total"):
            summary["timings"] = {
                **summary["timings"],
                phase: summary["timings"].get(phase, 0.0) + spent,
            }
        text = json.dumps(_plain(summary), indent=1, allow_nan=False, ensure_ascii=False)
        write_whole(self.directory / SUMMARY, text + "\n")
        return verdicts
