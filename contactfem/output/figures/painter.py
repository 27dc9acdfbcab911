"""Draws the pictures of a run in a process beside it."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from contactfem.results.data import RunResult


class Painter:
    """A process that loads what it draws with while the run goes on, then draws its results.

    Without a result it ends as soon as the run does.
    """

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "contactfem.output.figures.painter"],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    def draw(self, result: RunResult, folder: Path) -> None:
        """Draw all pictures; in this process, with its errors, if the other one cannot.

        Args:
            result: the run.
            folder: where they go; it exists.

        Raises:
            OSError: they cannot be written.
        """
        try:
            self._process.communicate(pickle.dumps((result, folder.absolute())))
        except (pickle.PicklingError, AttributeError, TypeError, BrokenPipeError):
            self._process.kill()  # a function of a script is known there only
        if self._process.wait() != 0:
            from contactfem.output.figures.all_figures import draw_all

            draw_all(result, folder)

    def close(self) -> None:
        """Let it end, without pictures."""
        if self._process.stdin is not None:
            self._process.stdin.close()
        self._process.wait()


def main() -> None:
    """Wait for a result, and draw it."""
    import matplotlib.backends.backend_agg
    import matplotlib.collections
    import matplotlib.figure
    import matplotlib.tri  # noqa: F401  loaded while the run goes on

    from contactfem.output.figures.all_figures import draw_all

    try:
        result, folder = pickle.load(sys.stdin.buffer)
    except EOFError:
        return
    draw_all(result, folder)


if __name__ == "__main__":
    main()
