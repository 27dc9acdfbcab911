"""What temperatures cannot do is said in the verdict of the run."""

# ruff: noqa: E501

from collections.abc import Callable
from pathlib import Path

import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.results.data import RunResult
from contactfem.results.measures import measure
from contactfem.run.driver import run_case

WALL = """
title = "a wall set to 100 K"
mechanics = false
time = {{ end = "{end} s", step = "{step} s" }}
heat = {{ {scheme} }}
materials.m = {{ youngs_modulus = "1 GPa", poisson_ratio = 0.3, conductivity = "1 W/m/K", density = "1000 kg/m^3", heat_capacity = "1000 J/kg/K" }}
bodies.a = {{ material = "m", mesh = {{ builder = "block", width = "10 mm", height = "10 mm", nx = {n}, ny = 1 }} }}
conditions = [{{ on = "a.left", temperature = "100 K" }}{more}]
"""
Run = Callable[..., RunResult]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    def solve(more: str = "", scheme: str = "", n: int = 20, step: float = 1.0) -> RunResult:
        path = tmp_path / "case.toml"
        path.write_text(WALL.format(end=10 * step, step=step, scheme=scheme, n=n, more=more))
        result = run_case(read_case(path), MPI.COMM_SELF, None)
        assert result.converged, result.message
        return result

    return solve


def test_a_wall_set_to_100_K_reads_no_more_by_default(run: Run) -> None:
    result = run()
    assert not result.warnings
    assert measure(result)["heat.temperature_max"] <= 100.0 + 1e-9


def test_ringing_is_in_the_verdict(run: Run) -> None:
    """cG(1) with steps far longer than the cells' time overshoots the wall."""
    result = run(scheme='scheme = "cG(1)"', step=100.0)
    over = measure(result)["heat.temperature_max"]
    assert over > 110.0
    (text,) = [text for text in result.warnings if "must stay" in text]
    assert "above 0 K and below 100 K" in text
    assert measure(result)["heat.outside"] == pytest.approx((over - 100.0) / over, rel=0.3)


@pytest.mark.parametrize(
    "more",
    [
        ', { on = "a", heat_source = "1e9 W/m^3" }',
        ', { on = "a.right", heat_flux = "1e6 W/m^2" }',
        ', { on = "a.right", temperature = [["0 s", "0 K"], ["5 s", "300 K"]] }',
        ', { on = "a.right", convection = { coefficient = "1e5 W/m^2/K", ambient = "300 K" } }',
    ],
)
def test_what_heats_is_no_breach(run: Run, more: str) -> None:
    result = run(more)
    assert measure(result)["heat.temperature_max"] > 120.0
    assert not [text for text in result.warnings if "must stay" in text]


def test_the_lower_bound_stays_under_a_source(run: Run) -> None:
    """Steps far shorter than the cells' time: below the front temperatures undershoot."""
    result = run(', { on = "a.right", heat_flux = "1e8 W/m^2" }', n=4, step=1e-4)
    assert measure(result)["heat.temperature_min"] < -1.0
    assert any("above 0 K" in text and "below" not in text for text in result.warnings)
