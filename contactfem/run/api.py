"""`solve` and its `Run`: a case solved from Python."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from mpi4py import MPI

from contactfem.case.schema import Case
from contactfem.discretisation.discretise import Discretisation
from contactfem.discretisation.state import State
from contactfem.errors import CaseError
from contactfem.results.data import RunResult, StepReport
from contactfem.run.driver import solve_case
from contactfem.run.views import Body, ContactSurface, Moment

SHOWN = 8  # steps in a notebook, the last ones


@dataclass(frozen=True)
class Step(Moment):
    """An accepted step, as `on_step` sees it.

    Attributes:
        report: Its iterations, forces, cut-backs and more.
    """

    report: StepReport


@dataclass(frozen=True)
class Run:
    """A case that was solved.

    Attributes:
        result: All that was found, as plain data.
        end: Bodies and interfaces at the end.
        folder: Where its files are; None where nothing was written.
    """

    result: RunResult
    end: Moment
    folder: Path | None

    @property
    def bodies(self) -> dict[str, Body]:
        """The bodies at the end, by name."""
        return self.end.bodies

    @property
    def interfaces(self) -> dict[str, ContactSurface]:
        """The interfaces at the end, by name; collective when first asked for."""
        return self.end.interfaces

    @property
    def steps(self) -> tuple[StepReport, ...]:
        """The accepted steps."""
        return self.result.steps

    @property
    def converged(self) -> bool:
        """Whether the end was reached; `message` says why not."""
        return self.result.converged

    @property
    def message(self) -> str:
        """Why the end was not reached; empty if it was."""
        return self.result.message

    @cached_property
    def values(self) -> Mapping[str, float]:
        """Numbers by the names that a case file's [expect] uses [SI]; on the first rank."""
        from contactfem.results.measures import measure

        return measure(self.result)

    def to_pandas(self) -> Any:
        """The steps as a `pandas.DataFrame`, a row each.

        Raises:
            CaseError: pandas is not installed.
        """
        try:
            import pandas as pd
        except ImportError:
            raise CaseError("to_pandas needs pandas: pip install pandas") from None
        return pd.DataFrame([_row(step) for step in self.steps])

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        state = "reached its end" if self.converged else f"stopped: {html.escape(self.message)}"
        rows: list[tuple[str, ...]] = [("", *_row(self.steps[-1]))] if self.steps else []
        for step in self.steps[-SHOWN:]:
            rows.append((f"step {step.step}", *(f"{v:.5g}" for v in _row(step).values())))
        cells = "".join(
            "<tr>" + "".join(f"<td>{html.escape(str(cell))}</td>" for cell in row) + "</tr>"
            for row in rows
        )
        title = html.escape(self.result.case.title)
        return f"<b>{title}</b>: {len(self.steps)} steps, {state}<table>{cells}</table>"


def _row(step: StepReport) -> dict[str, float]:
    """A step as one row: numbers by name."""
    found = {"t": step.t, "dt": step.dt, "iterations": step.iterations, "open": step.open}
    found |= {"stick": step.stick, "slip": step.slip, "dissipation": step.dissipation}
    for name, force in step.forces.items():
        found |= {f"{name}.force_{axis}": f for axis, f in zip("xyz", force, strict=False)}
    return found


def solve(
    case: Case,
    comm: MPI.Comm | None = None,
    out: Path | str | None = None,
    on_step: Callable[[Step], object] | None = None,
) -> Run:
    """Solve a case from time zero to its end; collective.

    Args:
        case: The case.
        comm: Ranks that solve it together; all of `mpirun` if None.
        out: Folder for its files; None to write and print nothing.
        on_step: Called on all ranks after every step that was accepted.

    Returns:
        The run. If the solver gave up, `converged` is false and `message` says why.

    Raises:
        CaseError: The case does not fit its meshes.
        WriteError: Results cannot be written.
    """
    folder = None if out is None else Path(out)

    def seen(report: StepReport, discretisation: Discretisation, state: State) -> None:
        if on_step is not None:
            on_step(Step(case, discretisation, state, report))

    solved = solve_case(case, comm or MPI.COMM_WORLD, folder, on_step=seen)
    return Run(solved.result, Moment(case, solved.discretisation, solved.state), folder)
