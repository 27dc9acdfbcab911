"""All cases of a folder, judged in one table."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.case.schema import Case
from contactfem.common.files import write_whole
from contactfem.common.text import report_table
from contactfem.errors import CaseError, ContactfemError, ExitCode
from contactfem.results.expectations import Verdict, check_names, judge, measure
from contactfem.run.driver import run_case

if TYPE_CHECKING:
    from rich.console import Console

COLUMNS = (
    "case", "ended", "unknowns", "steps", "cut-backs", "iterations", "error", "held", "seconds",
    "verdict",
)  # fmt: skip
REFUSED = "refused"


@dataclass(frozen=True)
class Row:
    """What became of one case or variant.

    Attributes:
        case: name of the case file, and of the variant.
        ended: "yes" if the end time was reached, else "no" with the last good time, or "refused".
        unknowns: displacement unknowns.
        steps: accepted steps.
        cutbacks: steps that were tried again with half the length.
        iterations: Newton iterations of the accepted steps.
        error: largest relative distance from a reference, NaN where there is none [-].
        held: expectations that are met, "3 of 4".
        seconds: wall-clock time [s].
        passed: whether it ended as expected.
        missed: expectations that are not met, and why the solver stopped, in words.
    """

    case: str
    ended: str
    unknowns: int
    steps: int
    cutbacks: int
    iterations: int
    error: float
    held: str
    seconds: float
    passed: bool
    missed: tuple[str, ...] = ()

    def cells(self) -> list[str]:
        """The row as it is printed, in the order of COLUMNS."""
        cells = [str(value) for value in astuple(self)[:-2]]
        cells[6] = "" if math.isnan(self.error) else f"{self.error:.1e}"
        cells[8] = f"{self.seconds:.1f}"
        return [*cells, "passed" if self.passed else "missed"]


def distance(case: Case, verdicts: Sequence[Verdict]) -> float:
    """Largest relative distance from the references of a case.

    References are the non-zero numbers that it expects a value near, |x - x_ref| / |x_ref|, and the
    errors against closed forms that it bounds.

    Args:
        case: the case.
        verdicts: what was expected of it.

    Returns:
        The distance [-]; NaN where there is no reference.
    """
    found = [math.nan]
    for verdict in verdicts:
        reference = case.expect[verdict.key].value
        if reference:
            found.append(abs(verdict.value - reference) / abs(reference))
        elif "_error_" in verdict.key:
            found.append(verdict.value)
    return max((x for x in found if not math.isnan(x)), default=math.nan)


def judged(case: Case, name: str) -> Row:
    """Run one case without writing anything, and judge it.

    Args:
        case: the case.
        name: what the row calls it.

    Returns:
        Its row.

    Raises:
        CaseError: the case does not fit its meshes.
    """
    result = run_case(case, MPI.COMM_SELF, None)
    verdicts = judge(case, measure(result))
    wrong = [v for v in verdicts if not v.passed]
    missed = [f"{v.key} = {v.value:.6g}, allowed {v.low:.6g} to {v.high:.6g}" for v in wrong]
    expected_end = result.converged or "converged" in case.expect
    if not expected_end:
        missed.append(result.message)
    reached = result.steps[-1].t if result.steps else 0.0
    return Row(
        case=name,
        ended="yes" if result.converged else f"no (at {reached:.4g} s)",
        unknowns=result.sizes["unknowns"],
        steps=len(result.steps),
        cutbacks=sum(step.cutbacks for step in result.steps),
        iterations=sum(step.iterations for step in result.steps),
        error=distance(case, verdicts),
        held=f"{len(verdicts) - len(wrong)} of {len(verdicts)}",
        seconds=result.timings["total"],
        passed=not missed,
        missed=tuple(missed),
    )


def rows(folder: Path) -> Iterator[Row]:
    """Run every case of a folder and every variant of it, by name.

    Args:
        folder: folder with case files.

    Yields:
        A row each; one that cannot be run has the reason in `missed`.

    Raises:
        CaseError: the folder holds no case files.
    """
    paths = sorted(folder.glob("*.toml"))
    if not paths:
        raise CaseError(f"{folder}: neither the folder of a run nor one of case files")
    for path in paths:
        base = _row(path, None)
        yield base
        if base.ended != REFUSED:
            yield from (_row(path, variant) for variant in read_case(path).variants)


def _row(path: Path, variant: str | None) -> Row:
    """Row of one case or variant, also of one that cannot be run."""
    name = f"{path.stem}-{variant}" if variant else path.stem
    try:
        case = read_case(path, variant=variant)
        check_names(case)
        return judged(case, name)
    except ContactfemError as error:
        return Row(name, REFUSED, 0, 0, 0, 0, math.nan, "", 0.0, False, (str(error),))


def report_folder(folder: Path, out: Path, console: Console | None = None) -> int:
    """Run all cases of a folder into one table, printed and written as Markdown and CSV.

    Args:
        folder: folder with case files.
        out: folder for the tables, which take its name.
        console: where to print, standard output by default.

    Returns:
        Exit code: 0 if every case ended as it was expected to, else 1.

    Raises:
        CaseError: the folder holds no case files.
    """
    from rich.console import Console

    console = Console() if console is None else console
    found: list[Row] = []
    with console.status("") as status:
        for row in rows(folder):
            found.append(row)
            status.update(f"{len(found)} run, last {row.case}")
    table = report_table(str(folder), *COLUMNS)
    for row in found:
        color = "green" if row.passed else "bold red"
        table.add_row(*row.cells()[:-1], f"[{color}]{row.cells()[-1]}[/]")
    console.print(table)
    for row in found:
        for line in row.missed:
            console.print(f"{row.case}: {line}", markup=False, highlight=False)
    out.mkdir(parents=True, exist_ok=True)
    write_whole(out / f"{out.name}.md", markdown(found))
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([COLUMNS, *(row.cells() for row in found)])
    write_whole(out / f"{out.name}.csv", text.getvalue())
    return ExitCode.DONE if all(row.passed for row in found) else ExitCode.MISSED


def markdown(found: Sequence[Row]) -> str:
    """Table of some rows in Markdown.

    Args:
        found: the rows.

    Returns:
        The text.
    """
    rule = ["---", *["---:"] * (len(COLUMNS) - 1)]
    lines = [COLUMNS, rule, *(row.cells() for row in found)]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines) + "\n"
