"""Status of nonmortar nodes, and the active set."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contactfem.common.typing import Floats


class Status(IntEnum):
    """Contact status of a nonmortar node."""

    NONE = -1  # carries no multiplier
    OPEN = 0
    STICK = 1
    SLIP = 2


class ActiveSet(NamedTuple):
    """Status of every node and the direction of its slip (-1, 0, 1)."""

    status: NDArray[np.int8]
    direction: Floats
