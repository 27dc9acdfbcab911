"""Tables of the runs of a study."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from contactfem.common.text import report_table
from contactfem.study.convergence_orders import observed_orders, relative_distance, slope
from contactfem.study.process import Outcome
from contactfem.study.runs import Member

if TYPE_CHECKING:
    from rich.table import Table

MEGABYTE = 1e6
SAME = 1e-9  # relative distance from the finest run below which a run agrees with it
UNITS = {"seconds": "s", "wall": "s", "memory": "B"}
SHOWN = (
    "run", "level", "unknowns", "steps", "iter", "error", "order", "seconds", "MB",
)  # fmt: skip


@dataclass(frozen=True)
class Target:
    """What is taken for the error of a run.

    Attributes:
        name: a measured number.
        is_error: whether it is an error itself.
        reference: what it should be; NaN to take that of the finest run of the first curve [SI].
    """

    name: str
    is_error: bool
    reference: float = math.nan

    def words(self) -> str:
        """What is shown as the error."""
        if self.is_error:
            return self.name
        finest = " of the finest run" if math.isnan(self.reference) else ""
        return f"relative error of {self.name}{finest and ', reference: that' + finest}"


@dataclass(frozen=True)
class Row:
    """A run with its error.

    Attributes:
        member: which run.
        outcome: what became of it.
        command: what repeats it.
        value: what was measured [SI].
        error: its error [-]; NaN if not known.
        order: how fast that fell since the level before [-]; NaN if not known.
    """

    member: Member
    outcome: Outcome
    command: str
    value: float
    error: float
    order: float

    def cells(self) -> dict[str, str | int | float]:
        """What stands in the table for it, by column."""
        member, outcome = self.member, self.outcome
        return {
            "curve": member.curve.label,
            "ranks": member.curve.ranks,
            "level": member.level,
            "factor": member.factor,
            "unknowns": outcome.unknowns,
            "steps": outcome.steps,
            "iterations": outcome.iterations,
            "value": self.value,
            "error": self.error,
            "order": self.order,
            "seconds": outcome.seconds,
            "wall": outcome.wall,
            "memory": outcome.memory,
            "message": outcome.message,
        }


@dataclass(frozen=True)
class Slopes:
    """Exponents of a curve: error ~ factor^-order, unknowns^s and seconds^s."""

    order: float
    unknowns: float
    seconds: float


def rows_of(target: Target, runs: Sequence[tuple[Member, Outcome, str]]) -> list[Row]:
    """Find the errors and orders of some runs.

    Args:
        target: what is taken for the error.
        runs: members, what became of them and their commands; curve by curve, level by level.

    Returns:
        A row each. The run that is the reference, and those that agree with it, have no error.
    """
    values = [
        outcome.values.get(target.name, math.nan) if not outcome.message else math.nan
        for _, outcome, _ in runs
    ]
    reference, own = target.reference, -1
    if not target.is_error and math.isnan(reference) and runs:
        first = [k for k, (member, _, _) in enumerate(runs) if member.curve == runs[0][0].curve]
        own = first[-1]
        reference = values[own]
    errors = [value if target.is_error else relative_distance(value, reference) for value in values]
    if own >= 0:
        errors = [math.nan if error < SAME else error for error in errors]
    orders: list[float] = []
    for curve in dict.fromkeys(member.curve for member, _, _ in runs):
        its = [k for k, (member, _, _) in enumerate(runs) if member.curve == curve]
        orders += observed_orders([runs[k][0].factor for k in its], [errors[k] for k in its])
    return [
        Row(*run, value, error, order)
        for run, value, error, order in zip(runs, values, errors, orders, strict=True)
    ]


def by_curve(rows: Iterable[Row]) -> dict[str, list[Row]]:
    """Rows by the label of their curve, in order."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row.member.curve.label, []).append(row)
    return found


def slopes_of(rows: Sequence[Row]) -> Slopes:
    """Exponents of one curve through all its runs."""
    errors = [row.error for row in rows]
    return Slopes(
        order=-slope([row.member.factor for row in rows], errors),
        unknowns=slope([row.outcome.unknowns for row in rows], errors),
        seconds=slope([row.outcome.seconds for row in rows], errors),
    )


def csv_text(rows: Sequence[Row]) -> str:
    """Table with a line per run; units in the header, and seconds of each phase in the end."""
    phases = sorted({phase for row in rows for phase in row.outcome.timings})
    names = rows[0].cells() if rows else ()
    header = [f"{name} [{UNITS[name]}]" if name in UNITS else name for name in names]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*header, *(f"{phase} [s]" for phase in phases)])
    for row in rows:
        cells = [*row.cells().values(), *(row.outcome.timings.get(k, math.nan) for k in phases)]
        writer.writerow([f"{x:.10g}" if isinstance(x, float) else x for x in cells])
    return text.getvalue()


def json_ready(target: Target, rows: Sequence[Row], about: Mapping[str, Any]) -> dict[str, Any]:
    """Everything about a study; numbers that are not finite are None."""

    def plain(value: float) -> float | None:
        return value if math.isfinite(value) else None

    runs = []
    for row in rows:
        cells = {k: plain(x) if isinstance(x, float) else x for k, x in row.cells().items()}
        timings = dict(row.outcome.timings)
        overrides = list(row.member.overrides)
        runs.append(cells | {"overrides": overrides, "command": row.command, "timings": timings})
    slopes = {
        label: {name: plain(value) for name, value in vars(slopes_of(some)).items()}
        for label, some in by_curve(rows).items()
    }
    return {
        **about,
        "error": target.name,
        "is_error": target.is_error,
        "reference": plain(target.reference),
        "runs": runs,
        "slopes": slopes,
    }


def run_table(title: str, target: Target, rows: Sequence[Row]) -> Table:
    """Table to print, a row per run."""
    from rich.markup import escape

    table = report_table(f"{title}: {target.words()}", *SHOWN)
    for row in rows:
        out = row.outcome
        name = row.member.curve.label or "case"
        if out.message:
            table.add_row(escape(name), str(row.member.level), *[""] * 3, "[bold red]failed[/]")
            continue
        numbers = (
            ("reference" if math.isnan(row.error) else f"{row.error:.2e}"),
            ("" if math.isnan(row.order) else f"{row.order:.2f}"),
            f"{out.seconds:.3f}",
            f"{out.memory / MEGABYTE:.0f}",
        )
        counts = (row.member.level, out.unknowns, out.steps, out.iterations)
        table.add_row(escape(name), *(str(count) for count in counts), *numbers)
    return table


def slope_table(rows: Sequence[Row]) -> Table:
    """Table of how the error falls along each curve."""
    from rich.markup import escape

    table = report_table("The error falls with", "run", "order", "unknowns^", "seconds^")
    for label, some in by_curve(rows).items():
        cells = vars(slopes_of(some)).values()
        table.add_row(
            escape(label or "case"), *("" if math.isnan(x) else f"{x:.2f}" for x in cells)
        )
    return table
