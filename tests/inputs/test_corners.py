"""Gaps that open away from a node make no contact: round bodies over coarse facets, corners."""

from pathlib import Path

import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.results.measures import measure
from contactfem.run.driver import run_case

ROLLER = """
title = "A roller above a coarse block: nothing may happen"
strain = "small"
time = { end = "1 s", step = "1 s" }
materials.steel = { youngs_modulus = "210 GPa", poisson_ratio = 0.3 }
[bodies.roller]
material = "steel"
[bodies.roller.mesh]
builder = "cylinder"
radius = "10 mm"
point = ["0 mm", "GAP um"]
part = "quarter"
zone = "2 mm"
size = "0.1 mm"
coarse = "2 mm"
[bodies.block]
material = "steel"
[bodies.block.mesh]
builder = "block"
corner = ["0 mm", "-10 mm"]
width = "10 mm"
height = "10 mm"
nx = 10
ny = 10
[interfaces.c]
nonmortar = "block.top"
mortar = "roller.arc"
[[conditions]]
on = "roller.flat"
displacement = ["0 mm", "0 mm"]
[[conditions]]
on = "roller.axis"
displacement.x = "0 mm"
[[conditions]]
on = "block.left"
displacement.x = "0 mm"
[[conditions]]
on = "block.bottom"
displacement.y = "0 mm"
"""


@pytest.mark.parametrize(("gap", "size"), [(5.0, 10), (5.0, 40), (1.0, 5), (1.0, 20)])
def test_a_roller_above_facets_does_not_press(tmp_path, gap, size):
    """Dual weights see h²/12R less than the gap: 8 um at 1 mm, 33 um at 2 mm facets."""
    path = tmp_path / "case.toml"
    path.write_text(ROLLER.replace("GAP", f"{gap:g}"))
    case = read_case(path, [f"bodies.block.mesh.nx={size}"])
    found = measure(run_case(case, MPI.COMM_SELF, None))
    assert found["c.normal_force"] == 0.0
    assert found["c.gap_min"] == pytest.approx(gap * 1e-6, rel=0.25)


def test_a_shrink_fit_is_uniform():
    """Lamé's pressure at every node, though polygons of unlike facets meet."""
    cases = Path(__file__).parents[2] / "cases"
    found = measure(run_case(read_case(cases / "shrink_fit.toml"), MPI.COMM_SELF, None))
    assert found["fit.pressure_min"] == pytest.approx(0.470219e6, rel=2e-3)
    assert found["fit.pressure_max"] == pytest.approx(0.470219e6, rel=2e-3)
