"""Tables of a run as CSV, and its summary, written and read."""

from __future__ import annotations

import csv
import io
import json
import math
import platform
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import contactfem
from contactfem.checkpoint.format import NAME
from contactfem.common.text import one_line
from contactfem.errors import CaseError
from contactfem.results.data import (
    ErrorStep,
    InterfaceTable,
    RunResult,
    Status,
    StepReport,
)
from contactfem.results.error_measures import uniform_costs
from contactfem.results.expectations import Verdict
from contactfem.results.measures import floor_seconds

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
AXES = "xyz"
VECTOR_COLUMNS = {"traction_vector": "traction_{} [Pa]", "slip_vector": "slip_{} [m]"}


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
    axes = AXES[: table.X.shape[1]]
    names = [name for name in NODE_COLUMNS if name != "arc" or len(axes) == 2]
    columns: list[Sequence[object]] = [
        [float(value) for value in column]
        for column in (*table.X.T, *table.x.T, *(getattr(table, name) for name in names))
    ]
    where = 2 * len(axes) + names.index("status")
    columns[where] = [Status(code).name.lower() for code in table.status]
    header = [f"{axis} [m]" for axis in axes.upper() + axes]
    header += [NODE_COLUMNS[name] for name in names]
    for name, title in VECTOR_COLUMNS.items() if len(axes) == 3 else ():
        header += [title.format(axis) for axis in axes]
        columns += [[float(v) for v in column] for column in getattr(table, name).T]
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
    axes = AXES[: table.mortar_x.shape[1]]
    return _csv([*(f"{axis} [m]" for axis in axes), "pressure [Pa]"], rows)


def _error_cells(errors: ErrorStep) -> list[object]:
    """Indicated errors of a step, empty where there is none, and cells of all meshes."""
    found = (errors.mechanics, errors.heat, errors.time)
    return [
        *("" if eta is None else eta for eta in found),
        sum(errors.cells.values()),
        sum(errors.thermal_cells.values()),
    ]


def history_csv(case: Case, reports: Iterable[StepReport]) -> str:
    """Table of the accepted steps, a row each.

    Args:
        case: the case, which tells the columns.
        reports: the steps.

    Returns:
        The text of the file, its header with units.
    """
    return _csv(_history_header(case), (_history_cells(case, report) for report in reports))


def history_row(case: Case, report: StepReport) -> str:
    """Row of one accepted step.

    Args:
        case: the case, which tells the columns.
        report: the step.

    Returns:
        The line to add to the file.
    """
    return ",".join(map(_cell, _history_cells(case, report))) + "\n"


def _history_header(case: Case) -> list[str]:
    force, energy = case.force_unit, case.force_unit.replace("N", "J")
    columns = STEP_COLUMNS | {"dissipation": f"dissipation [{energy}]"}
    header = [*columns.values(), "residual"]
    for name in case.interfaces:
        header += [f"{name}.force_{axis} [{force}]" for axis in AXES[: case.axes]]
        header.append(f"{name}.moment_defect")
    if case.heat is not None:
        header += [f"{v} [{energy}]" if "heat" in v else v for v in HEAT_COLUMNS.values()]
        power = force.replace("N", "W")
        header += [f"{name}.heat_flow [{power}]" for name in case.interfaces]
    return header + list(ERROR_COLUMNS if case.adaptivity is not None else ())


def _history_cells(case: Case, report: StepReport) -> list[object]:
    row = [getattr(report, name) for name in STEP_COLUMNS]
    row.append(report.residuals[-1] if report.residuals else math.nan)
    for name in case.interfaces:
        forces = report.forces.get(name, (0.0,) * case.axes)
        row += [*forces, report.moment_defects.get(name, 0.0)]
    if report.heat is not None:
        heat = asdict(report.heat) | {"held_sum": sum(report.heat.held.values())}
        row += [heat[name] for name in HEAT_COLUMNS]
        row += [report.heat.flow[name] for name in case.interfaces]
    return row + (_error_cells(report.errors) if report.errors is not None else [])


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


def summary_json(summary: Mapping[str, Any]) -> str:
    """Text of summary.json; null stands for a number that is not finite.

    Args:
        summary: of one run.

    Returns:
        The text of the file.
    """
    return json.dumps(_plain(summary), indent=1, allow_nan=False, ensure_ascii=False) + "\n"


def read_summary(directory: Path) -> dict[str, Any]:
    """Read the summary of a finished run.

    Args:
        directory: directory of the run, or its summary.json.

    Returns:
        What `output.summarise` collected; numbers that were not finite are None.

    Raises:
        CaseError: if there is no such run, it has not finished, or the file is not one of ours.
    """
    path = Path(directory)
    path = path if path.name == SUMMARY else path / SUMMARY
    if not path.parent.is_dir():
        raise CaseError(f"{directory}: no such directory; a run makes it: contactfem run CASE")
    if not path.is_file():
        hint = f"; 'contactfem resume {path.parent}' goes on with it"
        hint = hint if (path.parent / NAME).is_file() else ""
        raise CaseError(f"{directory}: no {SUMMARY}: the run has not finished, or was none{hint}")
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
        wrong = [key for key in ("title", "steps", "verdicts", "passed") if key not in summary]
    except (OSError, ValueError, TypeError, RecursionError) as error:
        why = one_line(str(error))
        raise CaseError(f"{path}: not a summary of a run: {why}") from None
    if not isinstance(summary, dict):
        raise CaseError(f"{path}: not a summary of a run")
    if wrong:
        raise CaseError(f"{path}: not a summary of a run: it has no '{wrong[0]}'")
    return dict(summary)


def number(value: float | None) -> float:
    """A number of a summary, where None stands for what is not finite."""
    return math.nan if value is None else float(value)
