"""Runs that are made to fail say what happened: which nodes, how far, how small, what to change."""

import re
from pathlib import Path

import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.run.driver import run_case

CASES = Path(__file__).parents[2] / "cases"


def message(stem: str, *overrides: str, variant: str | None = None) -> str:
    """Why a run stopped."""
    case = read_case(CASES / f"{stem}.toml", overrides, variant)
    result = run_case(case, MPI.COMM_SELF, None)
    assert not result.converged
    return result.message


def test_cells_that_turn_over():
    """A die pressed 0.4 mm in one step: nodes that changed, where, and the residual before it."""
    found = message("ironing", "time.step=0.5 s", "solver.max_cutbacks=1")
    assert "no equilibrium found at t = 0.75 s" in found
    assert "a cell was turned inside out (shorter steps" in found
    assert re.search(r"the last residual is \d\.\de[+-]\d+, the smallest \d\.\de[+-]\d+", found)
    assert "1e-10 is asked for" in found
    assert "the smallest step tried is 0.25 s, cut 1 times; a larger solver.max_cutbacks" in found
    assert "the last good state, t = 0.5 s, is written" in found.lower()
    where = (
        r"'sole': node \d+ at \(-?[\d.e-]+, -?[\d.e-]+\) m (open|stick|slip along \(.*?\)) -> "
        r"(open|stick|slip)"
    )
    assert re.search(where, found)


def test_status_that_does_not_settle():
    """A far too small constant of friction's active set: nodes flip between all states."""
    factor = "interfaces.sole.friction.c_factor=1e-8"
    found = message("block", factor, "solver.max_cutbacks=1")
    assert "no convergence in 30 iterations, as the contact status does not settle" in found
    assert "a c_factor of the interface and its friction nearer to 1" in found
    assert re.search(r"node \d+ at \(0\.0\d+, .*\) m (open|stick|slip[+-]) -> ", found)
    assert "the smallest step tried is 0.5 s" in found


def test_load_that_friction_cannot_carry():
    """Names the interface and its law; how the smallest step is limited."""
    force = 'conditions.0.grip.force.x=[["0 s", "0 N/mm"], ["1 s", "60 N/mm"]]'
    found = message("friction_states", force, "time.step_min=0.2 s")
    assert "all nodes in contact at 'sole' slip" in found
    assert "Coulomb 0.4" in found
    assert "lower the load, or prescribe" in found
    assert "a smaller time.step_min than 0.2 s allows more" in found


@pytest.mark.parametrize("variant", ["pulled"])
def test_body_that_is_pulled_off(variant):
    found = message("hard/starts", variant=variant)
    assert "contact at 'sole' is lost" in found
    assert "hold the body by a condition" in found


def test_options_that_mumps_cannot_read():
    """Known only when it factorises, inside PETSc; the state is restored."""
    found = message("patch", 'solver.petsc={mat_mumps_icntl_14="x"}', "solver.max_cutbacks=1")
    assert "linear solver failed (PETSc error" in found
