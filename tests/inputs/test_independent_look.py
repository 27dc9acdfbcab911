"""Scenes that ended as converged with a wrong state: right now, or refused with the place."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.errors import ExitCode
from contactfem.results.data import RunResult
from contactfem.run.driver import run_case

HEAD = """
strain = "small"
time = { end = "1 s", step = "STEP" }
output = { figures = false, fields = false }
materials.m = { youngs_modulus = "10 MPa", poisson_ratio = 0.0 }
"""


def block(name: str, height: str, bottom: str, nx: int, ny: int) -> str:
    size = f'width = "10 mm", height = "{height}", corner = ["0 mm", "{bottom}"]'
    cells = f'nx = {nx}, ny = {ny}, cell = "quadrilateral"'
    mesh = f'{{ builder = "block", {size}, {cells} }}'
    return f'bodies.{name} = {{ material = "m", mesh = {mesh} }}\n'


LOWER = block("low", "10 mm", "0 mm", 6, 6)
UPPER = block("up", "6 mm", "BOTTOM", 10, 5)
SINGLE = block("b", "5 mm", "0 mm", 6, 3)
LED = """
interfaces.c = { nonmortar = "up.bottom", mortar = "low.top" }
conditions = [
    { on = "low.bottom", displacement = ["0 mm", "0 mm"] },
    { on = "up.top", displacement = ["0 mm", "DOWN"] },
]
"""


def scene(*parts: str, **values: str) -> str:
    text = "".join((HEAD, *parts))
    for name, value in ({"STEP": "1 s"} | values).items():
        text = text.replace(name, value)
    return text


def run(folder: Path, text: str, *overrides: str, out: Path | None = None) -> RunResult:
    path = folder / "case.toml"
    path.write_text('title = "a scene"\n' + text)
    return run_case(read_case(path, overrides), MPI.COMM_SELF, out)


@pytest.mark.parametrize(
    ("step", "down", "force"),
    [("1 s", "-4 mm", -21.875e3), ("0.5 s", "-3 mm", -15.625e3)],
    ids=["tunnel", "less"],
)
def test_bodies_are_not_led_through_each_other(
    tmp_path: Path, step: str, down: str, force: float
) -> None:
    # over a gap of 0.5 mm onto 16 mm of 10 MPa, 10 mm wide: force = E gap / 16 mm * 10 mm
    result = run(tmp_path, scene(LOWER, UPPER, LED, STEP=step, BOTTOM="10.5 mm", DOWN=down))
    assert result.converged, result.message
    assert result.steps[-1].forces["c"][1] == pytest.approx(force, rel=1e-6)


def test_what_nothing_finds_is_refused_with_its_place(tmp_path: Path) -> None:
    # a lid that no interface names goes 2 mm into the block below
    text = scene(
        LOWER, UPPER, """
conditions = [
    { on = "low.bottom", displacement = ["0 mm", "0 mm"] },
    { on = "up.top", displacement = ["0 mm", "-2 mm"] },
    { on = "up.bottom", displacement = ["0 mm", "-2 mm"] },
]
""", BOTTOM="10.5 mm",
    )  # fmt: skip
    result = run(tmp_path, text)
    assert result.wrong
    assert not result.converged
    assert "deep in" in result.message
    assert "\n" not in result.message
    warned = run(tmp_path, text, "solver.verify='warn'")
    assert warned.converged
    assert not warned.wrong
    assert any("0.0015 m deep in" in text for text in warned.warnings)
    silent = run(tmp_path, text, "solver.verify=false")
    assert silent.converged
    assert silent.warnings == ()


def test_an_obstacle_that_is_passed_through_is_refused(tmp_path: Path) -> None:
    text = scene(
        SINGLE, """
obstacles.stop = { shape = "polyline", points = [["20 mm", "10 mm"], ["20 mm", "-10 mm"]] }
interfaces.c = { nonmortar = "b.top", mortar = "stop" }
conditions = [{ on = "b.left", displacement = ["25 mm", "0 mm"] }]
""",
        STEP="0.2 s",
    )  # fmt: skip
    # the wrong face has the interface: nothing stops the right one
    result = run(tmp_path, text)
    assert result.wrong
    assert "'b' is" in result.message
    assert "deep in 'stop'" in result.message


@pytest.mark.parametrize("strain", ["small", "finite"])
def test_cells_that_are_turned_over_are_refused(tmp_path: Path, strain: str) -> None:
    text = scene(SINGLE, """
[[conditions]]
on = "b.bottom"
displacement = ["0 mm", "0 mm"]
[[conditions]]
on = "b.top"
displacement = { x = "0 mm", y = [["0 s", "0 mm"], ["1 s", "-7 mm"]] }
""").replace('"small"', f'"{strain}"')  # fmt: skip
    result = run(tmp_path, text, "solver.max_cutbacks=3")
    assert not result.converged
    if strain == "small":  # finite strain resists without bound
        assert result.wrong
        assert "18 of 18 cells of body 'b' are turned over" in result.message
        assert 'strain = "small"' in result.message


def test_a_run_can_be_verified_again(tmp_path: Path) -> None:
    text = scene(LOWER, UPPER, LED, STEP="0.25 s", BOTTOM="10 mm", DOWN="-0.5 mm")
    out = tmp_path / "run"
    assert run(tmp_path, text, out=out).converged
    command = [sys.executable, "-m", "contactfem", "verify", str(out)]
    found = subprocess.run(command, capture_output=True, text=True, check=False)
    assert found.returncode == ExitCode.DONE, found.stderr
    with np.load(out / "last_state.npz") as archive:
        arrays = dict(archive)
    arrays["bodies.1.x"][:, 1] -= 1e-3  # as if the upper block had sunk in
    np.savez(out / "last_state.npz", **arrays)
    found = subprocess.run(command, capture_output=True, text=True, check=False)
    assert found.returncode == ExitCode.WRONG
    assert "body 'low' is 0.001 m deep in 'up'" in found.stdout
