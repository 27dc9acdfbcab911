"""Data of a case that vary over place and time: functions and tables over one coordinate."""

# ruff: noqa: E501

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

HEAD = """
title = "data over place"
strain = "small"
time = {{ end = "{end}", step = "{step}" }}
{extra}
materials.m = {{ youngs_modulus = "1 MPa", poisson_ratio = 0.0, density = "1000 kg/m^3", conductivity = "2 W/m/K", heat_capacity = "1000 J/kg/K" }}
bodies.a = {{ material = "m", mesh = {{ builder = "block", width = "2 m", height = "1 m", nx = {n}, ny = {n} }} }}
"""
FUNCTIONS = """
import numpy as np
def linear(x, t): return 1e4 * (1 + x[0]) * t
def motion(x, t): return 1e-3 * x[0] * t
def flux(x, t): return 1 + x[0]
def temperature(x, t): return 300 + 10 * x[0]
def falls(x, t): return np.sqrt(x[0] - 5)
def shape(x, t): return np.ones(3)
def raises(x, t): raise KeyError("nothing")
"""
Run = Callable[..., RunResult]


def case_text(conditions: str, extra: str = "", n: int = 4, end: str = "1 s") -> str:
    return HEAD.format(end=end, step=end, extra=extra, n=n) + f"conditions = [{conditions}]\n"


@pytest.fixture
def run(tmp_path: Path) -> Run:
    def solve(text: str, comm: MPI.Comm = MPI.COMM_SELF) -> RunResult:
        path = tmp_path / "case.toml"
        path.write_text(text)
        (tmp_path / "f.py").write_text(FUNCTIONS)
        result = run_case(read_case(path), comm, None)
        assert result.converged, result.message
        return result

    return solve


HOLD = '{ on = "a.bottom", displacement.y = "0 m" }, { on = "a", at = ["0 m", "0 m"], displacement.x = "0 m" }'
TABLE = '{ over = "x", table = [["0 m", "10 kPa"], ["2 m", "30 kPa"]] }'


@pytest.mark.parametrize("value", ['"f.py:linear"', TABLE])
@pytest.mark.parametrize("key", ["pressure", "traction.y"])
def test_load_over_a_coordinate(run: Run, key: str, value: str) -> None:
    """∫ (1 + x) dx = 4: 40 kN/m on the bottom, and its first moment."""
    result = run(case_text(f'{HOLD}, {{ on = "a.top", {key} = {value} }}'))
    force = 4e4 if key == "pressure" else -4e4
    assert result.reactions["a.bottom.y"][0] == pytest.approx(force, rel=1e-9)


def test_table_over_place_and_time(run: Run) -> None:
    table = TABLE.replace(" }", ', factor = [["0 s", 0.0], ["2 s", 1.0]] }')
    result = run(case_text(f'{HOLD}, {{ on = "a.top", pressure = {table} }}'))
    assert result.reactions["a.bottom.y"][0] == pytest.approx(2e4, rel=1e-9)


def test_body_force_over_a_coordinate(run: Run) -> None:
    value = '{ over = "y", table = [["0 m", "0 N/m^3"], ["1 m", "-6 N/m^3"]] }'
    result = run(case_text(f'{HOLD}, {{ on = "a", body_force.y = {value} }}'))
    assert result.reactions["a.bottom.y"][0] == pytest.approx(6.0, rel=1e-9)


@pytest.mark.parametrize("ranks", [pytest.param(True, marks=pytest.mark.mpi), False])
@pytest.mark.parametrize(
    "value", ['"f.py:motion"', '{ over = "x", table = [["0 m", "0 m"], ["2 m", "2 mm"]] }']
)
def test_displacement_over_a_coordinate(run: Run, value: str, ranks: bool) -> None:
    """u_x = 1e-3 x all around: a homogeneous strain, and E ε on the sides."""
    sides = ", ".join(f'{{ on = "a.{s}", displacement.x = {value} }}' for s in ("left", "right"))
    hold = '{ on = "a.bottom", displacement.y = "0 m" }'
    comm = MPI.COMM_WORLD if ranks else MPI.COMM_SELF
    result = run(case_text(f"{hold}, {sides}"), comm)
    assert result.reactions["a.right.x"][0] == pytest.approx(1e6 * 1e-3, rel=1e-9)


@pytest.mark.parametrize(
    "value", ['"f.py:temperature"', '{ over = "x", table = [["0 m", "300 K"], ["2 m", "320 K"]] }']
)
def test_temperature_over_a_coordinate(run: Run, value: str) -> None:
    extra = 'mechanics = false\nheat = { scheme = "steady" }'
    ends = ", ".join(f'{{ on = "a.{s}", temperature = {value} }}' for s in ("left", "right"))
    result = run(case_text(ends, extra))
    assert measure(result)["a.temperature.mean"] == pytest.approx(310.0, rel=1e-12)


@pytest.mark.parametrize(
    "value",
    ['"f.py:flux"', '{ over = "x", table = [["0 m", "1 W/m^2"], ["2 m", "3 W/m^2"]] }'],
)
def test_heat_flux_over_a_coordinate(run: Run, value: str) -> None:
    extra = "mechanics = false\nheat = {}"
    result = run(case_text(f'{{ on = "a.top", heat_flux = {value} }}', extra))
    assert measure(result)["heat.loads"] == pytest.approx(4.0, rel=1e-12)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ('"f.py:falls"', "not finite"),
        ('"f.py:shape"', "did not give one value for each"),
        ('"f.py:raises"', "KeyError"),
        ('"f.py:missing"', "there is no function 'missing'"),
        ('"other.py:f"', "there is no file 'other.py'"),
        ('{ over = "r", table = [["0 m", "1 Pa"], ["1 m", "2 Pa"]] }', "is not a table over"),
        ('{ over = "x", table = [["1 m", "1 Pa"], ["0 m", "2 Pa"]] }', "out of order"),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value")
def test_wrong_data_are_told(run: Run, value: str, words: str) -> None:
    with pytest.raises(CaseError, match=words):
        run(case_text(f'{HOLD}, {{ on = "a.top", pressure = {value} }}'))


BLOCKS = """
title = "two blocks under p = 2 + x, h = p/2"
strain = "small"
time = {{ end = "1 s", step = "1 s" }}
heat = {{ scheme = "steady" }}
solver = {{ system = "saddle" }}
materials.m = {{ youngs_modulus = "1 GPa", poisson_ratio = 0.0, conductivity = "1 W/m/K" }}
[bodies.low]
material = "m"
mesh = {{ builder = "block", width = "1 m", height = "1 m", corner = ["0 m", "-1 m"], nx = {low}, ny = {low} }}
[bodies.up]
material = "m"
mesh = {{ builder = "block", width = "1 m", height = "1 m", nx = {up}, ny = {up} }}
[interfaces.c]
nonmortar = "up.bottom"
mortar = "low.top"
multiplier = "{multiplier}"
heat = {{ law = "pressure", conductance = "0.5 W/m^2/K", hardness = "1 Pa", exponent = 1.0 }}
[[conditions]]
on = "low.bottom"
displacement.y = {{ over = "x", table = [["0 m", "0 m"], ["1 m", "0 m"]] }}
[[conditions]]
on = "low"
at = ["0 m", "-1 m"]
displacement.x = "0 m"
[[conditions]]
on = "up"
at = ["0 m", "1 m"]
displacement.x = "0 m"
[[conditions]]
on = "up.top"
pressure = {{ over = "x", table = [["0 m", "2 Pa"], ["1 m", "3 Pa"]] }}
[[conditions]]
on = "up.top"
temperature = "100 K"
[[conditions]]
on = "low.bottom"
temperature = "0 K"
"""


def flow(run: Run, level: int, multiplier: str) -> float:
    n = 2**level
    text = BLOCKS.format(up=4 * n, low=8 * n, multiplier=multiplier)
    return float(measure(run(text))["c.heat_flow"])


def test_conductance_of_a_linear_pressure(run: Run) -> None:
    """Flux to 1e-4 on 4 x 8 facets and of second order, as with standard multipliers."""
    dual = np.array([flow(run, level, "dual") for level in range(4)])
    standard = flow(run, 3, "standard")
    exact = dual[3] + (dual[3] - dual[2]) / 3.0
    error = np.abs(dual / exact - 1.0)
    assert error[0] < 1e-4
    assert standard == pytest.approx(exact, rel=1e-5)
    assert np.log2(error[0] / error[1]) > 1.8


def test_conductance_over_a_coordinate(run: Run) -> None:
    """h = 1 + x on isothermal sides: the mean conductance."""
    text = BLOCKS.format(up=4, low=8, multiplier="dual").replace('"1 W/m/K"', '"1e6 W/m/K"')
    law = 'heat = { law = "constant", conductance = { over = "x", table = [["0 m", "1 W/m^2/K"], ["1 m", "2 W/m^2/K"]] } }'
    lines = [law if line.startswith("heat = { law") else line for line in text.splitlines()]
    assert measure(run("\n".join(lines)))["c.heat_flow"] == pytest.approx(150.0, rel=1e-5)
