"""Sparse matrices whose rows are equal dense blocks."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray


def block_rows(
    values: NDArray[np.float64], places: NDArray[np.int64], n_cols: int
) -> sp.csr_matrix:
    """Sparse matrix of dense rows of blocks: built as it is stored, without sorting.

    Args:
        values: Rows of each of b blocks, side by side, (b, r, k c) for k places of c columns.
        places: Block columns of each block, (b, k); entries at the same place add up.
        n_cols: Columns of the matrix.

    Returns:
        Matrix (b r, n_cols).
    """
    b, r, width = values.shape
    c = width // places.shape[1]
    columns = (c * places[:, :, None] + np.arange(c)).reshape(b, 1, width)
    indices = np.broadcast_to(columns, values.shape).astype(np.int32).ravel()
    indptr = np.arange(0, b * r * width + 1, width, dtype=np.int32)
    return sp.csr_matrix((values.ravel(), indices, indptr), shape=(b * r, n_cols))
