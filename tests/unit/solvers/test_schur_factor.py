"""Factors that give Schur complements away."""

import numpy as np
import pytest
import scipy.sparse as sp

from petsc4py import PETSc

from contactfem.solvers.schur_factor import SchurFactor

KEPT = np.array([3, 7, 50, 51, 199])


def matrix(symmetric):
    """A sparse matrix of the size of a stiffness, without zeros on its diagonal."""
    n = 200
    a = sp.random(n, n, 0.03, random_state=1)
    a = (a + a.T) / 2 if symmetric else a
    return (1e11 * (a + sp.diags(3.0 + np.arange(n) / n))).tocsr()


def as_petsc(a):
    a.sort_indices()
    csr = (a.indptr, a.indices, a.data)
    return PETSc.Mat().createAIJ(a.shape, csr=csr, comm=PETSc.COMM_SELF)


@pytest.mark.parametrize("symmetric", [True, False])
def test_complement_condensation_and_expansion(symmetric):
    a = matrix(symmetric)
    K = as_petsc(a)
    factor = SchurFactor(K, KEPT, symmetric)
    rng = np.random.default_rng(2)
    for scale in (1.0, 3.0):  # the second time it has new values
        K.scale(scale)
        K.assemble()
        factor.factorise()
        dense = a.toarray() * 3.0 ** (scale > 1)
        inner = np.setdiff1d(np.arange(len(dense)), KEPT)
        across = dense[np.ix_(KEPT, inner)] @ np.linalg.inv(dense[np.ix_(inner, inner)])
        S = dense[np.ix_(KEPT, KEPT)] - across @ dense[np.ix_(inner, KEPT)]
        np.testing.assert_allclose(factor.S, S, rtol=0, atol=1e-13 * abs(S).max())
        r = 1e4 * rng.standard_normal(len(dense))  # forces; unknowns are 1e-7 of their size
        condensed = factor.condense(r)
        np.testing.assert_allclose(condensed, r[KEPT] - across @ r[inner], rtol=1e-11)
        x = factor.expand(r, condensed, np.linalg.solve(S, condensed))
        solution = np.linalg.solve(dense, r)
        np.testing.assert_allclose(x, solution, rtol=0, atol=1e-12 * abs(solution).max())


def test_a_singular_matrix_has_a_complement():
    """As that of a body that only contact holds: a chain of springs with free ends."""
    n = 30
    a = sp.diags(
        [-np.ones(n - 1), np.r_[1.0, 2 * np.ones(n - 2), 1.0], -np.ones(n - 1)], [-1, 0, 1]
    )
    factor = SchurFactor(as_petsc(a.tocsr()), np.array([0, n - 1]), symmetric=True)
    factor.factorise()
    one = 1.0 / (n - 1)  # of the springs in series
    np.testing.assert_allclose(factor.S, [[one, -one], [-one, one]], atol=1e-14)
