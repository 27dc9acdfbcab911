"""When a run writes its state and when it stops on request."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mpi4py import MPI

from contactfem.case.schema import Case
from contactfem.checkpoint.format import NAME, Checkpoint, Origin, Progress, write_checkpoint
from contactfem.checkpoint.state_io import snapshot
from contactfem.common.timers import Timers
from contactfem.discretisation.discretise import Discretisation
from contactfem.discretisation.state import State
from contactfem.errors import Interrupted, WriteError

FIRST = 60.0  # seconds after which the first checkpoint is due at the latest


@dataclass(frozen=True)
class RunState:
    """A run between two steps.

    Attributes:
        discretisation: Its meshes.
        state: Its last good state.
        before: The state before that, where the run may go back to it.
        progress: How far it has come.
    """

    discretisation: Discretisation
    state: State
    before: State | None
    progress: Progress


Writing = Callable[[RunState], str]  # gives why nothing was written; empty if all is well


class Checkpointer:
    """Writes checkpoints: by steps or by the clock, before a run is stopped, when it gives up.

    Args:
        case: The case, which says how often.
        comm: All ranks.
        folder: Of the run; None to write nothing.
        origin: What the run was started with.
        timers: Time spent so far, but for the total.
        started: When the run was started or would have been, had it not been resumed [s].
        asked: Whether this rank is asked to stop.
    """

    def __init__(
        self,
        case: Case,
        comm: MPI.Comm,
        folder: Path | None,
        origin: Origin,
        timers: Timers,
        started: float,
        asked: Callable[[], bool],
    ) -> None:
        self._comm, self._folder, self._origin = comm, folder, origin
        self._timers, self._started, self._asked = timers, started, asked
        self._every, self._interval = case.output.checkpoint_every, case.output.checkpoint_interval
        self._step, self._time, self._any = -1, time.monotonic(), False

    def visit(self, moment: RunState) -> str:
        """Write a checkpoint where one is due, and stop where that is asked for; collective.

        Args:
            moment: The run, before its next step.

        Returns:
            Why a checkpoint that was due is not written; empty if all is well.

        Raises:
            Interrupted: The run is asked to stop, and its state is written.
            WriteError: It is asked to stop, and its state cannot be written.
        """
        if self._folder is None:
            return ""
        step = len(moment.progress.reports)
        wishes = np.array((self._asked(), self._is_due(step)), np.int32)
        self._comm.Allreduce(MPI.IN_PLACE, wishes, MPI.MAX)
        stop, due = wishes
        trouble = self.write(moment) if stop or due else ""
        if not stop:
            return trouble
        where = f"{self._folder}: stopped after step {step}, t = {moment.state.t:g} s"
        if trouble:
            raise WriteError(f"{where}; {trouble}")
        raise Interrupted(f"{where}{self.hint}")

    @property
    def hint(self) -> str:
        """How to go on from a checkpoint, to be appended to a sentence."""
        if self._folder is None:
            return ""
        return f"; 'contactfem resume {self._folder}' goes on from there"

    def finish(self, moment: RunState) -> str:
        """Write the end of a run that has written checkpoints before, so that it can be extended.

        Collective; argument and result as for `visit`.
        """
        return self.write(moment) if self._any else ""

    def write(self, moment: RunState) -> str:
        """Write a checkpoint now; collective. Argument and result as for `visit`."""
        if self._folder is None:
            return ""
        trouble = ""
        with self._timers.book("output"):
            arrays = snapshot(moment.discretisation, moment.state, moment.before)
            if self._comm.rank == 0:
                seconds = self._timers.seconds | {"total": time.perf_counter() - self._started}
                checkpoint = Checkpoint(self._origin, moment.progress, seconds, arrays)
                try:
                    write_checkpoint(self._folder, checkpoint)
                except OSError as error:
                    trouble = f"{self._folder / NAME}: not written: {error.strerror}"
            self._step, self._time = len(moment.progress.reports), time.monotonic()
            self._any = True
            return str(self._comm.bcast(trouble))

    def _is_due(self, step: int) -> bool:
        """Whether it is time for a checkpoint; the clock that counts is the first rank's."""
        if self._step < 0:
            self._step = step  # where a run starts nothing is lost
        if step == self._step:
            return False
        if self._every is not None and step - self._step >= self._every:
            return True
        interval = self._interval if self._any else min(self._interval, FIRST)
        return self._comm.rank == 0 and time.monotonic() - self._time >= interval
