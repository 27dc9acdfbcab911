"""A contact that leaves all that it touched within one step must not lose its friction unseen."""

from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.results.data import RunResult
from contactfem.run.driver import run_case

CASE = Path(__file__).parents[2] / "cases" / "hard" / "long_steps.toml"
CIRCLE = 'shape = "circle"\ncenter = ["4 mm", "5 mm"]\nradius = "2 mm"\n'


def roll(tmp_path: Path, *overrides: str, comm: MPI.Comm = MPI.COMM_SELF) -> RunResult:
    """Draw a roll 4 mm along a slab in one step; a polyline, it faces only what is below it."""
    text = CASE.read_text()
    assert CIRCLE in text
    turn = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    points = [f'["{4 + 2 * np.cos(a)} mm", "{5 + 2 * np.sin(a)} mm"]' for a in turn]
    chain = f'shape = "polyline"\nclosed = true\npoints = [{", ".join(points)}]\n'
    path = tmp_path / "case.toml"
    path.write_text(text.replace(CIRCLE, chain))
    return run_case(read_case(path, overrides, "one"), comm, None)


def test_step_is_cut(tmp_path):
    """The forces are those of short steps."""
    result = roll(tmp_path)
    assert result.converged
    assert not result.warnings
    assert sum(step.cutbacks for step in result.steps) >= 1
    Q, V = result.steps[-1].forces["contact"]
    assert pytest.approx(272.97e3, rel=5e-3) == V
    assert pytest.approx(-80.1e3, rel=5e-3) == Q


def test_step_that_may_not_be_cut_has_a_warning(tmp_path):
    """Its answer is wrong, and said to be."""
    result = roll(tmp_path, "solver.max_cutbacks=0")
    assert result.converged
    assert len(result.warnings) == 1
    assert "step to t = 3 s: 100% of the normal force at 'contact'" in result.warnings[0]
    assert abs(result.steps[-1].forces["contact"][0]) < 10e3
