"""Values over time."""

from bisect import bisect_right
from dataclasses import dataclass


@dataclass(frozen=True)
class Table:
    """A value over time: linear between the given times, held before and after.

    Attributes:
        times: ascending [s]; empty for a constant.
        values: one per time, or the constant.
    """

    times: tuple[float, ...]
    values: tuple[float, ...]

    def __call__(self, t: float) -> float:
        """Value at a time [s]."""
        after = bisect_right(self.times, t)
        if after == 0:
            return self.values[0]
        if after == len(self.times):
            return self.values[-1]
        t0, t1 = self.times[after - 1], self.times[after]
        v0, v1 = self.values[after - 1], self.values[after]
        return v0 + (v1 - v0) * ((t - t0) / (t1 - t0))

    def at(self, t: float, ramp_end: float) -> float:
        """Value at a time; a constant is reached linearly over the first step.

        Args:
            t: time [s].
            ramp_end: end of the first step [s].

        Returns:
            The value.
        """
        if self.times:
            return self(t)
        return self.values[0] * min(1.0, t / ramp_end)


def constant(value: float) -> Table:
    """Table of one value for all times."""
    return Table((), (value,))
