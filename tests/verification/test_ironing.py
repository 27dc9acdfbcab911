"""Shallow ironing: forces within published bands, smooth, and hardly changed by sides or steps."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.results.expectations import judge
from contactfem.results.measures import measure
from contactfem.run.driver import run_case

CASE = Path(__file__).parents[2] / "cases" / "ironing.toml"


@cache
def course(variant: str | None) -> np.ndarray:
    """Time [s], |H| and |V| [N/mm] of every step (n, 3); what the case expects holds."""
    case = read_case(CASE, ["output.fields=false", "output.figures=false"], variant)
    result = run_case(case, MPI.COMM_SELF, None)
    assert result.converged, result.message
    missed = [verdict for verdict in judge(case, measure(result)) if not verdict.passed]
    assert not missed
    forces = np.abs([step.forces["sole"] for step in result.steps]) / 1e3
    return np.column_stack([[step.t for step in result.steps], forces])


def at(history: np.ndarray, t: float) -> tuple[float, float]:
    """H and V at the end of the step that ends at t."""
    row = history[np.argmin(np.abs(history[:, 0] - t))]
    assert row[0] == pytest.approx(t)
    return float(row[1]), float(row[2])


def test_pressing():
    """V(0.5 s) and V(1 s) lie in the published bands, with steps ten times as long."""
    history = course("pressed")
    assert 81 <= at(history, 0.5)[1] <= 96
    assert 265 <= at(history, 1.0)[1] <= 335


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_bands():
    """V(1 s), V(1.5 s) and H/V(1.5 s) as published for consistent Coulomb friction."""
    history = course(None)
    assert 81 <= at(history, 0.5)[1] <= 96
    assert 265 <= at(history, 1.0)[1] <= 335
    H, V = at(history, 1.5)
    assert 335 <= V <= 422
    assert 0.29 <= H / V <= 0.40


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_forces_are_smooth():
    """No step changes V by 1 % once the die slides, t > 1.05 s."""
    history = course(None)
    sliding = history[history[:, 0] > 1.05 - 1e-9]
    assert len(sliding) >= 90
    jumps = np.abs(np.diff(sliding[:, 2])) / np.abs(sliding[:-1, 2])
    assert jumps.max() < 0.01
    kinks = np.abs(np.diff(sliding[:, 2], 2)) / np.abs(sliding[1:-1, 2])
    assert kinks.max() < 0.005


@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.parametrize(("variant", "allowed"), [("swapped", 0.03), ("double_step", 0.01)])
def test_sides_and_steps_matter_little(variant, allowed):
    """V(1 s) and V(1.5 s) with nonmortar and mortar swapped, and with steps twice as long."""
    usual, other = course(None), course(variant)
    for t in (1.0, 1.5):
        assert at(other, t)[1] == pytest.approx(at(usual, t)[1], rel=allowed)


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_without_friction_nothing_drags():
    """|H| / V(1.5 s) < 0.03."""
    H, V = at(course("frictionless"), 1.5)
    assert H < 0.03 * V
