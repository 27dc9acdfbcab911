"""Factors that give Schur complements away, and the bulk with its held dofs as unknowns."""

import numpy as np
import pytest
import scipy.sparse as sp

from mpi4py import MPI
from petsc4py import PETSc

from contactfem.case import read_case
from contactfem.discretise import discretise
from contactfem.held import Held
from contactfem.schur import SchurFactor
from contactfem.timers import Timers

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


CASE = """
title = "a block held twice at a corner"
strain = "small"
time = { end = "1 s", step = "1 s" }
[materials.soft]
youngs_modulus = "1 Pa"
poisson_ratio = 0.3
[bodies.block]
material = "soft"
mesh = { builder = "block", width = "2 m", height = "1 m", nx = 4, ny = 3 }
[[conditions]]
on = "block.bottom"
displacement = ["0.1 m", "0 m"]
[[conditions]]
on = "block.left"
displacement.x = "0.1 m"
[[conditions]]
on = "block.top"
traction.y = "0.3 Pa"
"""


def test_held_dofs_are_rows_of_the_bulk(tmp_path):
    (tmp_path / "case.toml").write_text(CASE)
    system = discretise(read_case(tmp_path / "case.toml"), MPI.COMM_SELF, Timers()).system
    held = Held(system)
    assert len(held.numbers) == 4  # x of both, of the bottom alone, of the left alone; y
    rng = np.random.default_rng(3)
    n = system.numbering.n_global
    residuals, moves = [], []
    for _ in range(2):
        values = rng.standard_normal(n + len(held.numbers))
        moves.append(values)
        for body, numbers in zip(system.bodies, held.unknown, strict=True):
            body.u.x.array[:] = values[numbers]
        out = system.x.duplicate()
        parts = system.residual(out, [None])
        residuals.append(held.residual(out.array_r, parts))
        rows = residuals[-1][n:]
        np.testing.assert_allclose(held.motions @ rows, system.reactions(parts), atol=1e-13)
    A = sp.csr_matrix(held.matrix().getValuesCSR()[::-1])
    np.testing.assert_allclose(
        A @ (moves[1] - moves[0]), residuals[1] - residuals[0], rtol=0, atol=1e-12
    )
