"""The bulk condensed to some unknowns by all ranks together, with held dofs as rows of it."""

from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI
from petsc4py import PETSc

from contactfem.case.read import read_case
from contactfem.common.timers import Timers
from contactfem.discretisation.discretise import discretise
from contactfem.mechanics.bulk_system import System
from contactfem.solvers.constrained_dofs import ConstrainedDofs
from contactfem.solvers.substructuring import Substructure, gathered

pytestmark = [pytest.mark.mpi, pytest.mark.quick]

CASE = """
title = "a block held twice at a corner"
strain = "small"
time = { end = "1 s", step = "1 s" }
[materials.soft]
youngs_modulus = "1 Pa"
poisson_ratio = 0.3
[bodies.block]
material = "soft"
mesh = { builder = "block", width = "2 m", height = "1 m", nx = 8, ny = 6 }
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


KEPT = np.array([0, 3, 17, 40, 41])


@pytest.fixture
def system(tmp_path) -> System:
    folder = Path(MPI.COMM_WORLD.bcast(str(tmp_path)))
    if MPI.COMM_WORLD.rank == 0:
        (folder / "case.toml").write_text(CASE)
    MPI.COMM_WORLD.barrier()
    return discretise(read_case(folder / "case.toml"), MPI.COMM_WORLD, Timers()).system


def dense(system: System) -> np.ndarray:
    """The whole tangent of the unknowns, on all ranks."""
    A = system.create_matrix(system.pattern)
    system.assemble(A, [None])
    starts, columns, values = A.getValuesCSR()
    mine = np.zeros((system.numbering.n_local, system.numbering.n_global))
    mine[np.repeat(np.arange(len(starts) - 1), np.diff(starts)), columns] = values
    return np.concatenate(MPI.COMM_WORLD.allgather(mine))


def owned(system: System, values: np.ndarray) -> np.ndarray:
    first = system.numbering.first
    return values[first : first + system.numbering.n_local]


def whole(system: System, values: np.ndarray) -> np.ndarray:
    return gathered(system, values, np.arange(system.numbering.n_global))


def test_complement_condensation_and_expansion(system):
    """Against dense matrices, and again with other values of the same pattern."""
    bulk = Substructure(system, system.numbering.unknown, KEPT)
    assert set(KEPT) <= set(bulk.border)
    assert (len(bulk.border) > len(KEPT)) == (MPI.COMM_WORLD.size > 1)
    K = dense(system)
    inner = np.setdiff1d(np.arange(len(K)), KEPT)
    across = K[np.ix_(KEPT, inner)] @ np.linalg.inv(K[np.ix_(inner, inner)])
    S = K[np.ix_(KEPT, KEPT)] - across @ K[np.ix_(inner, KEPT)]
    rng = np.random.default_rng(2)
    for _ in range(2):
        bulk.assemble([None])
        found = bulk.factorise().values
        np.testing.assert_allclose(found, S, rtol=0, atol=1e-12 * abs(S).max())
        r = rng.standard_normal(len(K))
        right = bulk.condense(owned(system, r), np.empty(0))
        np.testing.assert_allclose(right.kept, r[KEPT] - across @ r[inner], rtol=0, atol=1e-11)
        bulk.condense(owned(system, np.ones(len(K))), np.empty(0))  # another one in between
        x = whole(system, bulk.expand(right, np.linalg.solve(S, right.kept)))
        solution = np.linalg.solve(K, r)
        np.testing.assert_allclose(x, solution, rtol=0, atol=1e-11 * abs(solution).max())


def test_held_dofs_are_rows_of_the_bulk(system):
    """Differences of residuals and reactions are what the condensed bulk says of moves of both."""
    held = ConstrainedDofs(system)
    assert len(held.numbers) == 4  # x of both, of the bottom alone, of the left alone; y
    n = system.numbering.n_global
    rng = np.random.default_rng(3)
    free, moves = [], []
    reactions = []
    for _ in range(2):
        values = rng.standard_normal(n + len(held.numbers))
        moves.append(values)
        for body, numbers in zip(system.bodies, held.unknown, strict=True):
            body.u.x.array[:] = values[numbers]
        out = system.x.duplicate()
        parts = system.residual(out, [None])
        free.append(whole(system, np.array(out.array_r)))
        reactions.append(held.residual(parts))
        np.testing.assert_allclose(
            held.motions @ reactions[-1], system.reactions(parts), atol=1e-12
        )
    kept = np.concatenate((KEPT, held.numbers))
    bulk = Substructure(system, held.unknown, kept)
    bulk.assemble([None])
    S = bulk.factorise().values
    move, force = moves[1] - moves[0], free[1] - free[0]
    change = reactions[1] - reactions[0]
    # forces that the interior is in equilibrium with are those of the kept unknowns' moves alone
    right = bulk.condense(owned(system, force), change)
    np.testing.assert_allclose(S @ move[kept], right.kept, rtol=0, atol=1e-11)
    x = whole(system, bulk.expand(right, move[kept]))
    np.testing.assert_allclose(x, move[:n], rtol=0, atol=1e-10)


def test_a_factor_that_fails_fails_on_all_ranks(system, monkeypatch):
    """Though only the last one has the fault."""
    bulk = Substructure(system, system.numbering.unknown, KEPT)
    bulk.assemble([None])
    if MPI.COMM_WORLD.rank == MPI.COMM_WORLD.size - 1:

        def fails() -> None:
            raise PETSc.Error(71)

        monkeypatch.setattr(bulk._factor, "factorise", fails)
    with pytest.raises(PETSc.Error):
        bulk.factorise()
