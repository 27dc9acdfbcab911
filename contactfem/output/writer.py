"""Write the files of a run into its folder, on rank 0."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from contactfem.check.check import Account
from contactfem.checkpoint.format import NAME, PREVIOUS
from contactfem.common.files import write_whole
from contactfem.errors import CaseError
from contactfem.output.tables import (
    FIGURES,
    HISTORY,
    SUMMARY,
    history_csv,
    history_row,
    interface_csv,
    mortar_csv,
    summarise,
    summary_json,
)
from contactfem.results.data import Failure, InterfaceTable, RunResult, StepReport
from contactfem.results.expectations import Verdict, judge
from contactfem.results.measures import measure

if TYPE_CHECKING:
    from contactfem.case.schema import Case

UNKNOWN = Account()


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
            write_whole(self.directory / HISTORY, history_csv(case, steps or ()))
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

    def step(self, report: StepReport) -> None:
        """Add the row of an accepted step to the history, at once, so that it can be followed.

        Args:
            report: the step.
        """
        with (self.directory / HISTORY).open("a", encoding="utf-8") as file:
            file.write(history_row(self.case, report))

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
        suffix = "" if t is None else f"_t={t:.12g}"
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
        write_whole(self.directory / SUMMARY, summary_json(summary))
        return verdicts
