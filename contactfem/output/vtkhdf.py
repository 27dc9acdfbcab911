"""One VTKHDF file of a run: blocks over time, meshes may change."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.output.append_file import AppendFile

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT, NAME = "VTKHDF", "fields.vtkhdf"
VERSION = (2, 3)
SAME = 1e-12  # relative difference of equal times
# cells of dolfinx: VTK's number of the kind, and its order of the vertices
POINT, LINE = (1, (0,)), (3, (0, 1))
CELLS: dict[str, tuple[int, tuple[int, ...]]] = {
    "point": POINT,
    "interval": LINE,
    "triangle": (5, (0, 1, 2)),
    "quadrilateral": (9, (0, 1, 3, 2)),
    "tetrahedron": (10, (0, 1, 2, 3)),
    "hexahedron": (12, (0, 1, 3, 2, 4, 5, 7, 6)),
}
Fields = Mapping[str, Floats]
CHUNK = 1 << 17  # bytes of a chunk, about


@dataclass(frozen=True)
class Block:
    """A mesh and its fields at one time.

    Attributes:
        name: of the block.
        points: reference positions (n, dim) [m].
        cells: vertices of the cells (m, nv), dolfinx order.
        cell_type: a key of `CELLS`.
        point_data: fields (n,) or (n, k), by name; vectors of the plane get a third component.
        cell_data: fields (m,) or (m, k), by name.
    """

    name: str
    points: Floats
    cells: Ints
    cell_type: str
    point_data: Fields
    cell_data: Fields = field(default_factory=dict)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """The open HDF5 file; what was changed in it is on the disk after that, as a whole."""
    import h5py

    file = AppendFile(path)
    try:
        new = file.seek(0, 2) == 0
        with h5py.File(file, "w" if new else "r+") as hdf:
            yield hdf
        file.commit()
    finally:
        file.close()


class VtkHdfFile:
    """Appends times to the file of a run; made and called on one rank.

    Args:
        path: the file.
        last: time [s] of the last step that counts of what is there; None begins anew.
    """

    def __init__(self, path: Path, last: float | None) -> None:
        self.path = path
        if last is None or not path.exists():
            path.unlink(missing_ok=True)
            return
        with _opened(path) as hdf:
            for group in _blocks(hdf):
                values = group["Steps/Values"][:]
                _cut(group, int(np.searchsorted(values, last * (1.0 + SAME), side="right")))

    def append(self, t: float, blocks: Sequence[Block]) -> None:
        """Add a time, as a whole or not at all.

        Args:
            t: the time, later than all others [s].
            blocks: the same names and fields each time.

        Raises:
            OSError: there is no room.
        """
        with _opened(self.path) as hdf:
            if ROOT not in hdf:
                _begin(hdf, blocks)
            for block in blocks:
                _append(hdf[ROOT][block.name], t, block)


def _begin(hdf: Any, blocks: Sequence[Block]) -> None:
    """Lay out the groups, blocks in the given order."""
    import h5py

    root = hdf.create_group(ROOT, track_order=True)
    _head(root, "MultiBlockDataSet")
    assembly = root.create_group("Assembly", track_order=True)
    for index, block in enumerate(blocks):
        group = root.create_group(block.name)
        _head(group, "UnstructuredGrid")
        group.attrs["Index"] = index
        group.create_group("Steps").attrs["NSteps"] = 0
        assembly[block.name] = h5py.SoftLink(f"/{ROOT}/{block.name}")


def _head(group: Any, kind: str) -> None:
    """Version and type, as VTK looks for them."""
    group.attrs["Version"] = np.array(VERSION)
    group.attrs["Type"] = np.bytes_(kind)


def _blocks(hdf: Any) -> list[Any]:
    """Groups of the blocks."""
    root = hdf.get(ROOT, {})
    return [group for name, group in root.items() if name != "Assembly"]


def _append(group: Any, t: float, block: Block) -> None:
    """Add a time to a block; its mesh only where it is not the one before."""
    steps = group["Steps"]
    points, kind = _padded(block.points), CELLS[block.cell_type]
    cells = np.ascontiguousarray(block.cells[:, kind[1]], dtype=np.int64)
    digest = hashlib.blake2b(points.tobytes() + cells.tobytes(), digest_size=16).hexdigest()
    if group.attrs.get("mesh") != digest:
        _add_mesh(group, points, cells, kind[0])
        group.attrs["mesh"] = digest
    part = len(group["NumberOfPoints"]) - 1
    offsets = {
        "PartOffsets": part,
        "NumberOfParts": 1,
        "PointOffsets": int(group["NumberOfPoints"][:part].sum()),
        "CellOffsets": [int(group["NumberOfCells"][:part].sum())],
        "ConnectivityIdOffsets": [int(group["NumberOfConnectivityIds"][:part].sum())],
    }
    for name, value in offsets.items():
        _grow(steps, name, np.array([value], np.int64))
    for where, data in (("PointData", block.point_data), ("CellData", block.cell_data)):
        for name, values in data.items():
            fields = group.require_group(where)
            start = len(fields[name]) if name in fields else 0
            _grow(fields, name, _padded(values) if values.ndim == 2 else values)
            _grow(steps.require_group(f"{where}Offsets"), name, np.array([start], np.int64))
    _grow(steps, "Values", np.array([t]))
    steps.attrs["NSteps"] = len(steps["Values"])


def _add_mesh(group: Any, points: Floats, cells: Ints, kind: int) -> None:
    """Append a mesh to those of a block."""
    n = cells.shape[1]
    for name, count in (("Points", len(points)), ("Cells", len(cells)), ("ConnectivityIds", 0)):
        _grow(group, f"NumberOf{name}", np.array([count or cells.size], np.int64))
    _grow(group, "Points", points)
    _grow(group, "Connectivity", cells.ravel())
    _grow(group, "Offsets", np.arange(0, cells.size + 1, n, dtype=np.int64))
    _grow(group, "Types", np.full(len(cells), kind, np.uint8))


def _padded(values: Floats) -> Floats:
    """Vectors with three components, (n, 3); other numbers of components stay."""
    values = np.asarray(values, np.float64)
    if values.shape[1] != 2:
        return np.ascontiguousarray(values)
    return np.column_stack((values, np.zeros(len(values))))


def _grow(group: Any, name: str, values: Any) -> None:
    """Append rows to a data set, which is made if it is missing."""
    if name in group:
        data = group[name]
        start = len(data)
        data.resize(start + len(values), axis=0)
        data[start:] = values
        return
    width = values.dtype.itemsize * int(np.prod(values.shape[1:]))
    rows = min(max(len(values), 64), max(CHUNK // width, 64))
    group.create_dataset(
        name, data=values, maxshape=(None, *values.shape[1:]), chunks=(rows, *values.shape[1:])
    )


def _cut(group: Any, count: int) -> None:
    """Keep the first steps of a block only."""
    steps = group["Steps"]
    if count >= len(steps["Values"]):
        return
    parts = int(steps["PartOffsets"][count - 1]) + 1 if count else 0
    sizes = {n: int(group[f"NumberOf{n}"][:parts].sum()) for n in ("Points", "Cells")}
    sizes["Connectivity"] = int(group["NumberOfConnectivityIds"][:parts].sum())
    rows = {"Points": sizes["Points"], "Connectivity": sizes["Connectivity"]}
    rows |= {"Types": sizes["Cells"], "Offsets": sizes["Cells"] + parts}
    rows |= {f"NumberOf{n}": parts for n in ("Points", "Cells", "ConnectivityIds")}
    for where in ("PointData", "CellData"):
        for name, data in group.get(where, {}).items():
            data.resize(int(steps[f"{where}Offsets"][name][count]), axis=0)
            steps[f"{where}Offsets"][name].resize(count, axis=0)
    for name, data in steps.items():
        if not name.endswith("DataOffsets"):
            data.resize(count, axis=0)
    if parts < len(group["NumberOfPoints"]):
        group.attrs["mesh"] = ""
    for name, length in rows.items():
        group[name].resize(length, axis=0)
    steps.attrs["NSteps"] = count
