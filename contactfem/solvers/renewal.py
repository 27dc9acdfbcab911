"""When an old factor is worth renewing: a rule of residuals alone, so that runs can be repeated."""

import math
from collections.abc import Sequence

PRICE = 2.0  # iterations with an old factor that a new one costs, or less
SLOW = 0.5  # reduction of the residual in one iteration that no old factor is kept for
SLOPE = 5.0  # with a factor of a state with residual r, later iterations reduce by this times r


def worth_renewing(residuals: Sequence[float], tolerance: float) -> bool:
    """Whether a new factor shortens what is left of Newton's method.

    With the rate q of the last iteration log(tolerance / r) / log(q) iterations are left; with that
    of a new factor, which gets the better the nearer the solution is, fewer, but it has its price.

    Args:
        residuals: Scaled residuals of the solve so far [-].
        tolerance: What they must come to [-].
    """
    if len(residuals) < 2 or residuals[-1] <= tolerance:
        return False
    last = residuals[-1]
    rate = last / residuals[-2]
    if not rate < SLOW:
        return True
    new = SLOPE * last
    if new >= rate:
        return False
    left = math.log(last / tolerance)
    return left / -math.log(new) + PRICE < left / -math.log(rate)
