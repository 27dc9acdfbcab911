"""No random scene ends in a state that cannot be; the same scene seen otherwise is the same.

The independent look judges every step. `--slow` takes 300 scenes instead of 12.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scenes.scene import Scene, scene, text

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.results.data import RunResult
from contactfem.run.driver import run_case

FEW, MANY = 12, 300
SAME = 1e-8


def solved(folder: Path, s: Scene, *overrides: str, comm: MPI.Comm = MPI.COMM_SELF) -> RunResult:
    path = folder / "scene.toml"
    path.write_text(text(s))
    return run_case(read_case(path, overrides), comm, None)


def numbers(result: RunResult) -> np.ndarray:
    """Forces of all steps, and the nodal pressures at the end over the largest."""
    forces = np.array([step.forces["c"] for step in result.steps])
    p = result.interfaces[0].pressure
    scale = np.abs(forces).max() or 1.0
    return np.concatenate((forces.ravel() / scale, p / (np.abs(p).max() or 1.0)))


ALL = [
    pytest.param(number, marks=[] if number < FEW else [pytest.mark.slow]) for number in range(MANY)
]


@pytest.mark.parametrize("number", ALL)
def test_a_scene_ends_in_a_state_that_can_be(tmp_path: Path, number: int) -> None:
    result = solved(tmp_path, scene(number))
    assert result.converged, result.message
    assert result.steps[-1].forces["c"][1] < 0.0  # it is pressed
    assert all(step.dissipation >= 0.0 for step in result.steps)


@pytest.mark.parametrize("number", [0, 3])
@pytest.mark.parametrize("change", ["far", "metres", "micrometres", "no reuse"])
def test_a_scene_seen_otherwise_is_the_same(tmp_path: Path, number: int, change: str) -> None:
    s = scene(number)
    other = {
        "far": replace(s, shift=(1e3, -2e3)),
        "metres": replace(s, unit="m"),
        "micrometres": replace(s, unit="um"),
        "no reuse": s,
    }[change]
    overrides = ("solver.reuse=false",) if change == "no reuse" else ()
    found = numbers(solved(tmp_path, other, *overrides))
    expected = numbers(solved(tmp_path, s))
    assert found.shape == expected.shape
    # a metre away 1e-16 m of position are 1e-11 of what the blocks are pressed by, 10 um
    np.testing.assert_allclose(found, expected, rtol=0, atol=SAME)


@pytest.mark.parametrize("number", [n for n in range(FEW) if not scene(n).obstacle][:2])
def test_a_scene_with_its_sides_exchanged_has_the_same_force(tmp_path: Path, number: int) -> None:
    s = scene(number)
    finer = tuple((4 * nx, 4 * ny) for nx, ny in s.cells)
    s = replace(s, cells=finer, push=0.0, heat=False)
    found, expected = (
        solved(tmp_path, one).steps[-1].forces["c"][1] for one in (s.turned_round(), s)
    )
    assert found == pytest.approx(-expected, rel=0.05)  # what the meshes are good for


@pytest.mark.mpi
@pytest.mark.parametrize("number", [0, 3])
def test_a_scene_is_the_same_on_all_ranks(tmp_path: Path, number: int) -> None:
    s = scene(number)
    folder = Path(MPI.COMM_WORLD.bcast(str(tmp_path)))
    if MPI.COMM_WORLD.rank == 0:
        (folder / "scene.toml").write_text(text(s))
    MPI.COMM_WORLD.barrier()
    case = read_case(folder / "scene.toml")
    together = numbers(run_case(case, MPI.COMM_WORLD, None))
    alone = numbers(run_case(case, MPI.COMM_SELF, None))
    np.testing.assert_allclose(together, alone, rtol=0, atol=SAME)
