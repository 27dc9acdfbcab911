"""Contents of a checkpoint: progress, case and state."""

import math
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter, ValidationError

from contactfem import __version__
from contactfem.adaptivity.decisions import MeshHistory
from contactfem.checkpoint.archive import Tree, read_archive, write_archive
from contactfem.common.files import whole_file
from contactfem.common.text import one_line
from contactfem.errors import CheckpointError
from contactfem.results.data import Failure, StepReport

FORMAT = 2  # of the arrays and the head; another one cannot be read
NAME, PREVIOUS = "checkpoint.npz", "checkpoint.previous.npz"


@dataclass(frozen=True)
class Progress:
    """How far a run has come and how it goes on, beside its state.

    Attributes:
        dt: Step to be tried next [s].
        ramp_end: Time at which constant loads and motions are reached [s].
        easy: Newton iterations of the last solves with this step.
        cautious: Whether nodes stick for an iteration before they slip the other way round.
        reports: Accepted steps.
        failures: Steps that failed.
        warnings: What to doubt about accepted steps.
        reactions: Force of each held surface or grip after the last one [N/m].
        segment: Number of the present field files.
        pending: Whether the last step is not recorded yet, as it may be taken again.
        lasting: What adaptivity remembers after the last step and the one before it.
    """

    dt: float
    ramp_end: float
    easy: tuple[int, ...] = ()
    cautious: bool = False
    reports: tuple[StepReport, ...] = ()
    failures: tuple[Failure, ...] = ()
    warnings: tuple[str, ...] = ()
    reactions: tuple[float, ...] = ()
    segment: int = 0
    pending: bool = False
    lasting: tuple[MeshHistory, MeshHistory] | None = None

    @property
    def t(self) -> float:
        """Time reached [s]."""
        return self.reports[-1].t if self.reports else 0.0

    @property
    def recorded(self) -> tuple[StepReport, ...]:
        """Steps whose results are written."""
        return self.reports[:-1] if self.pending else self.reports


@dataclass(frozen=True)
class Origin:
    """What a run was started with.

    Attributes:
        path: Of the case file, absolute.
        contents: Of the case file, with a variant and changed values put in.
        command: That repeats the run.
    """

    path: str
    contents: dict[str, Any]
    command: str


@dataclass(frozen=True)
class Checkpoint:
    """A run between two steps.

    Attributes:
        origin: What it was started with.
        progress: How far it has come.
        seconds: Spent so far, per phase [s].
        state: Its state and meshes, from `snapshot`; empty but on the first rank.
    """

    origin: Origin
    progress: Progress
    seconds: Mapping[str, float]
    state: Tree = field(default_factory=dict)


def write_checkpoint(folder: Path, checkpoint: Checkpoint) -> None:
    """Write a checkpoint into the folder of a run, and keep the one before it.

    Args:
        folder: The folder.
        checkpoint: The run.

    Raises:
        OSError: It cannot be written; those that are there are left.
    """
    head = {
        "format": FORMAT,
        "version": __version__,
        "origin": asdict(checkpoint.origin),
        "progress": asdict(checkpoint.progress),
        "seconds": dict(checkpoint.seconds),
    }
    with whole_file(folder / NAME) as draft:
        write_archive(draft, head, checkpoint.state)
        if (folder / NAME).exists():
            os.replace(folder / NAME, folder / PREVIOUS)


def read_checkpoint(folder: Path) -> tuple[Checkpoint, str]:
    """Read the last checkpoint of a run, or the one before it where that is damaged.

    Args:
        folder: The folder of the run.

    Returns:
        The checkpoint, and what has to be said about it, else an empty string.

    Raises:
        CheckpointError: There is none that can be read.
    """
    found = [path for path in (folder / NAME, folder / PREVIOUS) if path.exists()]
    if not found:
        raise CheckpointError(
            f"{folder}: no {NAME}: the run ended, or was ended, before it wrote one "
            "(output.checkpoint_interval)"
        )
    complaints: list[str] = []
    for path in found:
        try:
            return _read(path), "; ".join(complaints)
        except CheckpointError as error:
            complaints.append(f"{error}; taking {PREVIOUS}" if path != found[-1] else str(error))
    raise CheckpointError("\n".join(line.partition("; taking")[0] for line in complaints))


@contextmanager
def intact(name: str) -> Iterator[None]:
    """Say in one line that a checkpoint's state is not what this program wrote.

    Args:
        name: Of the checkpoint.

    Raises:
        CheckpointError: What is done inside finds parts missing, or of another kind or size.
    """
    try:
        yield
    except (KeyError, IndexError, ValueError, TypeError, AttributeError, OverflowError) as error:
        why = one_line(f"{type(error).__name__}: {error}")
        raise CheckpointError(f"{name}: is damaged, its state does not fit ({why})") from None


def _read(path: Path) -> Checkpoint:
    head, state = read_archive(path)
    if name := _not_a_number(state):
        raise CheckpointError(f"{path}: is damaged, {name} holds what is not a number")
    if head.get("format") != FORMAT:
        raise CheckpointError(
            f"{path}: has format {head.get('format')}, of contactfem {head.get('version')}; this "
            f"is contactfem {__version__}, which reads format {FORMAT}"
        )
    try:
        origin = TypeAdapter(Origin).validate_python(head["origin"])
        progress = TypeAdapter(Progress).validate_python(head["progress"])
        seconds = TypeAdapter(dict[str, float]).validate_python(head["seconds"])
    except (KeyError, ValidationError):
        raise CheckpointError(
            f"{path}: contactfem {head.get('version')} wrote other things into it than this one "
            "can read"
        ) from None
    if not (0.0 < progress.dt < math.inf and 0.0 < progress.ramp_end < math.inf):
        raise CheckpointError(f"{path}: is damaged, its steps have no length")
    return Checkpoint(origin, progress, seconds, state)


def _not_a_number(tree: Tree, where: str = "") -> str:
    """Name of the first array that holds NaN; empty if there is none."""
    for name, part in tree.items():
        key = f"{where}{name}"
        if isinstance(part, dict):
            if found := _not_a_number(part, f"{key}/"):
                return found
        elif part.dtype.kind == "f" and np.isnan(part).any():
            return key
    return ""
