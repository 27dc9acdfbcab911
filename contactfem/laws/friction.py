"""Friction laws: the largest traction and its slopes."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from contactfem.common.time_table import Table
from contactfem.common.typing import Floats
from contactfem.errors import CaseError


class SlipState(NamedTuple):
    """What friction may depend on: pressure [Pa], slip speed >= 0 [m/s], temperature [K]."""

    pressure: Floats
    speed: Floats
    temperature: Floats


class FrictionBound(NamedTuple):
    """Largest traction b [Pa] with db/dp [-] and db/dv [Pa s/m]."""

    value: Floats
    by_pressure: Floats
    by_speed: Floats


NO_BOUND = 1e200  # a traction that nothing reaches [Pa], whose square is still finite
FrictionLaw = Callable[[SlipState], FrictionBound]


@dataclass(frozen=True)
class Coulomb:
    """Coulomb's law, b = μ p."""

    coefficient: float

    def __str__(self) -> str:
        return f"Coulomb {self.coefficient:g}"

    def __call__(self, at: SlipState) -> FrictionBound:
        """Limit of the traction at some nodes."""
        p = at.pressure
        return FrictionBound(
            self.coefficient * p, np.full_like(p, self.coefficient), np.zeros_like(p)
        )


@dataclass(frozen=True)
class Tresca:
    """Tresca's law, b = k wherever there is contact [Pa]."""

    shear_limit: float

    def __str__(self) -> str:
        return f"Tresca {self.shear_limit:g} Pa"

    def __call__(self, at: SlipState) -> FrictionBound:
        """Limit of the traction at some nodes."""
        zero = np.zeros_like(at.pressure)
        return FrictionBound(np.where(at.pressure > 0.0, self.shear_limit, 0.0), zero, zero)


@dataclass(frozen=True)
class VariableCoulomb:
    """Coulomb's law with a coefficient from a table, b = μ(y) p.

    Attributes:
        variable: y, a field of `SlipState`.
        coefficient: μ over y [Pa, m/s or K]: linear between the points, held outside.
    """

    variable: Literal["pressure", "speed", "temperature"]
    coefficient: Table

    def __str__(self) -> str:
        return f"Coulomb with a coefficient of {self.variable}"

    def __call__(self, at: SlipState) -> FrictionBound:
        """Limit of the traction at some nodes."""
        y, p = getattr(at, self.variable), at.pressure
        points, values = np.array(self.coefficient.times), np.array(self.coefficient.values)
        mu = np.interp(y, points, values)
        piece = np.clip(np.searchsorted(points, y, side="right") - 1, 0, len(points) - 2)
        inside = (y >= points[0]) & (y < points[-1])
        slope = np.where(inside, (np.diff(values) / np.diff(points))[piece], 0.0)
        by_pressure = mu + (slope * p if self.variable == "pressure" else 0.0)
        by_speed = slope * p if self.variable == "speed" else np.zeros_like(p)
        return FrictionBound(mu * p, by_pressure, by_speed)


@dataclass(frozen=True)
class UserFriction:
    """A user's law, b, db/dp and db/dv as a function of (p, v, ϑ).

    Attributes:
        name: what it is called.
        function: from pressure (n,) [Pa], slip speed (n,) [m/s] and temperature (n,) [K] to the
            largest traction [Pa] and its two slopes [-] and [Pa s/m].
    """

    name: str
    function: Callable[[Floats, Floats, Floats], tuple[Floats, Floats, Floats]]

    def __str__(self) -> str:
        return f"by {self.name}"

    def __call__(self, at: SlipState) -> FrictionBound:
        """Limit of the traction at some nodes."""
        b, by_pressure, by_speed = self.function(*at)
        shape = at.pressure.shape
        return FrictionBound(
            np.broadcast_to(b, shape),
            np.broadcast_to(by_pressure, shape),
            np.broadcast_to(by_speed, shape),
        )

    def check(self) -> None:
        """Try it at some pressures, before it is needed inside of a solver.

        Raises:
            CaseError: It cannot be called, or does not give three arrays of finite numbers.
        """
        at = SlipState(np.array([0.0, 1e3, 1e6, 1e9]), np.zeros(4), np.zeros(4))
        try:
            limit = self(at)
            finite = all(bool(np.isfinite(values).all()) for values in limit)
        except Exception as error:
            raise CaseError(
                f"{self.name}: gives no limit with its two slopes for pressures, slip speeds and "
                f"temperatures: {type(error).__name__}: {error}"
            ) from None
        if not finite:
            raise CaseError(f"{self.name}: gives a value that is not finite")


def frictionless(at: SlipState) -> FrictionBound:
    """No friction, b = 0."""
    zero = np.zeros_like(at.pressure)
    return FrictionBound(zero, zero, zero)


def rough(at: SlipState) -> FrictionBound:
    """Rough contact: what touches never slips, b beyond all tractions."""
    zero = np.zeros_like(at.pressure)
    return FrictionBound(np.full_like(zero, NO_BOUND), zero, zero)
