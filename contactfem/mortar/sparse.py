"""Small sparse matrices of contact, without scipy's checks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from contactfem._kernels import ffi, lib
from contactfem.common.typing import Floats, Ints

Triplets = tuple[Ints, Ints, Floats]  # rows, columns and values; those at the same place add up


@dataclass(frozen=True)
class Sparse:
    """A matrix by rows; entries of a row may repeat a column, and add up.

    Attributes:
        starts: Where each row starts, (rows + 1,).
        columns: Of the entries.
        values: Of the entries.
        width: Number of columns.
    """

    starts: NDArray[np.int32]
    columns: NDArray[np.int32]
    values: Floats
    width: int

    @staticmethod
    def of(matrix: sp.csr_matrix) -> Sparse:
        """The same matrix."""
        starts, columns = (a.astype(np.int32, copy=False) for a in (matrix.indptr, matrix.indices))
        return Sparse(starts, columns, matrix.data, matrix.shape[1])

    @staticmethod
    def of_triplets(triplets: Triplets, shape: tuple[int, int]) -> Sparse:
        """Matrix with some entries."""
        rows, columns, values = triplets
        result = Sparse(
            np.empty(shape[0] + 1, np.int32),
            np.empty(len(rows), np.int32),
            np.empty(len(rows)),
            shape[1],
        )
        lib.cf_by_rows(
            shape[0], len(rows), _at("int64_t[]", rows.astype(np.int64, copy=False)),
            _at("int64_t[]", columns.astype(np.int64, copy=False)), _at("double[]", values),
            *result._arrays(),
        )  # fmt: skip
        return result

    @property
    def height(self) -> int:
        """Number of rows."""
        return len(self.starts) - 1

    def triplets(self) -> Triplets:
        """Its entries."""
        rows = np.repeat(np.arange(self.height), np.diff(self.starts))
        return rows, self.columns.astype(np.int64), self.values

    def part(self, first: int, last: int) -> Sparse:
        """Its rows from one number to before another."""
        starts = self.starts[first : last + 1]
        at = slice(starts[0], starts[-1])
        return Sparse(starts - starts[0], self.columns[at], self.values[at], self.width)

    def scipy(self) -> sp.csr_matrix:
        """The same matrix for scipy."""
        return sp.csr_matrix((self.values, self.columns, self.starts), (self.height, self.width))

    def __matmul__(self, other: Sparse) -> Sparse:
        """Product of two matrices."""
        room = int(np.diff(other.starts)[self.columns].sum())
        result = Sparse(
            np.empty(len(self.starts), np.int32), np.empty(room, np.int32), np.empty(room),
            other.width,
        )  # fmt: skip
        count = lib.cf_product(
            self.height, other.width, *self._arrays(), *other._arrays(), *result._arrays()
        )
        return Sparse(result.starts, result.columns[:count], result.values[:count], other.width)

    def _arrays(self) -> tuple[object, object, object]:
        """The arrays for a kernel."""
        return (
            _at("int32_t[]", self.starts),
            _at("int32_t[]", self.columns),
            _at("double[]", self.values),
        )


def joined(triplets: Sequence[Triplets]) -> Triplets:
    """All entries."""
    rows, columns, values = (np.concatenate(parts) for parts in zip(*triplets, strict=True))
    return rows, columns, values


def _at(kind: str, array: NDArray[np.int32] | Ints | Floats) -> object:
    return ffi.from_buffer(kind, np.ascontiguousarray(array))
