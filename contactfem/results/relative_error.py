"""Relative errors: how large an estimated error is beside the solution, (40)."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class RelativeError:
    """An estimated error e of a discrete solution v, by the squares of their norms.

    Squares add up: over cells, bodies, and steps.

    Attributes:
        error_square: ‖e‖².
        norm_square: ‖v‖².
    """

    error_square: float
    norm_square: float

    def __add__(self, other: "RelativeError") -> "RelativeError":
        return RelativeError(
            self.error_square + other.error_square, self.norm_square + other.norm_square
        )

    @property
    def error(self) -> float:
        """‖e‖."""
        return math.sqrt(self.error_square)

    @property
    def eta(self) -> float:
        """η = ‖e‖ / √(‖e‖² + ‖v‖²), the ratio of norms that tolerances refer to."""
        return math.sqrt(self.eta_printed)

    @property
    def eta_printed(self) -> float:
        """η² = ‖e‖² / (‖e‖² + ‖v‖²), as (40) is printed: of squares, without the root."""
        total = self.error_square + self.norm_square
        return self.error_square / total if total > 0.0 else 0.0


def error_ratio(eta: float) -> float:
    """‖e‖/‖v‖ of a relative error η, which grows as a power of the size where η saturates at 1.

    Args:
        eta: η in [0, 1].

    Returns:
        η / √(1 - η²).
    """
    return eta / math.sqrt(1.0 - eta**2) if eta < 1.0 else math.inf
