"""Temperatures are absolute or rises, never both; expansion counts from the stress-free state."""

# ruff: noqa: E501

from collections.abc import Callable
from pathlib import Path

import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.check.check import check_case
from contactfem.errors import CaseError
from contactfem.results.data import RunResult
from contactfem.results.measures import measure
from contactfem.run.driver import run_case

BLOCK = """
title = "a block between rigid walls"
dimension = "plane strain"
strain = "{strain}"
time = {{ end = "1 s", step = "1 s" }}
{heat}
materials.m = {{ youngs_modulus = "210 GPa", poisson_ratio = 0.3, expansion = "1.2e-5 1/K", density = "7850 kg/m^3", conductivity = "45 W/m/K", heat_capacity = "460 J/kg/K"{reference} }}
bodies.a = {{ material = "m", {start} mesh = {{ builder = "block", width = "20 mm", height = "5 mm", nx = 4, ny = 2 }} }}
conditions = [{{ on = "a.bottom", displacement.y = "0 mm" }}, {{ on = "a.top", displacement.y = "0 mm" }}, {{ on = "a.left", displacement.x = "0 mm" }}, {{ on = "a.right", displacement.x = "0 mm" }}{condition}]
probes.s = {{ on = "a", at = ["10 mm", "2.5 mm"], value = "stress.yy" }}
"""
Run = Callable[[str], RunResult]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    def solve(text: str, comm: MPI.Comm = MPI.COMM_SELF) -> RunResult:
        path = tmp_path / "case.toml"
        path.write_text(text)
        result = run_case(read_case(path), comm, None)
        assert result.converged, result.message
        return result

    return solve


def block(**keys: str) -> str:
    given = {"strain": "small", "heat": "heat = {}", "reference": "", "start": "", "condition": ""}
    return BLOCK.format(**(given | keys))


def stress(rise: float) -> float:
    """Of a block that cannot expand: -3 K α ϑ [Pa]."""
    return -210e9 / (1 - 2 * 0.3) * 1.2e-5 * rise


def test_a_body_at_its_reference_has_no_stress(run: Run) -> None:
    start = 'initial_temperature = "293.15 K",'
    result = run(block(reference=', reference_temperature = "293.15 K"', start=start))
    assert abs(result.probes["s"]) < 1e-6 * abs(stress(1.0))


@pytest.mark.parametrize("strain", ["small", "finite"])
@pytest.mark.parametrize("heat", ["heat = {}", ""])
@pytest.mark.parametrize(
    ("reference", "temperature"),
    [(', reference_temperature = "68 degF"', "70 degC"), ("", "50 K"),
     (', reference_temperature = "20 °C"', "343.15 K")],
)  # fmt: skip
def test_stress_counts_from_the_reference(
    run: Run, strain: str, heat: str, reference: str, temperature: str
) -> None:
    """Heat solved for or temperatures given, absolute or as rises: the same stress."""
    key = "initial_temperature" if heat else "temperature"
    start = f'{key} = "{temperature}",'
    result = run(block(reference=reference, start=start, heat=heat, strain=strain))
    assert result.probes["s"] == pytest.approx(stress(50.0), rel=1e-10)


def test_a_body_starts_at_its_reference(run: Run) -> None:
    result = run(block(reference=', reference_temperature = "20 degC"'))
    assert measure(result)["a.temperature.mean"] == pytest.approx(293.15)
    assert abs(result.probes["s"]) < 1e-6 * abs(stress(1.0))


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"start": 'initial_temperature = "20 degC",'}, "materials.m: temperatures of this case"),
        ({"reference": ', reference_temperature = "20 degC"', "start": 'initial_temperature = "0 K",'},
         "bodies.a.initial_temperature = 0 K"),
        ({"reference": ', reference_temperature = "20 degC"', "start": 'initial_temperature = "-5 K",'},
         "bodies.a.initial_temperature = -5 K"),
        ({"start": 'initial_temperature = "-300 degC",'}, "is below absolute zero"),
        ({"reference": ', reference_temperature = "20 degC"',
          "condition": ', { on = "a.top", convection = { coefficient = "5 W/m^2/K" } }'},
         "give the ambient temperature"),
    ],
)  # fmt: skip
def test_scales_are_not_mixed(tmp_path: Path, keys: dict[str, str], words: str) -> None:
    path = tmp_path / "case.toml"
    path.write_text(block(**keys))
    with pytest.raises(CaseError, match=words):
        read_case(path)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"start": 'initial_temperature = "293 K",'}, "293 K is read as a rise"),
        ({"reference": ', reference_temperature = "293 K"', "start": 'initial_temperature = "50 K",'},
         "50 K is read as absolute"),
    ],
)  # fmt: skip
def test_what_reads_like_the_other_scale_is_said(
    tmp_path: Path, keys: dict[str, str], words: str
) -> None:
    path = tmp_path / "case.toml"
    path.write_text(block(**keys))
    assert words in check_case(read_case(path))


def test_a_degree_in_a_product_is_a_kelvin(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(block().replace("45 W/m/K", "45 W/m/degC").replace("1.2e-5 1/K", "1.2e-5 1/°C"))
    material = read_case(path).materials["m"]
    assert (material.conductivity, material.expansion) == (45.0, 1.2e-5)


def test_a_tolerance_in_degrees_is_a_difference(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    expect = 'expect."a.temperature.mean" = { value = "20 degC", abs = "0.5 degC" }\n'
    path.write_text(block(reference=', reference_temperature = "20 degC"') + expect)
    expected = read_case(path).expect["a.temperature.mean"]
    assert (expected.value, expected.abs) == (293.15, 0.5)
