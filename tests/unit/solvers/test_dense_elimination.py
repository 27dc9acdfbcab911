"""Dense systems and their elimination, against numpy's solution of the whole."""

import numpy as np
import pytest

from contactfem.solvers.dense_elimination import Elimination, SchurComplement, solve


@pytest.mark.parametrize("n", [0, 1, 7])
def test_solve(n):
    rng = np.random.default_rng(1)
    A, b = rng.standard_normal((n, n)), rng.standard_normal(n)
    np.testing.assert_allclose(solve(A.copy(), b), np.linalg.solve(A, b), rtol=1e-12)


def test_a_singular_matrix_is_told():
    with pytest.raises(np.linalg.LinAlgError):
        solve(np.array(((1.0, 2.0), (2.0, 4.0))), np.ones(2))


@pytest.mark.parametrize("left", [[], [2], [0, 3, 4], list(range(6))])
def test_elimination(left):
    """Of the system (T S + C) x = T f + r with T and C one and zero outside of what is left."""
    n, left = 6, np.array(left, np.int64)
    rng = np.random.default_rng(2)
    S = rng.standard_normal((n, n)) + 4 * np.eye(n)
    f, r = rng.standard_normal((2, n))
    small_T, small_C = rng.standard_normal((2, len(left), len(left)))
    T, C = np.eye(n), np.zeros((n, n))
    T[np.ix_(left, left)], C[np.ix_(left, left)] = small_T, small_C
    rest = Elimination(SchurComplement(S, 1), left)
    inner = rest.condense(f, f + r)
    rest.condense(r, f)  # another one in between
    right = small_T @ inner.left + r[left]
    x = rest.expand(solve(small_T @ rest.S + small_C, right), inner)
    np.testing.assert_allclose(x, np.linalg.solve(T @ S + C, T @ f + r), rtol=1e-10)


def test_which_matrix_it_is_reusable_for():
    S = SchurComplement(np.eye(4), 1)
    rest = Elimination(S, np.array((1, 2)))
    assert rest.is_reusable(S, np.array((False, True, False, False)))
    assert not rest.is_reusable(S, np.array((True, True, False, False)))
    assert not rest.is_reusable(SchurComplement(S.values, 2), np.array((False, True, False, False)))
