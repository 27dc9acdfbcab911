"""What Newton's method asks of a linear solver."""

from collections.abc import Sequence
from dataclasses import dataclass

from contactfem.common.typing import Floats
from contactfem.contact.state import ContactState


@dataclass(frozen=True)
class Iterate:
    """Where Newton's method is.

    Attributes:
        conditions: Contact conditions of every interface.
        jumps: Of `System.advance` in the first iteration, else all None.
        damping: Share of the coming step that is taken.
        residuals: Scaled residuals of the solve so far [-].
        tolerance: What they must come to [-].
        settled: Whether the contact status is that of the iteration before.
    """

    conditions: Sequence[ContactState]
    jumps: Sequence[Floats | None]
    damping: float
    residuals: Sequence[float]
    tolerance: float
    settled: bool
