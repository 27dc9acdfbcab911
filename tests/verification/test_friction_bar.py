"""An elastic bar on friction: slip history, unloading and reversal against the closed form."""

from pathlib import Path

import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.results.data import RunResult
from contactfem.results.expectations import judge
from contactfem.results.measures import measure
from contactfem.run.driver import run_case

CASE = Path(__file__).parents[2] / "cases" / "friction_bar.toml"
LOAD, STIFFNESS, FRICTION = 5.0e3, 100.0e3, 2.0e6  # F [N/m], E A [N/m], q = μ p [Pa]


def run(variant: str | None) -> RunResult:
    case = read_case(CASE, variant=variant)
    result = run_case(case, MPI.COMM_SELF, None)
    assert result.converged
    missed = [verdict for verdict in judge(case, measure(result)) if not verdict.passed]
    assert not missed
    return result


def test_pull():
    """Monotonic: u = F² / (2 E A q); slip reaches F / q deep and friction takes F³ / (6 E A q)."""
    result = run("pulled")
    assert result.probes["end"] == pytest.approx(LOAD**2 / (2 * STIFFNESS * FRICTION), rel=0.02)
    work = sum(step.dissipation for step in result.steps)
    assert work == pytest.approx(LOAD**3 / (6 * STIFFNESS * FRICTION), rel=0.01)
    depth = 6e-3 - measure(result)["sole.stick_edge_max"]
    assert depth == pytest.approx(LOAD / FRICTION, abs=0.1e-3)


@pytest.mark.parametrize(("variant", "share"), [("released", 0.5), ("pushed", -1.0)])
def test_unloading_and_reversal(variant, share):
    """u = F₀² / (2 E A q) - (F₀ - F)² / (4 E A q): half of it stays at F = 0, all of it at -F₀."""
    largest = LOAD**2 / (2 * STIFFNESS * FRICTION)
    assert run(variant).probes["end"] == pytest.approx(share * largest, abs=0.02 * largest)


def test_energy_of_a_cycle():
    """A full cycle between F₀ and -F₀ dissipates (2/3) F₀³ / (E A q)."""
    steps = run(None).steps
    work = sum(step.dissipation for step in steps if step.t > 2.0 * (1 + 1e-9))
    assert work == pytest.approx(2 * LOAD**3 / (3 * STIFFNESS * FRICTION), rel=0.01)
