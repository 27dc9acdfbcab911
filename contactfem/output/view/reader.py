"""Read the fields of a run back from its VTKHDF file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.errors import CaseError
from contactfem.output.append_file import recover
from contactfem.output.vtkhdf import NAME, ROOT

CORNERS = {1: 1, 3: 2, 5: 3, 9: 4, 10: 4, 12: 8}  # of VTK's kinds of cells


@dataclass(frozen=True)
class Frame:
    """A block at one time.

    Attributes:
        points: reference positions (n, 3) [m].
        cells: vertices of the cells (m, nv), VTK's order.
        kind: VTK's number of the kind of cell.
        fields: nodal fields (n,) or (n, k), by name.
    """

    points: Floats
    cells: Ints
    kind: int
    fields: dict[str, Floats]


class FieldReader:
    """The blocks of a run over time.

    Args:
        folder: folder of the run.

    Raises:
        CaseError: the run has no fields, or they cannot be read.
    """

    def __init__(self, folder: Path) -> None:
        import h5py

        path = folder / NAME
        if not folder.is_dir():
            raise CaseError(f"{folder}: no such directory; a run makes it: contactfem run CASE")
        if not path.is_file():
            raise CaseError(
                f"{folder}: has no {NAME}; output.fields = true in the case file writes it"
            )
        recover(path)
        try:
            self._file = h5py.File(path, "r")
            root = self._file[ROOT]
            self.names = list(root["Assembly"])
            self._blocks: dict[str, Any] = {name: root[name] for name in self.names}
            self.times: list[float] = list(self._blocks[self.names[0]]["Steps/Values"][:])
        except (OSError, KeyError, IndexError) as error:
            raise CaseError(f"{path}: is not a file of fields: {error}") from None

    def frame(self, name: str, step: int) -> Frame:
        """A block at a step.

        Args:
            name: one of `names`.
            step: index into `times`.

        Returns:
            Mesh and fields.
        """
        block = self._blocks[name]
        steps = block["Steps"]
        part = int(steps["PartOffsets"][step])
        n, m = (int(block[f"NumberOf{what}"][part]) for what in ("Points", "Cells"))
        first = int(steps["PointOffsets"][step])
        kind = int(block["Types"][int(steps["CellOffsets"][step, 0])])
        start = int(steps["ConnectivityIdOffsets"][step, 0])
        cells = block["Connectivity"][start : start + m * CORNERS[kind]].reshape(m, -1)
        fields = {}
        for key, data in block["PointData"].items():
            at = int(steps["PointDataOffsets"][key][step])
            fields[key] = data[at : at + n]
        return Frame(block["Points"][first : first + n], cells, kind, fields)


def outer_triangles(cells: Ints, kind: int) -> tuple[Ints, Ints]:
    """What is seen of a mesh from outside.

    Args:
        cells: vertices of the cells (m, nv), VTK's order.
        kind: VTK's number of the kind of cell.

    Returns:
        Triangles (k, 3) and edges of the faces (e, 2).
    """
    faces = cells
    if kind in FACES:
        all_faces = np.concatenate([cells[:, face] for face in FACES[kind]])
        _, first, count = np.unique(
            np.sort(all_faces, axis=1), axis=0, return_index=True, return_counts=True
        )
        faces = all_faces[first[count == 1]]
    n = faces.shape[1]
    sides = np.concatenate([faces[:, [k, (k + 1) % n]] for k in range(n)]) if n > 1 else faces
    edges = np.unique(np.sort(sides, axis=1), axis=0) if n > 1 else np.empty((0, 2), np.int64)
    if n < 3:
        return np.empty((0, 3), np.int64), edges
    triangles = np.concatenate([faces[:, [0, k, k + 1]] for k in range(1, n - 1)])
    return triangles, edges


FACES: dict[int, tuple[tuple[int, ...], ...]] = {  # of a tetrahedron and of a hexahedron in VTK
    10: ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
    12: (
        (0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7),
    ),
}  # fmt: skip
