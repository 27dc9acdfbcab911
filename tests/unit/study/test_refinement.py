"""What finer runs change: cells, steps, tolerances; families of them."""

from pathlib import Path

import pytest

from contactfem.case.read import read_case
from contactfem.case.schema import Case
from contactfem.errors import CaseError
from contactfem.study.refinement import refinement
from contactfem.study.runs import Curve, curves, members, values_of

CASE = """
title = "Two warm blocks"
time = { end = "1 s", step = "0.1 s", step_min = "1 ms" }
[materials.soft]
youngs_modulus = "1000 N/mm^2"
poisson_ratio = 0.0
density = "1000 kg/m^3"
conductivity = "1 W/m/K"
heat_capacity = "1000 J/kg/K"
[bodies.lower]
material = "soft"
mesh = { builder = "block", width = "2 mm", height = "1 mm", nx = 2, ny = 1 }
thermal_mesh = { builder = "block", width = "2 mm", height = "1 mm", nx = 6, ny = 3 }
[bodies.upper]
material = "soft"
[bodies.upper.mesh]
builder = "graded_block"
corner = ["0 mm", "1 mm"]
width = "2 mm"
height = "1 mm"
side = "bottom"
zone = ["0 mm", "2 mm"]
size = "0.3 mm"
[interfaces.sole]
nonmortar = "lower.top"
mortar = "upper.bottom"
[[conditions]]
on = "lower.bottom"
displacement = ["0 mm", "0 mm"]
[[conditions]]
on = "upper.top"
displacement = ["0 mm", "-1 um"]
[heat]
[variants.cold]
heat = false
[variants.adaptive]
"adaptivity.tolerance" = "8 %"
[variants.lower_adapts]
"adaptivity.mechanics" = 0.2
"adaptivity.bodies" = ["lower"]
"""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "two.toml"
    path.write_text(CASE)
    return path


def finer(path: Path, what: tuple, variant: str | None = None, factor: float = 4.0) -> Case:
    changes = refinement(read_case(path, (), variant), factor, what)
    return read_case(path, changes, variant)


def test_cells_of_every_mesh(path: Path) -> None:
    case, fine = read_case(path), finer(path, ("space",))
    for name, body in case.bodies.items():
        assert fine.bodies[name].mesh == body.mesh.refined(4.0)
    assert fine.bodies["lower"].thermal_mesh == case.bodies["lower"].thermal_mesh.refined(4.0)
    assert fine.bodies["lower"].thermal_mesh.nx == 24
    assert fine.bodies["upper"].thermal_mesh is None
    assert fine.time == case.time
    assert fine.adaptivity is None


def test_steps(path: Path) -> None:
    case, fine = read_case(path), finer(path, ("time",))
    assert fine.bodies == case.bodies
    time = fine.time
    assert (time.step, time.step_max) == pytest.approx((0.025, 0.025))
    assert time.step_min == pytest.approx(0.25e-3)
    assert finer(path, ("space", "time")).bodies == finer(path, ("space",)).bodies
    assert finer(path, ("space", "time")).time == time


def test_adaptive_runs_get_another_tolerance(path: Path) -> None:
    """One that stands for all is told apart, so that space and time become finer alone."""
    case = read_case(path, (), "adaptive")
    space = finer(path, ("space",), "adaptive")
    assert space.bodies["lower"].mesh == case.bodies["lower"].mesh
    assert space.time == case.time
    asked = space.adaptivity
    tolerances = (asked.for_mechanics(), asked.for_heat(), asked.for_time())
    assert tolerances == pytest.approx((0.02, 0.02, 0.08))
    time = finer(path, ("time",), "adaptive")
    asked = time.adaptivity
    tolerances = (asked.for_mechanics(), asked.for_heat(), asked.for_time())
    assert tolerances == pytest.approx((0.08, 0.08, 0.02))
    assert time.time == case.time
    assert time.bodies == case.bodies


def test_what_does_not_adapt_is_refined(path: Path) -> None:
    """Only the lower body's mechanical mesh adapts: its thermal one and steps do not."""
    case, fine = (
        read_case(path, (), "lower_adapts"),
        finer(path, ("space", "time"), "lower_adapts"),
    )
    assert fine.adaptivity.mechanics == pytest.approx(0.05)
    assert fine.bodies["lower"].mesh == case.bodies["lower"].mesh
    assert fine.bodies["lower"].thermal_mesh.nx == 24
    assert fine.bodies["upper"].mesh == case.bodies["upper"].mesh.refined(4.0)
    assert fine.time.step == pytest.approx(0.025)


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("a,b", ["a", "b"]),
        ("1", ["1"]),
        ('false, {tolerance = "5 %", heat = 0.1}', ["false", '{tolerance = "5 %", heat = 0.1}']),
        ('["1 m", "2 m"],"a,b"', ['["1 m", "2 m"]', '"a,b"']),
        ("'x, [y', 2", ["'x, [y'", "2"]),
        ("a,", ["a", ""]),
    ],
)
def test_values_between_commas(text: str, parts: list[str]) -> None:
    assert values_of(text) == parts


def test_all_combinations_of_variations() -> None:
    base = Curve("", "warm", ("a=1",))
    found = curves(base, ["variant=base, cold", "solver.system=condensed,saddle"], (1, 2))
    assert [curve.label for curve in found] == [
        f"{variant}, system = {system}, {ranks}"
        for variant in ("base", "cold")
        for system in ("condensed", "saddle")
        for ranks in ("1 rank", "2 ranks")
    ]
    assert [curve.variant for curve in found] == [None] * 4 + ["cold"] * 4
    assert found[3] == Curve(
        "base, system = saddle, 2 ranks", None, ("a=1", "solver.system=saddle"), 2
    )
    assert curves(base, (), (1,)) == [base]


@pytest.mark.parametrize("text", ["a.b", "=1,2", "a.b=", "a.b=1,,2"])
def test_malformed_variations(text: str) -> None:
    with pytest.raises(CaseError, match="must be of the form"):
        curves(Curve("", None, ()), [text], (1,))


def test_members_double(path: Path) -> None:
    runs = members(path, Curve("", None, ("time.end=2 s",)), 3, ("space",))
    assert [run.factor for run in runs] == [1, 2, 4]
    assert runs[0].overrides == ("time.end=2 s",)
    cases = [read_case(path, run.overrides) for run in runs]
    assert [case.bodies["lower"].mesh.nx for case in cases] == [2, 4, 8]
    assert {case.time.end for case in cases} == {2.0}
    assert all(run.mechanics and not run.problem for run in runs)


def test_members_say_why_they_cannot_be_run(path: Path) -> None:
    runs = members(path, Curve("", None, ("solver.sistem=saddle",)), 2, ("space",))
    assert all("did you mean 'system'" in run.problem for run in runs)
    runs = members(path, Curve("", "none", ()), 1, ("space",))
    assert "there is no 'none'" in runs[0].problem
    (path.parent / "a.msh").write_text("not read before it is run")
    file = ('bodies.upper.mesh={file = "a.msh", unit = "mm"}',)
    runs = members(path, Curve("", None, file), 2, ("space",))
    assert [("cannot be refined" in run.problem) for run in runs] == [False, True]
    assert "bodies.upper.mesh" in runs[1].problem
