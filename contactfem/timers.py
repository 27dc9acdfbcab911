"""Wall time by phase."""

import time
from collections.abc import Iterator
from contextlib import contextmanager


class Timers:
    """Adds up seconds by name; a dot in a name makes a part of a phase ("contact.search")."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

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
