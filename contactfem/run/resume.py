"""A run to be resumed: its last checkpoint and its case."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from contactfem.case.overrides import override
from contactfem.case.read import case_of
from contactfem.case.schema import Case
from contactfem.checkpoint.format import NAME, Checkpoint, read_checkpoint
from contactfem.errors import CaseError, CheckpointError
from contactfem.output.tables import SUMMARY, read_summary
from contactfem.results.expectations import check_names

# Keys that say how a case is solved, written and judged, not what is solved or kept in a state
CHANGEABLE = (
    "time", "output", "expect",
    "solver.tolerance", "solver.max_iterations", "solver.max_cutbacks", "solver.petsc",
    "heat.max_passes", "heat.tolerance", "heat.relaxation", "heat.petsc",
)  # fmt: skip


@dataclass(frozen=True)
class Resumption:
    """A run to go on with.

    Attributes:
        says: What there is to say about it.
        case: Its case; None where there is nothing left to do.
        checkpoint: Where it goes on from; None likewise.
    """

    says: str
    case: Case | None = None
    checkpoint: Checkpoint | None = None


def prepare(folder: Path, overrides: Sequence[str]) -> Resumption:
    """Read the last checkpoint of a run, and its case.

    Args:
        folder: folder of the run.
        overrides: "a.b.c=value" each.

    Returns:
        The run.

    Raises:
        CheckpointError: there is no checkpoint that can be read.
        CaseError: a value that cannot be changed, or not so.
    """
    if not folder.is_dir():
        raise CheckpointError(f"{folder}: no such directory; a run makes it: contactfem run CASE")
    for text in overrides:
        _check_changeable(text)
    if not overrides and (folder / SUMMARY).is_file():
        summary = read_summary(folder)
        if summary.get("converged") is True:
            return Resumption(f"{folder}: the run has come to its end; there is nothing to do")
    checkpoint, warning = read_checkpoint(folder)
    path, raw = Path(checkpoint.origin.path), checkpoint.origin.contents
    before = case_of(raw, path)
    for text in overrides:
        raw = override(raw, text)
    case = case_of(raw, path)
    check_names(case)
    if case.time.step != before.time.step:
        progress = replace(checkpoint.progress, dt=case.time.step, easy=())
        checkpoint = replace(checkpoint, progress=progress)
    at = f"step {len(checkpoint.progress.reports)}, t = {checkpoint.progress.t:g} s"
    says = f"{warning}\n" if warning else ""
    if checkpoint.progress.t >= case.time.end * (1.0 - 1e-12):
        return Resumption(f"{says}{folder / NAME}: is of the end, {at}; there is nothing to do")
    return Resumption(f"{says}{folder}: resumed after {at}", case, checkpoint)


def _check_changeable(text: str) -> None:
    key = text.partition("=")[0].strip()
    if not any(key == name or key.startswith(f"{name}.") for name in CHANGEABLE):
        raise CaseError(
            f"--set {text}: cannot be changed in a run that goes on; can be: "
            f"{', '.join(CHANGEABLE)}"
        )
