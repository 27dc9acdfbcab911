"""Ringing: a scheme without L-stability turns round in every step what is much faster than it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from contactfem.time_schemes import TimeScheme

STEPS = 2  # that have to alternate before it counts as ringing
OPPOSITE = -0.5  # cosine of successive increments at or below which they alternate
HARDLY = 0.7  # share of an increment that is left after a step: a tenth after more than six steps
NEGLIGIBLE = 1e-6  # share of the largest increment below which nothing is left to ring


@dataclass(frozen=True)
class Increment:
    """Change Δ_n of the temperature from one stage of the time scheme to the next.

    Attributes:
        norm: sqrt((Δ_n, Δ_n)_M).
        inner: (Δ_n, Δ_n-1)_M, with the increment before; 0 for the first one.
    """

    norm: float
    inner: float


@dataclass(frozen=True)
class Increments:
    """What is kept of the increments from step to step.

    Attributes:
        last: Δ_n itself, an array per body [K]; empty before the first.
        recent: those of the last steps, oldest first.
        largest: norm of the largest one since the start.
    """

    last: tuple[npt.NDArray[np.float64], ...] = ()
    recent: tuple[Increment, ...] = ()
    largest: float = 0.0


@dataclass(frozen=True)
class Ringing:
    """The temperature alternates from step to step with hardly any decay.

    Attributes:
        scheme: name of the scheme.
        left: share of an increment that is left after a step [-].
    """

    scheme: str
    left: float

    def __str__(self) -> str:
        return (
            f"the temperature rings: it turns round in every step and {100.0 * self.left:.3g} % of"
            f" its change is left after a step; {self.scheme} does not damp what is much faster"
            " than a step, an L-stable scheme such as dG(1) does"
        )


def ringing(scheme: TimeScheme, increments: Sequence[Increment], largest: float) -> Ringing | None:
    """Tell whether the last steps ring: Δ_n·Δ_n-1 / |Δ_n||Δ_n-1| <= -1/2, |Δ_n| >= 0.7 |Δ_n-s|.

    For all increments of two steps. With s stages per step an increment is compared with that of
    the same stage one step earlier. A load that is resolved in time turns round at its peaks
    alone; what decays faster than by 0.7 in a step is gone by itself.

    Args:
        scheme: that made the steps.
        increments: from stage to stage, oldest first; no more than those of the last three steps
            are looked at, and with fewer nothing is said.
        largest: norm of the largest increment since the start, of which the last ones have to be
            more than a millionth.

    Returns:
        What was found, None if nothing rings.
    """
    stages = len(scheme.nodes)
    if scheme.l_stable or len(increments) < (STEPS + 1) * stages:
        return None
    recent = increments[-(STEPS + 1) * stages :]
    if min(increment.norm for increment in recent) <= NEGLIGIBLE * largest:
        return None
    left = min(
        now.norm / before.norm
        for before, now in zip(recent[:-stages], recent[stages:], strict=True)
    )
    alternates = all(
        now.inner <= OPPOSITE * now.norm * before.norm
        for before, now in zip(recent[stages - 1 :], recent[stages:], strict=False)
    )
    return Ringing(scheme.name, left) if alternates and left >= HARDLY else None
