"""A study: errors, costs and observed orders of runs."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

from contactfem.case.read import read_case
from contactfem.case.schema import Case
from contactfem.case.settings import Study as StudyTable
from contactfem.common.files import write_whole
from contactfem.errors import CaseError, ExitCode
from contactfem.output.tables import versions
from contactfem.results.expectations import check_names
from contactfem.results.measures import measurable
from contactfem.study.process import Outcome, command_of, run_member
from contactfem.study.refinement import What
from contactfem.study.runs import Curve, Member, curves, members
from contactfem.study.table import (
    Row,
    Target,
    by_curve,
    csv_text,
    json_ready,
    rows_of,
    run_table,
    slope_table,
)

if TYPE_CHECKING:
    from rich.console import Console

PICTURE = "study.png"
WIDTH = 110  # of messages, and of tables that are not shown on a terminal


@dataclass(frozen=True)
class Study:
    """A family of runs to make.

    Attributes:
        path: the case file.
        out: folder for the tables, the picture and the folders of the runs.
        base: what all runs have in common.
        variations: "a.b.c=v1,v2" each.
        ranks: numbers of processes.
        levels: runs of a curve, each twice as fine as the one before.
        what: what becomes finer.
        patience: seconds after which a run is stopped [s].
        command: what repeats the study.
    """

    path: Path
    out: Path
    base: Curve
    variations: tuple[str, ...]
    ranks: tuple[int, ...]
    levels: int
    what: tuple[What, ...]
    patience: float
    command: str


def target_of(case: Case, table: StudyTable | None) -> Target:
    """What is taken for the error.

    Args:
        case: the case.
        table: what was asked for; None takes what the case says.

    Returns:
        The number and its reference.

    Raises:
        CaseError: nobody says what, or nothing measures it.
    """
    table = table or case.study
    if table is None:
        raise CaseError(f"{case.path}: study: what is the error? {_choice(case)}")
    check_names(case.model_copy(update={"study": table}))
    if table.error is not None:
        return Target(table.error, True)
    assert table.quantity is not None
    return Target(
        table.quantity, False, float("nan" if table.reference is None else table.reference)
    )


def _choice(case: Case) -> str:
    """What may be asked for, in a sentence of several lines."""
    names = list(measurable(case))
    errors = [name for name in names if "_error_" in name]
    named = [name for name in case.expect if name in names and name not in errors]
    lines = [
        "Give --error NAME, or --quantity NAME to compare with the finest run,",
        "or a table [study] with 'error', or with 'quantity' and perhaps its 'reference'.",
        *_listed("errors", ", ".join(errors) or "none, as no interface has a closed_form"),
        *_listed("quantities that the case expects", ", ".join(named) or "none"),
    ]
    owners: dict[tuple[str, ...], list[str]] = {}
    for owner in dict.fromkeys(name.partition(".")[0] for name in names if "." in name):
        its = [name.partition(".")[2] for name in names if name.startswith(f"{owner}.")]
        owners.setdefault(tuple(key for key in its if "_error_" not in key), []).append(owner)
    for keys, sharing in owners.items():
        lines += _listed(f"quantities of {', '.join(sharing)}", ", ".join(keys))
    return "\n".join(lines)


def _listed(title: str, text: str) -> list[str]:
    """Title and text, in lines that are not too long."""
    return wrap(f"{title}: {text}", WIDTH, initial_indent="  ", subsequent_indent="    ")


def run_study(study: Study, target: Target, console: Console | None = None) -> int:
    """Make all runs one after the other; tables are written after each of them.

    Args:
        study: the family.
        target: what is taken for the error.
        console: where to print, standard output by default.

    Returns:
        Exit code: 0 if every run has an answer, else 1.

    Raises:
        CaseError: the case or a variation cannot be read.
        OSError: the folder cannot be written to.
    """
    from rich.console import Console

    console = Console() if console is None else console
    if not console.is_terminal:
        console.width = WIDTH
    family = [
        members(study.path, curve, study.levels, study.what)
        for curve in curves(study.base, study.variations, study.ranks)
    ]
    study.out.mkdir(parents=True, exist_ok=True)
    (study.out / PICTURE).unlink(missing_ok=True)
    runs: list[tuple[Member, Outcome, str]] = []
    rows: list[Row] = []
    total = sum(len(some) for some in family)
    for run in _runs(study, family):
        runs.append(run)
        rows = rows_of(target, runs)
        _write(study, target, rows)
        console.print(f"run {len(runs)} of {total}: {_news(run)}", markup=False, highlight=False)
    _show(study, target, rows, console)
    failed = any(outcome.message for _, outcome, _ in runs)
    return ExitCode.MISSED if failed else ExitCode.DONE


def _runs(
    study: Study, family: Collection[Sequence[Member]]
) -> Iterator[tuple[Member, Outcome, str]]:
    """Run the curves; the first run of each is made twice, as it also compiles its forms."""
    for number, curve in enumerate(family, start=1):
        for member in curve:
            out = study.out / f"curve_{number}_level_{member.level}"
            outcome = run_member(member, study.path, out, study.patience)
            if member.level == 0 and not outcome.message:
                outcome = run_member(member, study.path, out, study.patience)
            yield member, outcome, command_of(member, study.path, out)


def _news(run: tuple[Member, Outcome, str]) -> str:
    """What became of a run, in a line."""
    member, outcome, _ = run
    name = f"{member.curve.label or 'case'}, level {member.level}"
    if outcome.message:
        return f"{name}: failed: {outcome.message}"
    return f"{name}: {outcome.unknowns} unknowns, {outcome.seconds:.2f} s"


def _write(study: Study, target: Target, rows: Sequence[Row]) -> None:
    """Write the tables of the runs so far."""
    about = {"case": study.path.name, "command": study.command, "versions": versions()}
    text = json.dumps(json_ready(target, rows, about), indent=1, ensure_ascii=False)
    write_whole(study.out / "study.json", text + "\n")
    write_whole(study.out / "study.csv", csv_text(rows))


def _show(study: Study, target: Target, rows: Sequence[Row], console: Console) -> None:
    """Print the tables and draw the picture."""
    from contactfem.study.figure import draw_study

    title = read_case(study.path).title
    console.print(run_table(title, target, rows))
    if any(len(some) > 1 for some in by_curve(rows).values()):
        console.print(slope_table(rows))
    for row in rows:
        if row.outcome.message:
            where = f"{row.member.curve.label or 'case'}, level {row.member.level}"
            console.print(f"{where}: {row.outcome.message}", markup=False, highlight=False)
    draw_study(study.out / PICTURE, title, target, rows)
    console.print(f"results in {study.out}", markup=False, highlight=False)
