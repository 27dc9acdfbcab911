"""Distances within which nonmortar facets look for the other side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contactfem.common.typing import Floats


@dataclass(frozen=True)
class SearchRange:
    """Distances along the normals within which the two sides of an interface find each other.

    Attributes:
        ahead: Largest gap [m]; infinite for any.
        behind: Largest overlap of every nonmortar facet [m], (k,); infinite for any.
    """

    ahead: float
    behind: Floats

    @staticmethod
    def within(radius: float, count: int) -> SearchRange:
        """The same radius [m] to both sides of `count` facets."""
        return SearchRange(radius, np.full(count, radius))

    def limited(self, x: Floats) -> SearchRange:
        """As far as it can matter for surfaces at the positions x [m], (n, 2)."""
        size = float(np.hypot(*np.ptp(x, axis=0)))
        return SearchRange(min(self.ahead, size), np.minimum(self.behind, size))
