"""Estimated error of a time step (37)-(39)."""

from contactfem.results.relative_error import RelativeError

RATE_SQUARE = 1.0 / 12.0  # mean of ((t - midpoint)/h)² over a step


def recovered_rate(since: float, older: float, newer: float) -> tuple[float, float]:
    """Weights (a, b) of the recovered rate ż* = a ż_older + b ż_newer, (37).

    A cG(1) solution has a constant rate ż_h in each step, which is superconvergent in the middle of
    it. The line (37) through these two values is the fit (38). (The integrals (39) are not: they
    also fit the line to where ż_h errs by O(h), and find an error too small by √3/2.)

    Args:
        since: Time since the steps met, negative in the older one [s].
        older: Length of the older step [s].
        newer: Length of the newer step [s].

    Returns:
        The weights [-].
    """
    b = (since + 0.5 * older) / (0.5 * (older + newer))
    return 1.0 - b, b


def time_error(
    change_square: float,
    rate_square: float,
    older: float,
    newer: float,
    least_rate_square: float = 0.0,
) -> RelativeError:
    """Error of the rate in the newer step: ∫ ‖ż* - ż_h‖² dt over it, with ∫ ‖ż_h‖² dt, (40).

    ż* - ż_h is linear and zero in the middle, hence ‖slope‖² h³/12, with
    slope = (ż_newer - ż_older) / ((h_older + h_newer)/2). The error of the older step has the same
    slope: exchange the lengths (and pass its rate). Only products enter, in whatever norm the
    caller chooses, such as that of the mass matrix, summed over all ranks and bodies.

    Args:
        change_square: ⟨ż_newer - ż_older, ż_newer - ż_older⟩.
        rate_square: ⟨ż, ż⟩ in the newer step.
        older: Length of the older step [s].
        newer: Length of the newer step [s].
        least_rate_square: Smallest ⟨ż, ż⟩ that errors are related to, such as the mean of the run
            so far: a body that has come to rest needs no small steps.

    Returns:
        The relative error.
    """
    slope_square = change_square / (0.5 * (older + newer)) ** 2
    rate = max(rate_square, least_rate_square)
    return RelativeError(RATE_SQUARE * slope_square * newer**3, rate * newer)
