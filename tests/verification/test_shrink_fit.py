"""Round bodies that overlap or grow into each other: uniform pressure, no force left over."""

from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.results.data import RunResult
from contactfem.results.expectations import judge
from contactfem.results.measures import measure
from contactfem.run.driver import run_case

CASE = Path(__file__).parents[2] / "cases" / "shrink_fit.toml"


def run(variant: str | None) -> RunResult:
    case = read_case(CASE, variant=variant)
    result = run_case(case, MPI.COMM_SELF, None)
    assert result.converged
    missed = [verdict for verdict in judge(case, measure(result)) if not verdict.passed]
    assert not missed
    return result


@pytest.mark.parametrize(
    ("variant", "exact"),
    [(None, 0.47021944e6), ("swapped", 0.47021944e6), ("heated", 8.83787078e6)],
)
def test_pressure_is_uniform_and_lames(variant, exact):
    """std / mean below 2 %, mean within 1 %; the bodies push each other with no net force."""
    result = run(variant)
    table = result.interfaces[0]
    assert table.pressure.std() <= 0.02 * table.pressure.mean()
    assert table.pressure.mean() == pytest.approx(exact, rel=0.01)
    around = 2 * np.pi * 10e-3 * exact
    assert np.hypot(*result.steps[-1].forces["fit"]) <= 1e-10 * around
    assert measure(result)["fit.moment_defect"] <= 1e-3


def test_unevenness_shrinks_with_the_facets():
    """Of polygons that do not match, at least in proportion to the length of their facets."""
    uneven = []
    for variant in ("coarse", None, "fine"):
        pressure = run(variant).interfaces[0].pressure
        uneven.append(pressure.std() / pressure.mean())
    assert uneven[0] <= 0.02
    assert uneven[1] <= 0.6 * uneven[0]
    assert uneven[2] <= 0.6 * uneven[1]
