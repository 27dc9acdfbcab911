"""The block with friction: what must not change the answer, and how fast Newton finds it."""

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.results.expectations import measure

MEDIUM = ("bodies.block.mesh.nx=32", "bodies.block.mesh.ny=32")
TIGHT = "solver.tolerance=1e-12"
U = [f"probe.x_{k}" for k in (0, 1, 5, 7, 11)]


@pytest.fixture(scope="module")
def medium(solved):
    return solved("block", *MEDIUM)


def test_one_step_gives_the_numbers_of_ten(solved, same, medium):
    """The law is positively homogeneous and the bulk linear."""
    ten = solved("block", *MEDIUM, TIGHT, variant="ten_steps")
    assert len(ten.steps) == 10
    one, many = measure(medium), measure(ten)
    for key in U:
        assert many[key] == pytest.approx(one[key], rel=1e-9)
    same(medium, ten)
    usual = solved("block", *MEDIUM, variant="ten_steps")
    assert np.mean([step.iterations for step in usual.steps[1:]]) <= 2


@pytest.mark.parametrize("factor", ["1e-4", "1e-2", "10.0", "100.0"])
def test_constant_of_the_active_set_does_not_matter(solved, same, medium, factor):
    """It decides how the status is found, not what it is."""
    same(medium, solved("block", *MEDIUM, f"interfaces.sole.normal.c_factor={factor}"))


@pytest.mark.parametrize("cells", [16, 32, 64, pytest.param(128, marks=pytest.mark.slow)])
def test_newton(solved, cells):
    """At most 12 iterations, the last ones quadratic: the residual's exponent doubles."""
    mesh = (f"bodies.block.mesh.nx={cells}", f"bodies.block.mesh.ny={cells}")
    (step,) = solved("block", *mesh).steps
    assert step.iterations <= 12
    before, last = np.log10(step.residuals[-3:-1])
    assert last < 1.6 * before or last < -10


@pytest.mark.mpi
def test_ranks_agree(solved, same, medium):
    same(medium, solved("block", *MEDIUM, comm=MPI.COMM_WORLD))
