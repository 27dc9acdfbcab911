"""Wall time by phase."""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class Timers:
    """Adds up seconds by name; a dot in a name makes a part of a phase ("contact.search").

    Attributes:
        seconds: By name.
        counts: How often each was booked.
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.counts: dict[str, int] = {}

    @contextmanager
    def book(self, name: str) -> Iterator[None]:
        """Book the time spent inside under a name."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.add(name, time.perf_counter() - start)

    def add(self, name: str, seconds: float) -> None:
        """Book some seconds under a name."""
        self.seconds[name] = self.seconds.get(name, 0.0) + seconds
        self.counts[name] = self.counts.get(name, 0) + 1


def seconds_since_start() -> float:
    """Wall time since this process was started [s]; CPU time where the system does not tell."""
    try:
        # the field after the command's name, which may hold spaces, is number 3; we want 22
        ticks = int(Path("/proc/self/stat").read_text().rpartition(")")[2].split()[19])
        up = float(Path("/proc/uptime").read_text().split()[0])
    except (OSError, ValueError, IndexError):
        return time.process_time()
    return max(up - ticks / os.sysconf("SC_CLK_TCK"), 0.0)
