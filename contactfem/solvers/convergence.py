"""Whether Newton's method has converged: residual, active set, and why it cannot."""

from collections.abc import Sequence

import numpy as np

from contactfem.common.typing import Floats
from contactfem.contact.state import ContactState


class ActiveSets:
    """Active sets of the iterations of one solve.

    Two are the same if every node has the same status and slips the same way: its direction makes
    an acute angle with the first one that the node had.
    """

    def __init__(self) -> None:
        self._first: list[Floats] = []
        self._keys: list[bytes] = []

    def add(self, states: Sequence[ContactState]) -> None:
        """Take that of one more iteration."""
        directions = [c.active_set.direction for c in states]
        if not self._first:
            self._first = [d.copy() for d in directions]
        key = b""
        for c, first, d in zip(states, self._first, directions, strict=True):
            none = ~first.any(axis=1)
            first[none] = d[none]
            sense = np.sign(np.einsum("ji,ji->j", d, first)).astype(np.int8)
            key += c.status.tobytes() + sense.tobytes()
        self._keys.append(key)

    @property
    def unchanged(self) -> bool:
        """Whether the last one is that of the iteration before."""
        return len(self._keys) > 1 and self._keys[-1] == self._keys[-2]

    @property
    def settled(self) -> bool:
        """Whether none was there before the last one that differs from it."""
        return self.unchanged or len(self._keys) == 1

    @property
    def comes_back(self) -> bool:
        """Whether the last one has been there before, and was left: the iteration would cycle."""
        left = len(self._keys) > 1 and not self.unchanged
        return left and self._keys.count(self._keys[-1]) > 1
