"""Pairs of bounding boxes that meet, by a tree."""

import numpy as np

from contactfem.common.typing import Floats, Ints

FEW = 4  # boxes that are paired as they come


class BoxTree:
    """Binary tree of bounding boxes, by median splits along the longest side.

    How many boxes there are of which size does not matter, nor how they lie.
    """

    def __init__(self, low: Floats, high: Floats) -> None:
        """Build the tree.

        Args:
            low: lower corners of at least one box [m], (n, dim).
            high: upper corners [m], (n, dim).
        """
        self._order = _split(0.5 * (low + high))
        # what fills the tree up to a power of two is boxes that meet nothing
        filler = self._order >= len(low)
        level = (
            np.where(filler, np.inf, low[self._order % len(low)].T),
            np.where(filler, -np.inf, high[self._order % len(low)].T),
        )
        self._levels = [level]
        while level[0].shape[1] > 1:
            level = (
                np.minimum(level[0][:, ::2], level[0][:, 1::2]),
                np.maximum(level[1][:, ::2], level[1][:, 1::2]),
            )
            self._levels.insert(0, level)

    def meeting(self, low: Floats, high: Floats) -> tuple[Ints, Ints]:
        """Pairs of another box and a box of the tree that have a point in common.

        Args:
            low: lower corners of the other boxes [m], (m, dim).
            high: upper corners [m], (m, dim).

        Returns:
            Numbers of the other box, ascending, and of the tree's box, (k,) each. The order of the
            pairs of one other box does not depend on the rest.
        """
        lows, highs = np.ascontiguousarray(low.T), np.ascontiguousarray(high.T)
        other: Ints = np.arange(len(low))
        node: Ints = np.zeros(len(low), dtype=np.int64)
        for level, (bottom, top) in enumerate(self._levels):
            if level:
                other = np.repeat(other, 2)
                node = np.repeat(2 * node, 2)
                node[1::2] += 1
            meets = np.ones(len(other), dtype=bool)
            for axis in range(len(lows)):
                meets &= lows[axis][other] <= top[axis][node]
                meets &= highs[axis][other] >= bottom[axis][node]
            other, node = other[meets], node[meets]
        return other, self._order[node]


def _split(centres: Floats) -> Ints:
    """Numbers of points in the order of the leaves, filled up to a power of two by larger ones."""
    n = len(centres)
    size = 1 << (n - 1).bit_length()
    padded = np.concatenate([centres, np.broadcast_to(centres[-1:], (size - n, centres.shape[1]))])
    columns = np.ascontiguousarray(padded.T)
    order = np.arange(size)[None, :]
    while order.shape[1] > FEW:
        x = columns[:, order]
        key = x[np.argmax(np.ptp(x, axis=2), axis=0), np.arange(len(order))]
        half = order.shape[1] // 2
        parts = np.argpartition(key, half, axis=1)
        order = np.take_along_axis(order, parts, axis=1).reshape(-1, half)
    return order.ravel()
