"""Signals that stop a run."""

import os
import signal
from collections.abc import Mapping
from types import FrameType, TracebackType
from typing import Self

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)  # mpirun passes the last one on


class StopSignals:
    """While entered, whether this process was asked to stop; called, it says so.

    Args:
        tell: Whether to say on standard error what becomes of the first signal.
    """

    def __init__(self, tell: bool) -> None:
        self._tell, self._asked = tell, False
        self._before: Mapping[int, object] = {}

    def __enter__(self) -> Self:
        """Take over the signals."""
        self._before = {number: signal.signal(number, self._note) for number in SIGNALS}
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Give the signals back."""
        for number, handler in self._before.items():
            signal.signal(number, handler)  # type: ignore[arg-type]

    def __call__(self) -> bool:
        """Whether a signal has come."""
        return self._asked

    def _note(self, number: int, frame: FrameType | None) -> None:
        if self._asked:
            signal.signal(number, signal.SIG_DFL)
            os.kill(os.getpid(), number)
        self._asked = True
        if self._tell:  # not through Python's streams, which may be in the middle of something
            name = signal.Signals(number).name
            text = f"{name}: finishing this step and writing the state; once more to end at once\n"
            os.write(2, text.encode())
