"""Values over place and time."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from contactfem.common.time_table import Table
from contactfem.common.typing import Floats

PlaceTime = Callable[[Floats, float], Floats]  # of places (dim, n) and a time: values (n,)


@dataclass(frozen=True)
class Profile:
    """A value over one coordinate: linear between places, held before and after.

    Attributes:
        axis: 0, 1 or 2 for x, y or z of the reference configuration.
        places: Ascending [m].
        values: One per place.
        factor: That the values are multiplied with over time [-].
    """

    axis: int
    places: tuple[float, ...]
    values: tuple[float, ...]
    factor: Table

    @property
    def times(self) -> tuple[float, ...]:
        """Times at which it has a kink [s]; none for values that do not change."""
        return self.factor.times

    def __call__(self, x: Floats, t: float) -> Floats:
        """Values at places (dim, n) and a time [s], (n,)."""
        return np.asarray(np.interp(x[self.axis], self.places, self.values) * self.factor(t))


@dataclass(frozen=True)
class Varying:
    """A value over place and time, as equations take it.

    Attributes:
        function: Of places (dim, n) [m] and time [s].
        ramped: Whether it is reached linearly over the first step, as constants are.
    """

    function: PlaceTime
    ramped: bool = False

    def __call__(self, x: Floats, t: float) -> Floats:
        """Values at places (dim, n) and a time [s], (n,)."""
        return self.function(x, t)

    def at(self, x: Floats, t: float, ramp_end: float) -> Floats:
        """Values at places; those that do not change are reached linearly over the first step.

        Args:
            x: Places in the reference configuration [m], (n, dim).
            t: Time [s].
            ramp_end: End of the first step [s].

        Returns:
            The values, (n,).
        """
        factor = min(1.0, t / ramp_end) if self.ramped else 1.0
        return factor * np.asarray(self.function(np.ascontiguousarray(x.T), t))
