"""Plateau, dissipated work and the end of equilibrium of a block on a plane."""

from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.run.driver import run_case

CASES = Path(__file__).parents[2] / "cases"


def test_work_of_every_step_on_the_plateau(solved):
    """Dissipation is the friction force times the way of the plate, step by step."""
    result = solved("friction_states", 'time.step="0.125 s"', variant="sliding")
    slides = [step for step in result.steps if step.t > 1.01]
    assert len(slides) == 8
    for step in slides:
        assert step.forces["sole"][0] == pytest.approx(40e3, rel=1e-8)
        assert step.dissipation == pytest.approx(40e3 * 5e-3 * step.dt, rel=1e-8)


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_end_of_equilibrium(share):
    """Just below μP there is an answer, just above none: the run stops and names friction."""
    tau = 2 * share
    overrides = (
        f'conditions.0.grip.force.x=[["0 s", "0 N/mm"], ["1 s", "{20 * tau:g} N/mm"]]',
        f'conditions.1.traction.y=[["0 s", "0 N/mm^2"], ["1 s", "{-tau:g} N/mm^2"]]',
        f'conditions.2.traction.y=[["0 s", "0 N/mm^2"], ["1 s", "{tau:g} N/mm^2"]]',
        "solver.max_cutbacks=3",
    )
    case = read_case(CASES / "friction_states.toml", overrides)
    result = run_case(case, MPI.COMM_SELF, None)
    assert result.converged == (share < 1)
    assert np.hypot(*result.steps[-1].forces["sole"]) > 100e3
    if share > 1:
        assert "friction" in result.message
        assert "sole" in result.message
        assert result.steps[-1].forces["sole"][0] <= 40e3
