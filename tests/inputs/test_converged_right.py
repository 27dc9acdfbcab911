"""Scenes whose answer looked converged and was not: judged by closed forms and by each other."""

from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.results.data import RunResult
from contactfem.run.driver import run_case

HEAD = """
title = "a scene"
output = { figures = false, fields = false }
"""


def run(folder: Path, text: str, *overrides: str, comm: MPI.Comm = MPI.COMM_SELF) -> RunResult:
    path = folder / "case.toml"
    path.write_text(HEAD + text)
    result = run_case(read_case(path, overrides), comm, None)
    assert result.converged, result.message
    return result


def block(name: str, material: str, corner: tuple[float, float], size: tuple[float, float],
          cells: tuple[int, int]) -> str:  # fmt: skip
    at, extent = (f'["{a} mm", "{b} mm"]' for a, b in (corner, size))
    width, height = extent.strip("[]").split(", ")
    mesh = f'builder = "block", corner = {at}, width = {width}, height = {height}'
    mesh += f', nx = {cells[0]}, ny = {cells[1]}, cell = "quadrilateral"'
    return f'bodies.{name} = {{ material = "{material}", mesh = {{ {mesh} }} }}\n'


SOFT = (
    'strain = "finite"\ntime = { end = "1 s", step = "1 s" }\n'
    'materials.m = { youngs_modulus = "100 Pa", poisson_ratio = 0.0 }\n'
    'materials.steel = { youngs_modulus = "210 GPa", poisson_ratio = 0.0 }\n'
    + block("soft", "m", (5e4, 5e4), (10, 10), (3, 3))
)
PUSH = """
[[conditions]]
on = "soft.bottom"
displacement = ["0 mm", "0 mm"]
[[conditions]]
on = "soft.top"
traction = ["0 Pa", "-1 Pa"]
"""
STEEL = """
[[conditions]]
on = "hard.bottom"
displacement = ["0 mm", "0 mm"]
"""


def test_a_soft_body_beside_a_stiff_one_moves_as_if_it_were_alone(tmp_path: Path) -> None:
    def lowest(result: RunResult) -> float:
        return float(result.bodies[0].displacement[:, 1].min())

    alone = lowest(run(tmp_path, SOFT + PUSH))
    hard = block("hard", "steel", (6e4, 5e4), (10, 10), (3, 3))
    beside = lowest(run(tmp_path, SOFT + hard + PUSH + STEEL))
    assert alone == pytest.approx(-0.0987e-3, rel=5e-3)
    assert beside == pytest.approx(alone, rel=1e-8)
    # a load on the stiff one, 1e10 times as large, does not make the soft one's residual small
    loaded = STEEL + '[[conditions]]\non = "hard.top"\ntraction = ["0 Pa", "-10 GPa"]\n'
    assert lowest(run(tmp_path, SOFT + hard + PUSH + loaded)) == pytest.approx(alone, rel=1e-8)


OVERHANG = (
    'strain = "small"\ntime = { end = "1 s", step = "1 s" }\n'
    'materials.m = { youngs_modulus = "10 MPa", poisson_ratio = 0.3 }\n'
    + block("low", "m", (0, 0), (10, 4), (5, 3))
    + block("up", "m", (1, 4), (8, 4), (7, 3))
    + """
interfaces.c = { nonmortar = "low.top", mortar = "up.bottom", normal = { law = "multiplier" } }
[[conditions]]
on = "low.bottom"
displacement = ["0 mm", "0 mm"]
[[conditions]]
on = "up.top"
displacement = ["0 mm", "-0.1 mm"]
"""
)


@pytest.mark.parametrize("friction", ["false", "{ coefficient = 0.3 }"])
def test_an_augmented_law_ends_where_the_multiplier_does(tmp_path: Path, friction: str) -> None:
    with_friction = f"interfaces.c.friction={friction}"
    found = [
        run(tmp_path, OVERHANG, f"interfaces.c.normal.law='{law}'", with_friction)
        for law in ("multiplier", "augmented")
    ]
    p, augmented = (result.interfaces[0].pressure for result in found)
    np.testing.assert_allclose(augmented, p, rtol=0, atol=1e-5 * p.max())
    assert found[1].steps[-1].iterations < 40


STICKING = (
    'strain = "small"\ntime = { end = "1 s", step = "0.1 s" }\n'
    'materials.m = { youngs_modulus = "10 MPa", poisson_ratio = 0.3 }\n'
    + block("low", "m", (0, 0), (20, 8), (8, 4))
    + block("up", "m", (6, 8), (6, 4), (6, 4))
    + """
interfaces.c = { nonmortar = "low.top", mortar = "up.bottom", friction = { coefficient = 2.0 } }
[[conditions]]
on = "low.bottom"
displacement = ["0 mm", "0 mm"]
[[conditions]]
on = "up.top"
displacement.x = "0 mm"
displacement.y = [["0 s", "0 mm"], ["0.5 s", "-0.2 mm"], ["1 s", "-0.02 mm"]]
"""
)


@pytest.mark.parametrize("law", ["multiplier", "penalty", "augmented"])
def test_nodes_that_stick_dissipate_nothing(tmp_path: Path, law: str) -> None:
    result = run(tmp_path, STICKING, f"interfaces.c.normal.law='{law}'")
    assert all(step.slip == 0 for step in result.steps)
    assert all(step.stick > 0 for step in result.steps)
    assert [step.dissipation for step in result.steps] == [0.0] * len(result.steps)


PAD = (
    'strain = "small"\ntime = { end = "1 s", step = "0.02 s" }\nheat = { scheme = "cG(1)" }\n'
    'materials.pad = { youngs_modulus = "1 GPa", poisson_ratio = 0.3, density = "2000 kg/m^3", '
    'conductivity = "2 W/m/K", heat_capacity = "1000 J/kg/K" }\n'
    'materials.disc = { youngs_modulus = "100 GPa", poisson_ratio = 0.3, '
    'density = "7200 kg/m^3", conductivity = "40 W/m/K", heat_capacity = "460 J/kg/K" }\n'
    + block("pad", "pad", (0, 0), (10, 8), (10, 8))
    + block("disc", "disc", (-5, -10), (60, 10), (60, 8))
    + """
[interfaces.rub]
nonmortar = "NONMORTAR"
mortar = "MORTAR"
friction = { coefficient = 0.4 }
heat = { law = "insulated", partition = SHARE }
[[conditions]]
on = "disc.bottom"
displacement = ["0 mm", "0 mm"]
[[conditions]]
on = "pad.top"
[conditions.grip]
displacement.x = [["0.02 s", "0 mm"], ["1 s", "40 mm"]]
force.y = "-10 N/mm"
"""
)


@pytest.mark.parametrize(
    ("nonmortar", "mortar", "share"),
    [("disc.top", "pad.bottom", "0.75"), ("pad.bottom", "disc.top", "0.25")],
    ids=["overhanging", "covered"],
)
def test_friction_works_by_force_and_motion_on_either_side(
    tmp_path: Path, nonmortar: str, mortar: str, share: str
) -> None:
    text = PAD.replace("NONMORTAR", nonmortar).replace("MORTAR", mortar).replace("SHARE", share)
    result = run(tmp_path, text)
    # 0.4 x 10 N/mm x 40 mm = 160 J/m; a quarter into 10 mm x 8 mm of 2 MJ/m³/K = 0.25 K
    assert sum(step.dissipation for step in result.steps) == pytest.approx(160.0, rel=2e-3)
    pad = next(picture for picture in result.heat if picture.name == "pad")
    theta = pad.fields["temperature"][pad.cells, 0].mean()  # of equal cells
    assert theta == pytest.approx(0.25, rel=1e-2)
    assert all(step.dissipation >= 0.0 for step in result.steps)
