"""Hertz's contact: what must not change the answer, and how fast Newton finds it."""

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.results.expectations import measure


@pytest.fixture(scope="module")
def hertz(solved):
    return solved("hertz")


def test_newton_ends_quadratically(hertz):
    (step,) = hertz.steps
    before, last = np.log10(step.residuals[-3:-1])
    assert step.iterations <= 7
    assert last < 1.6 * before


@pytest.mark.parametrize("factor", ["1e-4", "1e-2", "10.0", "100.0"])
def test_constant_of_the_active_set_does_not_matter(solved, same, hertz, factor):
    same(hertz, solved("hertz", f"interfaces.contact.normal.c_factor={factor}"))


def test_other_side_as_nonmortar(solved, hertz):
    """Same force, same pressure but for the mesh."""
    swapped = solved(
        "hertz",
        'interfaces.contact.nonmortar="block.contact"',
        'interfaces.contact.mortar="cylinder.contact"',
    )
    values, others = measure(hertz), measure(swapped)
    assert others["contact.force_y"] == pytest.approx(-values["contact.force_y"], rel=1e-9)
    assert others["contact.pressure_at_center"] == pytest.approx(
        values["contact.pressure_at_center"], rel=0.02
    )


@pytest.mark.mpi
def test_ranks_agree(solved, same, hertz):
    same(hertz, solved("hertz", comm=MPI.COMM_WORLD))
