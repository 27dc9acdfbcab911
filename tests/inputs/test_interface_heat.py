"""Heat between bodies: what touches, gaps between curved surfaces, the balance, fixed points."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.errors import CaseError
from contactfem.results.data import RunResult
from contactfem.results.measures import measure
from contactfem.run.driver import run_case

MATERIAL = """
[materials.m]
youngs_modulus = "1 GPa"
poisson_ratio = 0.3
conductivity = "10 W/m/K"
heat_capacity = "500 J/kg/K"
density = "2000 kg/m^3"
"""
BLOCKS = """
title = "a hot block on a cold one"
time = {{ end = "100 s", step = "10 s" }}
heat = {{}}
mechanics = {mechanics}
{material}
[bodies.hot]
material = "m"
mesh = {{ builder = "block", corner = ["0 mm", "{gap}"], width = "10 mm", height = "5 mm", nx = 10, ny = 5 }}
initial_temperature = "100 K"
[bodies.cold]
material = "m"
mesh = {{ builder = "block", corner = ["0 mm", "-5 mm"], width = "10 mm", height = "5 mm", nx = 7, ny = 5 }}
[interfaces.c]
nonmortar = "{nonmortar}"
mortar = "{mortar}"
heat = {{ law = {law} }}
{conditions}
"""  # noqa: E501
HELD = """
[[conditions]]
on = "cold.bottom"
displacement = ["0 mm", "0 mm"]
[[conditions]]
on = "hot.left"
displacement.x = "0 mm"
[[conditions]]
on = "hot.top"
pressure = "1 MPa"
"""
CONSTANT = '"constant", conductance = "5 kW/m^2/K"'
GAS = '"gas", gas_conductivity = "0.1 W/m/K", gas_distance = "1 nm"'
Run = Callable[..., RunResult]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    def solve(text: str, comm: MPI.Comm = MPI.COMM_SELF) -> RunResult:
        path = tmp_path / "case.toml"
        path.write_text(text)
        result = run_case(read_case(path), comm, None)
        assert result.converged, result.message
        return result

    return solve


def blocks(
    gap: str = "0 mm", law: str = CONSTANT, *, moving: bool = False, swap: bool = False
) -> str:
    sides = ("cold.top", "hot.bottom") if swap else ("hot.bottom", "cold.top")
    return BLOCKS.format(
        mechanics="true" if moving else "false",
        material=MATERIAL,
        gap=gap,
        nonmortar=sides[0],
        mortar=sides[1],
        law=law,
        conditions=HELD if moving else "",
    )


@pytest.mark.parametrize("swap", [False, True])
@pytest.mark.parametrize("moving", [False, True])
def test_touching_bodies_even_out(run: Run, moving: bool, swap: bool) -> None:
    """With mechanics and without; the balance is round-off of the heat that moved."""
    found = measure(run(blocks(moving=moving, swap=swap)))
    assert found["hot.temperature.mean"] == pytest.approx(50.0, rel=1e-6)
    assert found["cold.temperature.mean"] == pytest.approx(50.0, rel=1e-6)
    assert found["heat.balance_defect"] < 1e-9


def test_bodies_apart_do_not_touch(run: Run) -> None:
    found = measure(run(blocks(gap="0.01 mm")))
    assert found["hot.temperature.mean"] == pytest.approx(100.0, rel=1e-12)


@pytest.mark.parametrize(
    "law",
    ['"pressure", conductance = "5 kW/m^2/K", hardness = "1 GPa", exponent = 1.0', '"h.py:h"'],
)
def test_a_law_without_its_pressure_is_refused(tmp_path: Path, law: str) -> None:
    (tmp_path / "h.py").write_text("def h(p, g):\n    return p\n")
    path = tmp_path / "case.toml"
    path.write_text(blocks(law=law))
    with pytest.raises(CaseError, match="needs a pressure"):
        read_case(path)


RINGS = """
title = "heat through the gas between a rod and a tube"
dimension = "axisymmetric"
time = {{ end = "1 s", step = "1 s" }}
heat = {{ scheme = "steady" }}
mechanics = false
{material}
[bodies.rod]
material = "m"
mesh = {{ builder = "block", corner = ["5 mm", "0 mm"], width = "5 mm", height = "10 mm", nx = 5, ny = 10 }}
[bodies.tube]
material = "m"
mesh = {{ builder = "block", corner = ["{inner} mm", "0 mm"], width = "4 mm", height = "10 mm", nx = 4, ny = 12 }}
[interfaces.gap]
nonmortar = "{nonmortar}"
mortar = "{mortar}"
search_radius = "20 mm"
heat = {{ law = {law} }}
[[conditions]]
on = "rod.left"
temperature = "100 K"
[[conditions]]
on = "tube.right"
temperature = "0 K"
"""  # noqa: E501


@pytest.mark.parametrize("inner", [11.0, 15.0])
@pytest.mark.parametrize("swap", [False, True])
def test_a_gas_gap_between_cylinders(run: Run, inner: float, swap: bool) -> None:
    """2 π k L ΔT / ln(r2/r1) from either side, with the solids in series."""
    sides = ("tube.left", "rod.right") if swap else ("rod.right", "tube.left")
    material = MATERIAL.replace('"10 W/m/K"', '"1e5 W/m/K"')
    text = RINGS.format(
        material=material, inner=inner, nonmortar=sides[0], mortar=sides[1], law=GAS
    )
    expected = 2 * np.pi * 0.1 * 10e-3 * 100.0 / np.log(inner / 10.0)
    found = measure(run(text))
    assert found["gap.heat_flow"] == pytest.approx(-expected if swap else expected, rel=1e-4)
    assert found["heat.balance_defect"] < 1e-8


BAR = """
title = "steady heat in one step"
strain = "{strain}"
time = {{ end = "1 s", step = "1 s" }}
heat = {{ scheme = "steady"{passes} }}
materials.m = {{ youngs_modulus = "10 MPa", poisson_ratio = 0.0, expansion = "1e-4 1/K", conductivity = "1 W/m/K" }}
bodies.bar = {{ material = "m", mesh = {{ builder = "block", width = "1 mm", height = "10 mm", nx = 1, ny = 10 }} }}
conditions = [{{ on = "bar.bottom", displacement = ["0 mm", "0 mm"] }}, {{ on = "bar.bottom", temperature = "{low} K" }}, {{ on = "bar.top", temperature = "{high} K" }}]
probes.top = {{ on = "bar", at = ["0 mm", "10 mm"], value = "displacement.y" }}
"""  # noqa: E501


@pytest.mark.parametrize(("low", "high"), [(100, 100), (0, 200)])
def test_a_steady_step_is_a_fixed_point(run: Run, low: int, high: int) -> None:
    """The bar expands by α times its mean temperature times its length in one step."""
    result = run(BAR.format(strain="small", passes="", low=low, high=high))
    mean = 0.5 * (low + high)
    assert result.probes["top"] == pytest.approx(1e-4 * mean * 10e-3, rel=0.02)
    assert not result.warnings


def test_a_lag_that_stays_is_said_with_its_size(run: Run) -> None:
    result = run(BAR.format(strain="small", passes=", max_passes = 1", low=100, high=100))
    assert any("changed by up to 1e+02 % of their range" in text for text in result.warnings)
