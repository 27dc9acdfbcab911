"""Patch tests with nodes that several interfaces share: corners, junctions, stacks at a wall.

All bodies are of one material and under the same loads from above and from the side, so stresses
are uniform and interfaces stay flat whatever the meshes.
"""

from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.errors import CaseError
from contactfem.laws.active_set import Status
from contactfem.results.data import RunResult
from contactfem.run.driver import run_case

DOWN, ACROSS = 10e6, 4e6
E, NU = 1000e6, 0.3
HEAD = """
title = "corners"
strain = "small"
time = { end = "1 s", step = "1 s" }
solver = { tolerance = 1e-13 }
[materials.soft]
youngs_modulus = "1000 MPa"
poisson_ratio = 0.3
"""
FLOOR = '[obstacles.floor]\nshape = "plane"\npoint = ["0 mm", "0 mm"]\nnormal = [0, 1]\n'
WALL = '[obstacles.wall]\nshape = "plane"\npoint = ["0 mm", "0 mm"]\nnormal = [1, 0]\n'


def block(name: str, corner: tuple[float, float], nx: int, ny: int, width: float = 1.0) -> str:
    return (
        f'[bodies.{name}]\nmaterial = "soft"\n[bodies.{name}.mesh]\nbuilder = "block"\n'
        f'width = "{width} mm"\nheight = "1 mm"\nnx = {nx}\nny = {ny}\n'
        f'corner = ["{corner[0]} mm", "{corner[1]} mm"]\n'
    )


def touch(name: str, nonmortar: str, mortar: str) -> str:
    return f'[interfaces.{name}]\nnonmortar = "{nonmortar}"\nmortar = "{mortar}"\n'


def push(*surfaces: str) -> str:
    """Dead load from above on "body.top", from the right on others."""
    load = {"top": f'y = "{-DOWN} Pa"', "right": f'x = "{-ACROSS} Pa"'}
    return "".join(
        f'[[conditions]]\non = "{s}"\ntraction.{load[s.partition(".")[2]]}\n' for s in surfaces
    )


CORNER = (
    FLOOR + WALL + block("box", (0, 0), 4, 3)
    + touch("sole", "box.bottom", "floor") + touch("side", "box.left", "wall")
    + push("box.top", "box.right")
)  # fmt: skip
STACK = (
    FLOOR + WALL + "".join(block(f"b{k}", (0, k), 3 + k, 4 - k) for k in range(3))
    + touch("sole", "b0.bottom", "floor")
    + "".join(touch(f"side{k}", f"b{k}.left", "wall") for k in range(3))
    + push("b2.top", "b0.right", "b1.right", "b2.right")
)  # fmt: skip
MIDDLE_CARRIES = touch("low", "b1.bottom", "b0.top") + touch("high", "b1.top", "b2.bottom")
UPWARD = touch("low", "b0.top", "b1.bottom") + touch("high", "b1.top", "b2.bottom")
MIDDLE_MORTAR = touch("low", "b0.top", "b1.bottom") + touch("high", "b2.bottom", "b1.top")
# Two blocks side by side with one across them: the corners of the joint are on three surfaces.
JUNCTION = (
    FLOOR + WALL
    + block("b0", (0, 0), 3, 4) + block("b1", (1, 0), 4, 5) + block("b2", (0, 1), 5, 2, 2.0)
    + touch("sole0", "b0.bottom", "floor") + touch("sole1", "b1.bottom", "floor")
    + touch("side0", "b0.left", "wall") + touch("side2", "b2.left", "wall")
    + touch("joint", "b0.right", "b1.left")
    + touch("over0", "b0.top", "b2.bottom") + touch("over1", "b1.top", "b2.bottom")
    + push("b2.top", "b1.right", "b2.right")
)  # fmt: skip
SCENES = {
    "corner": CORNER,
    "middle carries": STACK + MIDDLE_CARRIES,
    "upward": STACK + UPWARD,
    "middle mortar": STACK + MIDDLE_MORTAR,
    "junction": JUNCTION,
}


def run(
    tmp_path: Path, text: str, system: str = "condensed", comm: MPI.Comm = MPI.COMM_SELF
) -> RunResult:
    path = tmp_path / "case.toml"
    path.write_text(HEAD + text)
    return run_case(read_case(path, [f'solver.system="{system}"']), comm, None)


@pytest.mark.parametrize("system", ["condensed", "saddle"])
@pytest.mark.parametrize("name", SCENES)
def test_uniform_pressure_passes(tmp_path, name, system):
    """Stresses of all bodies and all pressures are uniform to round-off."""
    result = run(tmp_path, SCENES[name], system)
    assert result.converged, result.message
    for body in result.bodies:
        stress = body.fields["stress"]
        np.testing.assert_allclose(stress[:, 0], -ACROSS, rtol=1e-10)
        np.testing.assert_allclose(stress[:, 1], -DOWN, rtol=1e-10)
        np.testing.assert_allclose(stress[:, 3], 0.0, atol=1e-10 * DOWN)
    wider = (1 + NU) / E * (NU * DOWN - (1 - NU) * ACROSS)
    higher = (1 + NU) / E * (NU * ACROSS - (1 - NU) * DOWN)
    shared = 0
    for table in result.interfaces:
        has_multiplier = table.status != Status.NONE
        shared += int((~has_multiplier).sum())
        across = table.name.startswith(("side", "joint"))
        exact = ACROSS / (1 + higher) if across else DOWN / (1 + wider)  # on the deformed length
        np.testing.assert_allclose(table.pressure[has_multiplier], exact, rtol=1e-10)
    assert shared >= 2


def test_corner_settles_as_the_mesh_is_refined(tmp_path):
    """Under shear, where stress is not uniform, the free corner reaches into the walls by O(h³)."""
    reach = []
    for n in (8, 16, 32):
        text = CORNER.replace("nx = 4\nny = 3", f"nx = {n}\nny = {n}")
        result = run(tmp_path, text + '[[conditions]]\non = "box.top"\ntraction.x = "-5 MPa"\n')
        assert result.converged, result.message
        body = result.bodies[0]
        corner = int(np.argmin(np.hypot(*body.points.T)))
        reach.append(np.abs(body.displacement[corner]).max() / np.abs(body.displacement).max())
    orders = np.log2(np.divide(reach[:-1], reach[1:]))
    assert reach[-1] < 1e-4
    assert orders.min() > 2.8


def test_a_surface_that_shares_all_its_nodes_is_refused(tmp_path):
    """With a facet between two shared nodes nobody would see contact there."""
    text = block("b0", (0, 0), 4, 3) + block("b1", (0, 1), 4, 3) + push("b1.top", "b1.right")
    text += touch("first", "b0.top", "b1.bottom") + touch("second", "b1.bottom", "b0.top")
    with pytest.raises(CaseError, match="first: nodes of the nonmortar facet"):
        run(tmp_path, text)


@pytest.mark.mpi
def test_ranks_agree(tmp_path, same):
    """Whoever owns the corners."""
    path = tmp_path / str(MPI.COMM_WORLD.rank)
    path.mkdir()
    text = SCENES["junction"]
    same(run(path, text), run(path, text, comm=MPI.COMM_WORLD), rel=1e-8)
