"""Whole runs from mesh files as others write them: 10 MPa everywhere, or one clear line."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from inputs.mesh_files import Block, blocks, write_case, write_inp, write_msh

from contactfem.cli.main import main
from contactfem.errors import ExitCode


def run(path: Path, *changes: str) -> tuple[int, dict[str, object]]:
    out = path.parent / "out"
    words = ["run", str(path), "--out", str(out)]
    code = main([*words, *(word for change in changes for word in ("--set", change))])
    summary = out / "summary.json"
    return code, json.loads(summary.read_text()) if summary.exists() else {}


def check(capsys: pytest.CaptureFixture[str], path: Path) -> str:
    code = main(["check", str(path)])
    said = capsys.readouterr()
    return said.out if code == ExitCode.DONE else said.err


@pytest.mark.parametrize("quads", [0, 2, 9])
@pytest.mark.parametrize("kind", ["msh", "twice", "parts", "turned", "axial"])
def test_sound_files(tmp_path: Path, kind: str, quads: int) -> None:
    """Triangles, mixed cells and quadrilaterals; CAX elements are as good as CPE ones."""
    file = tmp_path / ("mesh.msh" if kind in ("msh", "twice") else "mesh.inp")
    if file.suffix == ".msh":
        write_msh(file, blocks(quads), twice=kind == "twice")
    else:
        element = "CAX" if kind == "axial" else "CPE"
        write_inp(file, blocks(quads), element=element, turn=kind == "turned")
    code, summary = run(write_case(tmp_path, file.name))
    assert code == ExitCode.DONE, summary["verdicts"]
    assert summary["warnings"] == []


def opened(body: Block, at: float, below: float) -> Block:
    """The block with nodes of their own for the cells on the right of a column, up to a height."""
    columns = np.unique(body.points[body.sides["top"], 0])
    column = np.searchsorted(columns, at)
    count = len(columns)
    line = np.arange(len(body.points)).reshape(-1, count)[:, column]
    cut = line[body.points[line, 1] < below]
    number = np.arange(len(body.points))
    number[cut] = len(body.points) + np.arange(len(cut))
    row = np.arange(len(body.points)) % count
    beyond = row[body.triangles].max(axis=1) > column
    triangles = np.where(beyond[:, None], number[body.triangles], body.triangles)
    points = np.concatenate([body.points, body.points[cut]])
    return replace(body, points=points, triangles=triangles)


def cells_apart(body: Block) -> Block:
    """Every cell with nodes of its own; the sides keep theirs."""
    first = len(body.points)
    points = np.concatenate([body.points, body.points[body.triangles].reshape(-1, 2)])
    triangles = first + np.arange(3 * len(body.triangles)).reshape(-1, 3)
    return replace(body, points=points, triangles=triangles)


@pytest.mark.parametrize(("height", "places", "halves"), [(5.0, 3, False), (9.0, 5, True)])
def test_slits_are_warned_about_and_merged(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    height: float,
    places: int,
    halves: bool,
) -> None:
    upper, lower = blocks()
    write_msh(tmp_path / "mesh.msh", (opened(upper, 7.0, height), lower))
    path = write_case(tmp_path, "mesh.msh")
    words = f"at {places} places several nodes lie that are not one, the first at (0.0072, 0) m"
    said = check(capsys, path)
    assert f"WARNING: {words}" in said
    assert ("in 2 pieces" in said) == halves
    code, summary = run(path)
    assert code == ExitCode.MISSED  # the answer of such a body is that of an open one
    warnings = summary["warnings"]
    assert isinstance(warnings, Sequence)
    assert warnings[0].startswith(f"bodies.upper.mesh: {words}")
    assert len(warnings) == 1 + halves
    assert f"WARNING: {warnings[0]}" in capsys.readouterr().out
    code, summary = run(path, 'bodies.upper.mesh.merge="1e-6 mm"')
    assert (code, summary["warnings"]) == (ExitCode.DONE, [])


def test_cells_that_share_no_node(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """No facet of a side is one of a cell; the error says why, and merging mends it."""
    upper, lower = blocks()
    write_msh(tmp_path / "mesh.msh", (cells_apart(upper), lower))
    path = write_case(tmp_path, "mesh.msh")
    said = check(capsys, path)
    assert "'upper' has no surface 'upper_left' with facets; it has no named surfaces; at" in said
    assert said.count("\n") == 1
    code, summary = run(path, 'bodies.upper.mesh.merge="1e-6 mm"')
    assert (code, summary["warnings"]) == (ExitCode.DONE, [])


def moved(body: Block, node: int, to: tuple[float, float]) -> Block:
    points = body.points.copy()
    points[node] = to
    return replace(body, points=points)


@pytest.mark.parametrize("command", ["check", "run"])
def test_folded_and_flat_cells(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    upper, lower = blocks()
    path = write_case(tmp_path, "mesh.msh")
    write_msh(tmp_path / "mesh.msh", (moved(upper, 8, (8.0, 1.5)), lower))
    assert main([command, str(path)]) == ExitCode.BAD_CASE
    said = capsys.readouterr().err
    assert "bodies.upper.mesh: " in said
    assert "cells overlap near (0.00" in said
    assert said.count("\n") == 1
    a, b, node = upper.triangles[0]  # of its corners the last one lies inside
    between = 0.5 * (upper.points[a] + upper.points[b])
    write_msh(tmp_path / "mesh.msh", (moved(upper, node, (between[0], between[1])), lower))
    assert main([command, str(path)]) == ExitCode.BAD_CASE
    said = capsys.readouterr().err
    assert "1 of 40 cells are flat or twisted, the first near (0.00" in said
    assert said.count("\n") == 1


@pytest.mark.parametrize("command", ["check", "run"])
def test_a_wrong_dimension(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    """A brick in a plane case; a plane mesh in a solid one."""
    corners = ["0,0,0", "1,0,0", "1,1,0", "0,1,0", "0,0,1", "1,0,1", "1,1,1", "0,1,1"]
    nodes = "\n".join(f"{k}, {x}" for k, x in enumerate(corners, start=1))
    brick = f"*NODE\n{nodes}\n*ELEMENT, TYPE=C3D8, ELSET=upper\n1, 1,2,3,4,5,6,7,8\n"
    (tmp_path / "brick.inp").write_text(brick)
    write_inp(tmp_path / "mesh.inp", blocks())
    path = write_case(tmp_path, "mesh.inp")
    assert main([command, str(path), "--set", "bodies.upper.mesh.file=brick.inp"]) == 2
    said = capsys.readouterr().err
    assert said == f"{path}: bodies.upper.mesh: is in 3D; dimension = plane strain\n"
    solid = tmp_path / "solid.toml"
    solid.write_text(
        'title = "A plane mesh in a solid case"\ndimension = "3d"\n'
        'time = { end = "1 s", step = "1 s" }\n'
        '[materials.steel]\nyoungs_modulus = "200 GPa"\npoisson_ratio = 0.3\n'
        '[bodies.lower]\nmaterial = "steel"\n'
        'mesh = { file = "mesh.inp", unit = "mm", body = "lower" }\n'
        '[[conditions]]\non = "lower.base"\ndisplacement = ["0 mm", "0 mm", "0 mm"]\n'
    )
    assert main([command, str(solid)]) == ExitCode.BAD_CASE
    said = capsys.readouterr().err
    assert said == f"{solid}: bodies.lower.mesh: is in 2D; dimension = 3d\n"


def test_a_thermal_mesh_is_looked_into_as_well(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    upper, lower = blocks()
    write_msh(tmp_path / "mesh.msh", (upper, lower))
    write_msh(tmp_path / "slit.msh", (opened(upper, 7.0, 5.0), lower))
    path = write_case(tmp_path, "mesh.msh")
    text = path.read_text().replace("[bodies.upper]", "[heat]\n[bodies.upper]")
    steel = 'density = "1 kg/m^3"\nconductivity = "1 W/m/K"\nheat_capacity = "1 J/kg/K"\n'
    text = text.replace("poisson_ratio = 0.25\n", f"poisson_ratio = 0.25\n{steel}")
    thermal = 'thermal_mesh = { file = "slit.msh", unit = "mm", body = "upper" }\n'
    path.write_text(text.replace("[bodies.lower]", f"{thermal}[bodies.lower]"))
    assert "WARNING: at 3 places several nodes" in check(capsys, path)


def test_files_without_named_surfaces(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bare = tuple(replace(body, sides={}) for body in blocks())
    write_msh(tmp_path / "mesh.msh", bare)
    path = write_case(tmp_path, "mesh.msh")
    said = check(capsys, path)
    assert "'upper' has no surface 'upper_left' with facets; it has no named surfaces\n" in said
