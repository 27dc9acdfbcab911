"""Everything that a mesh file holds, as arrays."""

from dataclasses import dataclass, field

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.errors import MeshError

Kinds = dict[str, Ints]

# Kinds of cells in files: their dimension and number of corners. Corners go around a face, and
# then around the opposite one, as in gmsh, meshio and Abaqus.
CORNERS: dict[str, tuple[int, int]] = {
    "vertex": (0, 1),
    "line": (1, 2),
    "triangle": (2, 3),
    "quad": (2, 4),
    "tetra": (3, 4),
    "pyramid": (3, 5),
    "wedge": (3, 6),
    "hexahedron": (3, 8),
}


@dataclass(frozen=True)
class RawMesh:
    """Everything in a file.

    Attributes:
        points: coordinates (n, 3) in the file's own unit.
        cells: corners (m, nv) by kind, a key of `CORNERS`.
        groups: named parts of these.
        node_groups: named sets of points (k,).
        notes: what of the file was left out or changed, a sentence each.
    """

    points: Floats
    cells: Kinds
    groups: dict[str, Kinds]
    node_groups: dict[str, Ints] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


class Collected:
    """Cells and groups of a file as they come, block by block."""

    def __init__(self) -> None:
        self._cells: dict[str, list[Ints]] = {}
        self._groups: dict[str, dict[str, list[Ints]]] = {}
        self._curved = 0

    def add(self, kind: str, rows: Ints, higher_order: bool) -> None:
        """Add cells by their corners; of cells with more nodes it is noted."""
        self._cells.setdefault(kind, []).append(rows)
        if higher_order and CORNERS[kind][0] > 1:
            self._curved += len(rows)

    def add_to(self, group: str, kind: str, rows: Ints) -> None:
        """Add cells to a group; nothing for no cells."""
        if len(rows):
            self._groups.setdefault(group, {}).setdefault(kind, []).append(rows)

    def notes(self) -> tuple[str, ...]:
        """What was left out of the cells."""
        if not self._curved:
            return ()
        return (
            f"{self._curved} cells of the file are of second or higher order: their corners are "
            "taken, edges are straight in between",
        )

    def cells(self) -> Kinds:
        """All cells by kind."""
        return _joined(self._cells)

    def groups(self) -> dict[str, Kinds]:
        """Cells by group and kind."""
        return {name: _joined(kinds) for name, kinds in self._groups.items()}


def corners(kind: str, rows: Ints) -> Ints:
    """Corners of cells of one kind; they come before the other nodes.

    Raises:
        MeshError: rows that are no lists of so many vertices.
    """
    count = CORNERS[kind][1]
    if rows.ndim != 2 or rows.shape[1] < count:
        raise MeshError(f"the {kind} cells of the file are not lists of vertices")
    return np.ascontiguousarray(rows[:, :count], dtype=np.int64)


def family(name: str) -> str | None:
    """Kind of a cell of any order, such as triangle for "triangle6"; None if there is none."""
    kind = name.rstrip("0123456789")
    return kind if kind in CORNERS else None


def _joined(parts: dict[str, list[Ints]]) -> Kinds:
    """One array per kind."""
    return {kind: np.concatenate(rows) for kind, rows in parts.items()}
