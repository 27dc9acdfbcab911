"""Broken input through the command line, as a user sees it: one process each, its exit code."""

import subprocess
import sys
from pathlib import Path

import pytest
from fuzz.broken_meshes import Plate
from fuzz.test_mesh_files import case_of

from contactfem.errors import ExitCode

DATA = Path(__file__).resolve().parents[1] / "data"
WARM = DATA / "warm_blocks.toml"


def contactfem(*arguments: object) -> tuple[int, str]:
    """Exit code and what stands on stderr."""
    command = [sys.executable, "-m", "contactfem", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    return done.returncode, done.stderr


@pytest.mark.parametrize("verb", ["check", "run", "mesh"])
@pytest.mark.parametrize(
    ("data", "line"),
    [
        (b"\xff\xfe", "is not UTF-8 text (byte 0)"),
        (b"title = 'x", "is not TOML: "),
        (WARM.read_bytes().replace(b"steps", b"stepps"), "expect: nothing measures 'stepps'"),
        (WARM.read_bytes().replace(b"nx = 4", b"nx = 100000000"), "must be <= 100000"),
    ],
    ids=["bytes", "cut", "name", "cells"],
)
def test_a_broken_case_gives_one_line_and_two(
    verb: str, data: bytes, line: str, tmp_path: Path
) -> None:
    path = tmp_path / "case.toml"
    path.write_bytes(data)
    if verb == "mesh" and b"stepps" in data:
        return  # what is expected is nothing to a mesh
    out = () if verb == "check" else ("--out", tmp_path / "out")
    code, said = contactfem(verb, path, *out)
    assert code == ExitCode.BAD_CASE
    assert said.startswith(f"{path}: ")
    assert said.count("\n") == 1
    assert line in said


@pytest.mark.parametrize("verb", ["check", "run"])
def test_a_mesh_at_which_gmsh_crashes_gives_one_line_and_two(verb: str, tmp_path: Path) -> None:
    plate = Plate("triangle")
    plate.blocks[0][1][1, 0] = 12  # one more than there are
    plate.write(tmp_path / "mesh.msh", {"file_format": "gmsh22", "binary": False})
    path = case_of(tmp_path / "mesh.msh", body=False)
    out = () if verb == "check" else ("--out", tmp_path / "out")
    code, said = contactfem(verb, path, *out)
    assert code == ExitCode.BAD_CASE
    assert said.startswith(f"{path}: bodies.plate.mesh: {tmp_path / 'mesh.msh'}: ")
    assert said.count("\n") == 1


def test_a_load_that_nothing_can_carry_gives_three(tmp_path: Path) -> None:
    change = "conditions.1.grip.displacement.y = -1 km"
    code, said = contactfem(
        "run", WARM, "--set", change, "--set", "solver.max_cutbacks = 1", "--out", tmp_path
    )
    assert code == ExitCode.GAVE_UP
    assert said.splitlines()[-1].startswith(f"{WARM}: no equilibrium found at t = ")
    assert "Traceback" not in said
