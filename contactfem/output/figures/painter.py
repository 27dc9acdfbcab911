"""Draws the pictures of a run in a process beside it."""

from __future__ import annotations

import pickle
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from contactfem.results.data import RunResult


class Painter:
    """A process that loads what it draws with while the run goes on, then draws its results.

    The result goes through a file: PETSc ends a process that writes to a pipe nobody reads. The
    other process begins when its input ends, and without a result it ends with the run.
    """

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="contactfem-")
        self._job = Path(self._folder.name) / "result"
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "contactfem.output.figures.painter", str(self._job)],
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
        sent = True
        try:
            self._job.write_bytes(pickle.dumps((result, folder.absolute())))
        except (pickle.PicklingError, AttributeError, TypeError, OSError):
            sent = False  # a function of a script is known there only; or there is no room
            self._job.unlink(missing_ok=True)
        self.close()
        if not sent or self._process.returncode != 0:
            from contactfem.output.figures.all_figures import draw_all

            draw_all(result, folder)

    def close(self) -> None:
        """Let it draw what it was given, if anything, and end."""
        if self._process.stdin is not None:
            self._process.stdin.close()
        self._process.wait()
        self._folder.cleanup()


def main() -> None:
    """Load what draws, wait for the end of the input, and draw the result that is there then."""
    import matplotlib.backends.backend_agg
    import matplotlib.collections
    import matplotlib.figure
    import matplotlib.tri  # noqa: F401  loaded while the run goes on

    from contactfem.output.figures.all_figures import draw_all

    sys.stdin.buffer.read()
    job = Path(sys.argv[1])
    if job.exists():
        draw_all(*pickle.loads(job.read_bytes()))


if __name__ == "__main__":
    main()
