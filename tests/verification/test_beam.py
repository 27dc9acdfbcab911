"""A cantilever comes to rest on a stop: contact begins at the right load and takes its share."""

from pathlib import Path

import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.results.expectations import judge
from contactfem.results.measures import measure
from contactfem.run.driver import run_case

CASE = Path(__file__).parents[2] / "cases" / "beam_on_stop.toml"


@pytest.mark.parametrize("variant", [None, "touching", "free"])
def test_beam_on_stop(variant):
    """All that the case expects: reaction within 1 %, contact from the right load on within 2 %."""
    case = read_case(CASE, variant=variant)
    result = run_case(case, MPI.COMM_SELF, None)
    assert result.converged
    assert all(verdict.passed for verdict in judge(case, measure(result)))


def test_reaction_is_the_beams():
    """3 q L / 8 - 3 E I g / L³, and the roll touches the tip alone."""
    result = run_case(read_case(CASE), MPI.COMM_SELF, None)
    E, L, depth, gap, q = 1e10, 0.05, 1e-3, 0.2e-3, 1e4
    exact = 3 * q * L / 8 - 3 * E * depth**3 / 12 * gap / L**3
    assert exact == pytest.approx(183.5)
    assert -result.steps[-1].forces["stop"][1] == pytest.approx(exact, rel=0.01)
    assert measure(result)["stop.active"] == 1
