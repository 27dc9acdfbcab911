"""Put a case file through the program, and hold it to its promises whatever the file says."""

import contextlib
import io
import signal
import warnings
from collections.abc import Iterator
from pathlib import Path

from contactfem.cli.main import main
from contactfem.errors import ExitCode

LONGEST = 600  # characters of a message's line
PATIENCE = 90.0  # seconds that reading a small case may take on a busy machine


class HangError(BaseException):
    """It took longer than it may; not an Exception, so that nobody catches it on the way."""


@contextlib.contextmanager
def within(seconds: float) -> Iterator[None]:
    """Limit of time for a block in the main thread, inside of pytest's own limit."""

    def ring(_number: int, _frame: object) -> None:
        raise HangError(f"still not done after {seconds:g} s")

    handler = signal.signal(signal.SIGALRM, ring)
    rest, _ = signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, rest)
        signal.signal(signal.SIGALRM, handler)


def check(path: Path) -> str:
    """What `contactfem check` says about a case file: its complaints, or nothing if it is right.

    No exception, no warning, exit code 0 or 2, and then nothing but lines about the file.
    """
    out, err = io.StringIO(), io.StringIO()
    with within(PATIENCE), warnings.catch_warnings():
        warnings.simplefilter("error")
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = main(["check", str(path)])
    assert code in (ExitCode.DONE, ExitCode.BAD_CASE)
    text = (out if code == ExitCode.DONE else err).getvalue()
    assert text
    assert not (err if code == ExitCode.DONE else out).getvalue()
    assert all(c.isprintable() for line in text.split("\n") for c in line), ascii(text)
    if code == ExitCode.DONE:
        return ""
    for line in text.splitlines():
        assert line.startswith(f"{path}: "), ascii(line)
        assert 0 < len(line) - len(f"{path}: ") <= LONGEST, ascii(line)
    return text
