"""Read meshes by meshio, with their named groups."""

from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from contactfem.common.typing import Ints
from contactfem.errors import MeshError
from contactfem.meshes.raw import Collected, RawMesh, corners, family

MOST_MARKERS = 1000  # values of an array of numbers that are no whole numbers by type


def read_meshio(path: Path) -> RawMesh:
    """Mesh in any format that meshio knows.

    Groups are its cell sets, its point sets, the families of a MED file, and the values of
    whole-number cell data, by the name that the file has for the value or by the value.

    Raises:
        MeshError: the file is not a mesh, or has cells of unknown kinds.
    """
    mesh = _meshio_mesh(path)
    if not mesh.points.size:
        raise MeshError("holds no points")
    found = Collected()
    for k, block in enumerate(mesh.cells):
        kind = family(block.type)
        if kind is None:
            raise MeshError(f"cells of kind {block.type} are not supported")
        rows = corners(kind, np.asarray(block.data))
        found.add(kind, rows, block.type != kind)
        for name, chosen in _sets(mesh, k).items():
            found.add_to(name, kind, rows[chosen])
    points = np.zeros((len(mesh.points), 3))
    points[:, : mesh.points.shape[1]] = mesh.points
    return RawMesh(points, found.cells(), found.groups(), _point_sets(mesh), found.notes())


def _meshio_mesh(path: Path) -> Any:
    """What meshio makes of a file.

    Raises:
        MeshError: it does not read it; in its own words, where it has any.
    """
    import meshio

    said = StringIO()
    try:
        # meshio prints, and leaves by sys.exit, when no reader understands the file.
        with redirect_stdout(said), redirect_stderr(said):
            return meshio.read(path)
    except ImportError as error:
        raise MeshError(f"meshio needs another package to read it: {error}") from error
    except SystemExit as error:
        words = " ".join(said.getvalue().split()).removeprefix("Error: ")
        why = f": {words}" if words else ""
        raise MeshError(f"not a mesh that meshio reads (as {path.suffix} file){why}") from error
    except Exception as error:  # whatever a reader stumbles over
        raise MeshError(f"not a mesh that meshio reads ({error})") from error


def _sets(mesh: Any, block: int) -> dict[str, Ints]:
    """Named parts of one of meshio's blocks: row numbers in the block."""
    sets = {
        name: np.asarray(parts[block], dtype=np.int64) for name, parts in mesh.cell_sets.items()
    }
    names: dict[int, list[str]] = {int(v[0]): [name] for name, v in mesh.field_data.items()}
    names |= {int(value): list(of) for value, of in getattr(mesh, "cell_tags", {}).items()}
    for values in (np.asarray(data[block]) for data in mesh.cell_data.values()):
        markers = _markers(values)
        if markers is None:
            continue
        own: dict[str, list[Ints]] = {}
        for value in np.unique(markers):
            for name in names.get(int(value), [str(value)]):
                own.setdefault(name, []).append(np.flatnonzero(markers == value))
        for name, rows in own.items():
            sets.setdefault(name, np.sort(np.concatenate(rows)))
    return sets


def _markers(values: Any) -> Ints | None:
    """Cell data as whole numbers, also where a program has written them with a point."""
    if values.ndim != 1:
        return None
    if np.issubdtype(values.dtype, np.integer):
        numbers: Ints = values.astype(np.int64)
        return numbers
    if not np.issubdtype(values.dtype, np.floating) or not (np.abs(values) < 1e9).all():
        return None
    whole: Ints = np.rint(values).astype(np.int64)
    return whole if (whole == values).all() and len(np.unique(whole)) <= MOST_MARKERS else None


def _point_sets(mesh: Any) -> dict[str, Ints]:
    """Named sets of points, also those of the families of a MED file."""
    sets = {name: np.asarray(points, dtype=np.int64) for name, points in mesh.point_sets.items()}
    families = mesh.point_data.get("point_tags")
    groups: dict[str, list[int]] = {}
    for value, names in getattr(mesh, "point_tags", {}).items():
        for name in names:
            groups.setdefault(name, []).append(int(value))
    for name, values in groups.items():
        if families is not None:
            sets.setdefault(name, np.flatnonzero(np.isin(np.asarray(families), values)))
    return sets
