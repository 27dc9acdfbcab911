"""Contact laws at a node as trial states: gap and pressure, and Coulomb friction.

They know nothing of segments or meshes; every argument is an array over nodes.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contactfem.common.time_table import Table
from contactfem.common.typing import Floats
from contactfem.errors import CaseError

RIM = 0.5  # covered share of a node's facets below which the rim rule acts
RIM_COMPLIANCE = 0.1


class Status(IntEnum):
    """Contact status of a nonmortar node."""

    NONE = -1  # carries no multiplier
    OPEN = 0
    STICK = 1
    SLIP = 2


class Trial(NamedTuple):
    """Status of every node and the direction of its slip (-1, 0, 1)."""

    status: NDArray[np.int8]
    direction: Floats


def contact_scale(
    h_nonmortar: Floats, E_nonmortar: float, h_mortar: float, E_mortar: float
) -> Floats:
    """Scale between gap and pressure, c = 1 / (h_nm/E_nm + h_m/E_m), of the order of the stiffness.

    Args:
        h_nonmortar: Facet size at the nonmortar nodes [m].
        E_nonmortar: Young's modulus [Pa].
        h_mortar: Facet size of the mortar side [m].
        E_mortar: Young's modulus [Pa], infinite for a rigid obstacle.

    Returns:
        c [Pa/m], same shape as h_nonmortar.
    """
    return np.asarray(1.0 / (h_nonmortar / E_nonmortar + h_mortar / E_mortar))


def rim_compliance(cover: Floats, c: Floats) -> tuple[Floats, Floats]:
    """Compliance that ties a barely covered node to its neighbour, κ = (0.1/c) (1/(2f) - 1).

    For f < 1/2. Without it the pressure of a node is unbounded as its cover f vanishes.

    Args:
        cover: Covered share f of the node's facets [-].
        c: Scale of `contact_scale` [Pa/m].

    Returns:
        κ [m/Pa] and dκ/df [m/Pa]; zero where f >= 1/2 or nothing is covered.
    """
    rim = (cover > 0.0) & (cover < RIM)
    f = np.where(rim, cover, RIM)
    a = RIM_COMPLIANCE / c
    return a * (0.5 / f - 1.0), np.where(rim, -0.5 * a / f**2, 0.0)


class Tie(NamedTuple):
    """Compliance that ties a multiplier to a value: 1/ε to an estimate, κ to a neighbour's."""

    compliance: Floats
    value: Floats


def trial(multiplier: Floats, motion: Floats, c: Floats, ties: Sequence[Tie]) -> Floats:
    """Trial multiplier λ* = (λ + Σ c a v + c m) / (1 + Σ c a); p* = p - c g without ties.

    The condition of a multiplier is m = Σ a (λ - v), m = -g for pressure and s for traction.
    λ* tells its status whatever the size of a: with a vanishing cover (κ without bound) it becomes
    the neighbour's value, so round-off in λ does not decide, and a penalty (a = 1/ε_N) needs no
    other iteration than exact contact (a = 0).

    Args:
        multiplier: λ, pressure or traction [Pa].
        motion: m, -g_j / D_jj or slip [m].
        c: Scale [Pa/m].
        ties: Compliances a [m/Pa] and values v [Pa].

    Returns:
        λ* [Pa].
    """
    weight, value = np.ones_like(c), multiplier + c * motion
    for tie in ties:
        weight = weight + c * tie.compliance
        value = value + c * tie.compliance * tie.value
    return np.asarray(value / weight)


class SlipState(NamedTuple):
    """What friction may depend on: pressure [Pa], slip speed >= 0 [m/s], temperature [K]."""

    pressure: Floats
    speed: Floats
    temperature: Floats


class Limit(NamedTuple):
    """Largest traction b [Pa] with db/dp [-] and db/dv [Pa s/m]."""

    value: Floats
    by_pressure: Floats
    by_speed: Floats


FrictionLaw = Callable[[SlipState], Limit]


@dataclass(frozen=True)
class Coulomb:
    """Coulomb's law, b = μ p."""

    coefficient: float

    def __str__(self) -> str:
        return f"Coulomb {self.coefficient:g}"

    def __call__(self, at: SlipState) -> Limit:
        """Limit of the traction at some nodes."""
        p = at.pressure
        return Limit(self.coefficient * p, np.full_like(p, self.coefficient), np.zeros_like(p))


@dataclass(frozen=True)
class Tresca:
    """Tresca's law, b = k wherever there is contact [Pa]."""

    shear_limit: float

    def __str__(self) -> str:
        return f"Tresca {self.shear_limit:g} Pa"

    def __call__(self, at: SlipState) -> Limit:
        """Limit of the traction at some nodes."""
        zero = np.zeros_like(at.pressure)
        return Limit(np.where(at.pressure > 0.0, self.shear_limit, 0.0), zero, zero)


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

    def __call__(self, at: SlipState) -> Limit:
        """Limit of the traction at some nodes."""
        y, p = getattr(at, self.variable), at.pressure
        points, values = np.array(self.coefficient.times), np.array(self.coefficient.values)
        mu = np.interp(y, points, values)
        piece = np.clip(np.searchsorted(points, y, side="right") - 1, 0, len(points) - 2)
        inside = (y >= points[0]) & (y < points[-1])
        slope = np.where(inside, (np.diff(values) / np.diff(points))[piece], 0.0)
        by_pressure = mu + (slope * p if self.variable == "pressure" else 0.0)
        by_speed = slope * p if self.variable == "speed" else np.zeros_like(p)
        return Limit(mu * p, by_pressure, by_speed)


@dataclass(frozen=True)
class GivenFriction:
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

    def __call__(self, at: SlipState) -> Limit:
        """Limit of the traction at some nodes."""
        b, by_pressure, by_speed = self.function(*at)
        shape = at.pressure.shape
        return Limit(
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


def frictionless(at: SlipState) -> Limit:
    """No friction, b = 0."""
    zero = np.zeros_like(at.pressure)
    return Limit(zero, zero, zero)


def stick_or_slip(p_trial: Floats, t_trial: Floats, limit: Floats, rubs: bool) -> Trial:
    """Status of unilateral contact with friction: open, slip if |t*| > b, else stick.

    Args:
        p_trial: p* [Pa].
        t_trial: t* [Pa].
        limit: Largest traction b at p* [Pa].
        rubs: Whether there is friction; without every node in contact slips without direction.

    Returns:
        Status and slip direction.
    """
    slides = np.abs(t_trial) > limit if rubs else np.ones(len(t_trial), bool)
    status = np.where(p_trial <= 0.0, Status.OPEN, np.where(slides, Status.SLIP, Status.STICK))
    direction = np.sign(t_trial) if rubs else np.zeros(len(t_trial))
    return Trial(status.astype(np.int8), np.where(status == Status.SLIP, direction, 0.0))
