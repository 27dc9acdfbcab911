"""Status of nonmortar nodes, and the active set."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contactfem.common.typing import Bools, Floats


class Status(IntEnum):
    """Contact status of a nonmortar node."""

    NONE = -1  # carries no multiplier
    OPEN = 0
    STICK = 1
    SLIP = 2


class ActiveSet(NamedTuple):
    """Status of every node (n,) and the unit vector that it slips along, else zero, (n, dim)."""

    status: NDArray[np.int8]
    direction: Floats

    @property
    def active(self) -> Bools:
        """Nodes in contact, (n,)."""
        return np.asarray(self.status > Status.OPEN)

    def turned_from(self, other: "ActiveSet") -> Bools:
        """Nodes that slip the other way round than in another active set, (n,)."""
        return np.asarray(np.einsum("ji,ji->j", self.direction, other.direction) < 0.0)

    def differs_from(self, other: "ActiveSet") -> Bools:
        """Nodes of another status, or that slip the other way round, (n,)."""
        return np.asarray((self.status != other.status) | self.turned_from(other))
