"""Ringing of time schemes without L-stability."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from contactfem.heat.time_schemes import TimeScheme

STEPS = 2  # that have to alternate before it counts as ringing
OPPOSITE = -0.5  # cosine of successive increments at or below which they alternate
HARDLY = 0.7  # share of an increment that is left after a step: a tenth after more than six steps
NEGLIGIBLE = 1e-6  # share of the largest increment below which nothing is left to ring


ALTERNATIONS = 3  # turns in a row of one temperature that count as ringing
KEPT = 0.5  # share of a turn that the next one has at least
VISIBLE = 1e-3  # amplitude over the range of all temperatures from which it is said
COLD = 1e-9  # range of temperatures [K] that is round-off


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
        zigzags: of single temperatures, per body; empty before the first step.
    """

    last: tuple[npt.NDArray[np.float64], ...] = ()
    recent: tuple[Increment, ...] = ()
    largest: float = 0.0
    zigzags: tuple["Zigzag", ...] = ()


@dataclass(frozen=True)
class Zigzag:
    """How often the rate of each temperature of a body has turned round, step by step.

    Where a large smooth change hides it from the norms of increments, ringing is local: at the
    first nodes below a surface that was heated suddenly.

    Attributes:
        rate: of the last step (n,) [K/s].
        turn: its change from that of the step before (n,) [K/s].
        count: how many turns in a row had the opposite sign and half the size at least (n,).
    """

    rate: npt.NDArray[np.float64]
    turn: npt.NDArray[np.float64]
    count: npt.NDArray[np.float64]

    @classmethod
    def begun(cls, rate: npt.NDArray[np.float64]) -> "Zigzag":
        """After the first step."""
        return cls(rate, np.zeros_like(rate), np.zeros_like(rate))

    def followed(self, rate: npt.NDArray[np.float64]) -> "Zigzag":
        """After one more step, with its rate (n,) [K/s]."""
        turn = rate - self.rate
        opposite = (turn * self.turn < 0.0) & (np.abs(turn) >= KEPT * np.abs(self.turn))
        return Zigzag(rate, turn, np.where(opposite, self.count + 1.0, 0.0))

    def amplitude(self, dt: float) -> float:
        """Largest amplitude of what rings, ±a with a turn of 4a/dt [K].

        Args:
            dt: length of the last step [s].
        """
        rings = self.count >= ALTERNATIONS
        return float(np.max(np.abs(self.turn), where=rings, initial=0.0)) * dt / 4.0


def local_ringing(scheme: TimeScheme, amplitude: float, span: float) -> str:
    """Say that some temperatures ring, if their amplitude is more than 0.1 % of the range.

    Args:
        scheme: that made the steps.
        amplitude: largest one of all ranks [K].
        span: range of the temperatures [K].

    Returns:
        A sentence, empty if nothing rings.
    """
    if scheme.l_stable or span <= COLD or amplitude <= VISIBLE * span:
        return ""
    return (
        f"temperatures ring by up to {amplitude:.2g} K at some nodes; {scheme.name} does not damp"
        " what is much faster than a step: take smaller steps, or an L-stable scheme such as dG(1)"
    )


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
