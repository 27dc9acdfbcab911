"""Contact of two bodies in space: the same on any number of ranks, and sliding with friction."""

from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.run.driver import run_case

CASES = Path(__file__).parents[2] / "cases"
SLIDE = """
title = "A harder box drawn over a softer one, at two angles"
dimension = "3d"
strain = "finite"
time = { end = "3 s", step = "0.5 s" }
[materials.soft]
youngs_modulus = "1 MPa"
poisson_ratio = 0.3
[materials.hard]
youngs_modulus = "10 MPa"
poisson_ratio = 0.3
[bodies.lower]
material = "soft"
mesh = { builder = "box", width = "3 m", height = "0.6 m", depth = "3 m", nx = 6, ny = 2, nz = 6 }
[bodies.upper]
material = "hard"
[bodies.upper.mesh]
builder = "box"
width = "0.8 m"
height = "0.4 m"
depth = "0.8 m"
nx = 2
ny = 1
nz = 2
corner = ["0.7 m", "0.6 m", "0.9 m"]
cell = "tetrahedron"
[interfaces.joint]
nonmortar = "upper.bottom"
mortar = "lower.top"
friction = { law = "coulomb", coefficient = 0.3 }
[[conditions]]
on = "lower.bottom"
displacement = ["0 m", "0 m", "0 m"]
[[conditions]]
on = "upper.top"
displacement.x = [["1 s", "0 m"], ["2 s", "0.3 m"], ["3 s", "0.2 m"]]
displacement.y = [["0 s", "0 m"], ["1 s", "-0.03 m"]]
displacement.z = [["1 s", "0 m"], ["2 s", "0.15 m"], ["3 s", "0.4 m"]]
"""


@pytest.fixture(scope="module")
def slide(tmp_path_factory):
    path = tmp_path_factory.mktemp("slide") / "case.toml"
    path.write_text(SLIDE)
    return read_case(path)


def test_sliding_with_friction(slide):
    """Newton's method is quadratic though the surfaces slide over several facets and turn."""
    result = run_case(slide, MPI.COMM_SELF, None)
    assert result.converged
    assert max(step.iterations for step in result.steps) <= 7
    (table,) = result.interfaces
    slips = table.status == 2
    assert slips.sum() >= 8
    np.testing.assert_allclose(table.traction[slips], 0.3 * table.pressure[slips], rtol=1e-7)
    # along the slip of the last step: by (-0.05, 0, 0.125) m of the box
    t = table.traction_vector[slips]
    along = t / np.linalg.norm(t, axis=1)[:, None] @ np.array([-0.05, 0.0, 0.125]) / 0.134629
    assert along.min() > 0.97
    assert all(step.dissipation >= 0.0 for step in result.steps[2:])


@pytest.mark.mpi
def test_ranks(slide):
    cases = [slide, read_case(CASES / "patch3d.toml", variant="hex_on_tet")]
    for case in cases:
        alone = run_case(case, MPI.COMM_SELF, None)
        shared = run_case(case, MPI.COMM_WORLD, None)
        assert [s.iterations for s in alone.steps] == [s.iterations for s in shared.steps]
        for a, b in zip(alone.interfaces, shared.interfaces, strict=True):
            np.testing.assert_array_equal(a.status, b.status)
            scale = a.pressure.max()
            np.testing.assert_allclose(b.x, a.x, rtol=1e-9)
            np.testing.assert_allclose(b.pressure, a.pressure, rtol=0, atol=1e-9 * scale)
            found, expected = b.traction_vector, a.traction_vector
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * scale)
