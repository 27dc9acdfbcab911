"""A refined builder makes cells of half the size everywhere, in the same groups."""

from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter

from contactfem.errors import MeshError
from contactfem.meshes import BUILDERS, Builder, MeshSpec
from contactfem.meshes.data import MeshData, jacobians

BLOCK = {"builder": "block", "width": "2 m", "height": "1 m", "nx": 6, "ny": 4}
WAVE = {"builder": "wave", "width": "2 m", "height": "1 m", "nx": 16, "ny": 3}
WAVE |= {"amplitude": "10 mm", "wavelength": "2 m", "grading": [1, 5]}
DISK = {"builder": "cylinder", "radius": "8 mm", "zone": "1 mm", "size": "0.1 mm", "growth": 0.2}
FINE = {"builder": "graded_block", "width": "100 mm", "height": "200 mm", "zone": ["0 mm", "9 mm"]}
FINE |= {"size": "1 mm", "growth": 0.2}
BOX = {"builder": "box", "width": "2 m", "height": "1 m", "depth": "3 m", "nx": 3, "ny": 2, "nz": 4}
DIE = {"builder": "die", "width": "1.2 m", "straight": "0.9 m", "radius": "0.75 m"}
PLANE = BLOCK | {"corner": ["1 m", "0 m"]}
GRADED = {"builder": "graded_box", "width": "2 m", "height": "1 m", "depth": "2 m"}
GRADED |= {"zone_x": ["0 m", "2 m"], "zone_z": ["0 m", "2 m"], "size": "0.1 m", "coarse": "0.1 m"}
TABLES: dict[str, dict[str, Any]] = {
    "block": BLOCK,
    "one cell": BLOCK | {"nx": 1, "ny": 1},
    "graded": BLOCK | {"grading": [3, 0.5], "cell": "triangle"},
    "split": BLOCK | {"nx": 5, "corner": ["-1 m", "2 m"], "split": ["-0.6 m", "0.6 m"]},
    "wave": WAVE,
    "triangles in a half disk": DISK,
    "array in a quarter disk": DISK | {"part": "quarter", "cell": "quadrilateral"},
    "graded_block": FINE,
    "box": BOX,
    "extrusion": {"builder": "extrusion", "plane": BLOCK, "depth": "3 m", "layers": 2},
    "revolution": {"builder": "revolution", "plane": PLANE, "layers": 36},
    "graded_box": GRADED,
    "die": DIE | {"n_arc": 24, "n_side": 7},
    "tire": {"builder": "tire", "size": "3 mm", "tread_size": "1.5 mm"},
    "disk": {"builder": "disk", "radius": "2 m", "facets": 40, "layers": 4},
    "ring": {"builder": "ring", "inner_radius": "2 m", "outer_radius": "3 m", "facets": 36}
    | {"layers": 4},
}  # fmt: skip
NESTED = (
    "block",
    "one cell",
    "graded",
    "split",
    "wave",
    "box",
    "ring",
    "extrusion",
    "graded_box",
    "revolution",
)
EVEN = ("block", "one cell", "split", "box", "die", "ring")


def spec(table: dict[str, Any]) -> Builder:
    return TypeAdapter(MeshSpec).validate_python(table, context={"strict_units": True})


def sizes(data: MeshData) -> dict[str, float]:
    """Mean facet length of every group, or the mean square root of its facets' areas."""
    return {
        name: float(np.mean([np.linalg.norm(np.ptp(data.points[f], axis=0)) for f in facets]))
        for name, facets in data.groups.items()
    }


def cell_sizes(data: MeshData) -> np.ndarray:
    return np.abs(jacobians(data.points, data.cells, data.cell_type)).mean(axis=1)


def test_every_builder_is_refined_here() -> None:
    assert {table["builder"] for table in TABLES.values()} == set(BUILDERS)


@pytest.mark.parametrize("name", TABLES)
def test_half_the_size_in_the_same_groups(name: str) -> None:
    builder = spec(TABLES[name])
    coarse, fine = builder.build(), builder.refined(2.0).build()
    assert coarse.cell_type == fine.cell_type
    assert coarse.groups.keys() == fine.groups.keys()
    times = 2 ** coarse.points.shape[1]
    exact = name in NESTED + EVEN
    assert len(fine.cells) / len(coarse.cells) == pytest.approx(times, rel=1e-12 if exact else 0.12)
    before, after = sizes(coarse), sizes(fine)
    # sizes that grow from cell to cell follow size + growth * distance only as they get small
    near = 0.07 if name == "array in a quarter disk" else 0.05
    assert after == pytest.approx({k: h / 2 for k, h in before.items()}, rel=near)
    smallest, largest = cell_sizes(coarse).min(), cell_sizes(coarse).max()
    tight = 1e-9 if name in EVEN and name not in ("die", "ring") else 0.5
    assert cell_sizes(fine).min() == pytest.approx(smallest / times, rel=tight)
    assert cell_sizes(fine).max() == pytest.approx(largest / times, rel=tight)


@pytest.mark.parametrize("name", NESTED)
def test_old_nodes_stay(name: str) -> None:
    """Lines of a graded array stay too; the ring's inner polygon changes with its facets."""
    builder = spec(TABLES[name])
    coarse, fine = builder.build().points, builder.refined(3.0).build().points
    away = np.array([np.linalg.norm(fine - x, axis=1).min() for x in coarse])
    assert away.max() < (0.02 if name == "ring" else 1e-12)


@pytest.mark.parametrize("name", TABLES)
def test_changes_can_stand_in_a_case_file(name: str) -> None:
    """As a case file gives them, with units, they make the refined builder, to the last digit."""
    builder = spec(TABLES[name])
    table = {**TABLES[name]}
    for key, value in builder.refinement(2.0).items():
        outer, dot, inner = key.partition(".")
        table[outer] = table[outer] | {inner: value} if dot else value
    assert spec(table) == builder.refined(2.0)


@pytest.mark.parametrize("name", TABLES)
def test_factor_one_changes_no_node(name: str) -> None:
    builder = spec(TABLES[name])
    np.testing.assert_allclose(builder.refined(1.0).build().points, builder.build().points)


def test_coarser_meshes_keep_one_cell() -> None:
    coarse = spec(BLOCK).refined(0.1)
    assert len(coarse.build().cells) == 1
    assert spec(TABLES["disk"]).refined(0.1).build().groups["rim"].shape == (8, 2)


def test_files_are_not_refined(tmp_path) -> None:
    path = tmp_path / "a.msh"
    path.write_text("not read")
    builder = spec({"file": str(path), "unit": "mm"})
    with pytest.raises(MeshError, match=r"a\.msh: a mesh from a file cannot be refined"):
        builder.refined(2.0)
