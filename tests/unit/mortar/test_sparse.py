"""The matrices of contact against those of scipy."""

import numpy as np
import pytest
import scipy.sparse as sp

from contactfem.mortar.sparse import Sparse, joined

SHAPES = [(5, 7, 4), (1, 1, 1), (6, 3, 0), (0, 3, 2), (4, 0, 3)]


def some(rng, n, m):
    """Triplets that repeat places, with rows left empty, and the matrix that they are."""
    count = 3 * min(n, m)
    rows = rng.integers(0, max(n - 1, 1), count)
    columns, values = rng.integers(0, max(m, 1), count), rng.normal(size=count)
    dense = np.zeros((n, m))
    np.add.at(dense, (rows, columns), values)
    return (rows, columns, values), dense


@pytest.mark.parametrize(("n", "m", "k"), SHAPES)
def test_products_and_parts(n, m, k):
    rng = np.random.default_rng(n)
    (a, dense_a), (b, dense_b) = some(rng, n, m), some(rng, m, k)
    A, B = Sparse.of_triplets(a, (n, m)), Sparse.of_triplets(b, (m, k))
    np.testing.assert_allclose(A.scipy().toarray(), dense_a, rtol=0, atol=1e-15)
    product = A @ B
    assert (product.height, product.width) == (n, k)
    np.testing.assert_allclose(product.scipy().toarray(), dense_a @ dense_b, rtol=0, atol=1e-14)
    for row in range(n):  # each place once
        at = slice(product.starts[row], product.starts[row + 1])
        assert len(set(product.columns[at])) == at.stop - at.start
    half = A.part(n // 2, n).scipy().toarray()
    np.testing.assert_allclose(half, dense_a[n // 2 :], rtol=0, atol=1e-15)
    twice = Sparse.of_triplets(joined([A.triplets(), a]), (n, m)).scipy().toarray()
    np.testing.assert_allclose(twice, 2 * dense_a, rtol=0, atol=1e-15)


def test_a_matrix_of_scipy():
    matrix = sp.random(6, 4, 0.5, "csr", random_state=3)
    np.testing.assert_array_equal(Sparse.of(matrix).scipy().toarray(), matrix.toarray())
