"""Temperatures of cases over place x (3, n) [m] and time t [s], in K."""

from contactfem.common.typing import Floats

LENGTH = 10e-3  # of Barber's rod [m]
UNSTABLE = 61.41332446  # surface temperature of its unstable steady state [K]


def barber_warm(x: Floats, t: float) -> Floats:
    """Barber's rod, one per cent warmer than its unstable steady state."""
    return 1.01 * barber(x, t)


def barber_cool(x: Floats, t: float) -> Floats:
    """Barber's rod, one per cent cooler than its unstable steady state."""
    return 0.99 * barber(x, t)


def barber(x: Floats, t: float) -> Floats:
    """Unstable steady state of Barber's rod, linear from the cold end at y = 0."""
    return UNSTABLE * x[1] / LENGTH
