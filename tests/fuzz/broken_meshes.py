"""Broken and odd mesh files: a plate of few cells, changed before it is written or afterwards."""

import io
import re
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from fuzz.mutations import damaged
from hypothesis import strategies as st

Draw = Callable[[st.SearchStrategy[Any]], Any]

# the format that meshio writes, by the file's suffix, with options
FORMATS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("msh", {"file_format": "gmsh22", "binary": False}),
    ("msh", {"file_format": "gmsh22", "binary": True}),
    ("vtu", {"binary": False}),
    ("vtu", {"binary": True}),
    ("xdmf", {"data_format": "XML"}),
    ("xdmf", {"data_format": "HDF"}),
    ("inp", {}),
    ("vtk", {"binary": False}),
    ("mesh", {}),
    ("off", {}),
    ("stl", {"binary": False}),
)
OTHER_CELLS = {
    "vertex": 1, "line3": 3, "triangle6": 6, "quad8": 8, "quad9": 9, "tetra": 4, "tetra10": 10,
    "hexahedron": 8, "wedge": 6, "pyramid": 5, "line": 2, "triangle": 3, "quad": 4,
}  # fmt: skip
SIDES = ("bottom", "right", "top", "left")
ODD_COORDINATES = (np.nan, np.inf, -np.inf, 0.0, 1.0, 1e-320, 1e200, -1e308)


class Plate:
    """Three by two squares, whole or split, with a group of facets on every side."""

    def __init__(self, cell: str) -> None:
        x, y = np.meshgrid(np.arange(4.0), np.arange(3.0))
        self.points = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
        low = (np.arange(2)[:, None] * 4 + np.arange(3)).ravel()
        quads = np.stack([low, low + 1, low + 5, low + 4], axis=1)
        cells = quads if cell == "quad" else np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
        loops = ([0, 1, 2, 3], [3, 7, 11], [11, 10, 9, 8], [8, 4, 0])
        lines = [np.array([nodes[:-1], nodes[1:]]).T for nodes in loops]
        self.blocks: list[list[Any]] = [[cell, cells, 9]]
        self.blocks += [["line", line, tag] for tag, line in enumerate(lines, start=1)]
        self.names = {name: [tag, 1] for tag, name in enumerate(SIDES, start=1)} | {"body": [9, 2]}

    def write(self, path: Path, options: dict[str, Any]) -> None:
        """Write the file as meshio does."""
        tags = [np.full(len(cells), tag) for _, cells, tag in self.blocks]
        mesh = meshio.Mesh(
            self.points,
            [(kind, cells) for kind, cells, _ in self.blocks],
            cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
            field_data={name: np.array(number) for name, number in self.names.items()},
        )
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            mesh.write(path, **options)


def _coordinate(draw: Draw, plate: Plate) -> None:
    point, axis = draw(st.integers(0, 11)), draw(st.integers(0, 2))
    plate.points[point, axis] = draw(st.sampled_from(ODD_COORDINATES))


def _same_place(draw: Draw, plate: Plate) -> None:
    a, b = (draw(st.integers(0, 11)) for _ in range(2))
    plate.points[a] = plate.points[b]


def _scale(draw: Draw, plate: Plate) -> None:
    plate.points = plate.points * draw(st.sampled_from((0.0, -1.0, 1e-200, 1e-12, 1e12, 1e200)))


def _flatten(draw: Draw, plate: Plate) -> None:
    plate.points[:, draw(st.integers(0, 2))] = draw(st.sampled_from((0.0, 1.0)))


def _vertex(draw: Draw, plate: Plate) -> None:
    """A cell or facet with another, a foreign or the same vertex."""
    cells = plate.blocks[draw(st.integers(0, len(plate.blocks) - 1))][1]
    if cells.size:
        row = cells[draw(st.integers(0, len(cells) - 1))]
        row[draw(st.integers(0, len(row) - 1))] = draw(st.sampled_from((0, 1, 5, 11, 12, 99)))


def _invert(draw: Draw, plate: Plate) -> None:
    block = draw(st.sampled_from(plate.blocks))
    rows = slice(0, draw(st.integers(0, 12)))
    block[1][rows] = block[1][rows, ::-1]


def _twice(draw: Draw, plate: Plate) -> None:
    block = draw(st.sampled_from(plate.blocks))
    block[1] = np.concatenate([block[1], block[1][: draw(st.integers(1, 3))]])


def _fewer(draw: Draw, plate: Plate) -> None:
    block = draw(st.sampled_from(plate.blocks))
    block[1] = block[1][: draw(st.integers(0, len(block[1])))]


def _without(draw: Draw, plate: Plate) -> None:
    del plate.blocks[draw(st.integers(0, len(plate.blocks) - 1))]
    if not plate.blocks:
        plate.blocks = [["vertex", np.array([[0]]), 1]]


def _other_cells(draw: Draw, plate: Plate) -> None:
    kind = draw(st.sampled_from(sorted(OTHER_CELLS)))
    block = [kind, np.arange(OTHER_CELLS[kind])[None] % 12, draw(st.integers(0, 9))]
    plate.blocks.insert(draw(st.integers(0, len(plate.blocks))), block)


def _names(draw: Draw, plate: Plate) -> None:
    name = draw(st.sampled_from(sorted(plate.names)))
    number = plate.names.pop(name)
    if draw(st.booleans()):
        plate.names[draw(st.sampled_from(("x", "body", "a b", "é", "top", "9")))] = number


def _loose_points(draw: Draw, plate: Plate) -> None:
    plate.points = np.concatenate([plate.points, plate.points[:2] + 7.0])


CHANGES = (
    _coordinate, _same_place, _scale, _flatten, _vertex, _invert, _twice, _fewer, _without,
    _other_cells, _names, _loose_points,
)  # fmt: skip
ODD_NUMBERS = (
    b"0",
    b"-1",
    b"1",
    b"2",
    b"4",
    b"13",
    b"99999999",
    b"1e400",
    b"nan",
    b"x",
    b"",
    b"2147483648",
)


@st.composite
def recounted(draw: Draw, data: bytes) -> bytes:
    """A file with one or two numbers of its text exchanged: counts, types, nodes."""
    for _ in range(draw(st.integers(1, 2))):
        numbers = list(re.finditer(rb"(?<![\w.+-])-?\d+(?![\w.])", data[:3000]))
        if numbers:
            match = draw(st.sampled_from(numbers))
            data = data[: match.start()] + draw(st.sampled_from(ODD_NUMBERS)) + data[match.end() :]
    return data


@st.composite
def mesh_files(draw: Draw, folder: Path) -> Path:
    """A mesh file in a folder, "mesh.*"; one of XDMF has its arrays beside it."""
    plate = Plate(draw(st.sampled_from(("quad", "triangle"))))
    for _ in range(draw(st.integers(0, 3))):
        draw(st.sampled_from(CHANGES))(draw, plate)
    suffix, options = draw(st.sampled_from(FORMATS))
    path = folder / f"mesh.{suffix}"
    try:
        plate.write(path, options)
    except Exception:  # meshio does not write everything; the file is cut off there
        path.touch()
    data = path.read_bytes()
    way = draw(st.integers(0, 3))
    if way == 1:
        data = draw(recounted(data))
    elif way == 2:
        data = draw(damaged(st.just(data)))
    path.write_bytes(data)
    return path
