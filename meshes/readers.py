"""Mesh files as arrays: cells and named groups."""

import pickle
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from subprocess import DEVNULL
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.errors import MeshError
from contactfem.meshes.gmsh_session import gmsh_session

Kinds = dict[str, Ints]
GMSH_KINDS = {1: "line", 2: "triangle", 3: "quad", 4: "tetra", 5: "hexahedron", 15: "vertex"}
KNOWN = GMSH_KINDS.values()
PATIENCE = 60.0  # seconds for a file of no size
SLOWEST = 100_000.0  # bytes per second of the rest


@dataclass(frozen=True)
class RawMesh:
    """What a file holds: points (n, 3) in its own unit, cells (m, nv) by kind, and named groups."""

    points: Floats
    cells: Kinds
    groups: dict[str, Kinds]


def read_mesh(path: Path) -> RawMesh:
    """Mesh in gmsh's format (.msh), or in any other that meshio knows.

    In a process of its own: some broken files make gmsh crash, or meshio read on for ever.

    Raises:
        MeshError: the file is not a mesh or has cells of higher order.
    """
    child = "import sys; from contactfem.meshes import readers; readers.answer(*sys.argv[1:])"
    reader = "gmsh" if path.suffix == ".msh" else "meshio"
    limit = PATIENCE + path.stat().st_size / SLOWEST
    with TemporaryDirectory() as folder:
        file = Path(folder) / "answer"
        command = [sys.executable, "-P", "-c", child, str(path), str(file)]
        try:
            done = subprocess.run(command, capture_output=True, stdin=DEVNULL, timeout=limit)
        except subprocess.TimeoutExpired:
            why = f"still not done after {limit:.0f} s"
            raise MeshError(f"not a mesh that {reader} reads ({why})") from None
        if done.returncode:
            said = done.stderr.decode(errors="replace").strip().rpartition("\n")[2]
            why = said if done.returncode > 0 else "it crashes"
            raise MeshError(f"not a mesh that {reader} reads ({why})")
        found: RawMesh | MeshError = pickle.loads(file.read_bytes())
    if isinstance(found, MeshError):
        raise found
    return found


def answer(path: str, file: str) -> None:
    """Read a mesh, and write it to a file, or the error that it is none."""
    found: RawMesh | MeshError
    try:
        found = (_read_gmsh if Path(path).suffix == ".msh" else _read_meshio)(Path(path))
    except MeshError as error:
        found = error
    Path(file).write_bytes(pickle.dumps(found))


def _read_gmsh(path: Path) -> RawMesh:
    """Mesh in gmsh's format; a physical group without a name goes by its number.

    Raises:
        MeshError: the file is not a mesh or has cells of higher order.
    """
    with path.open("rb") as file:
        if file.read(1) != b"$":  # gmsh would run it as a script
            raise MeshError("not a mesh in gmsh's format: that begins with $MeshFormat")
    with gmsh_session() as gmsh:
        try:
            gmsh.merge(str(path))
        except Exception as error:  # gmsh raises nothing more special
            raise MeshError(f"not a mesh that gmsh reads ({error})") from error
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        order = np.argsort(tags)
        number = tags[order]
        cells = _elements(gmsh, number, [(-1, -1)])
        groups: dict[str, Kinds] = {}
        for dim, tag in gmsh.model.getPhysicalGroups():
            name = gmsh.model.getPhysicalName(dim, tag) or str(tag)
            entities = [(dim, e) for e in gmsh.model.getEntitiesForPhysicalGroup(dim, tag)]
            groups.setdefault(name, {}).update(_elements(gmsh, number, entities))
    return RawMesh(coordinates.reshape(-1, 3)[order], cells, groups)


def _elements(gmsh: Any, number: Ints, entities: list[tuple[int, int]]) -> Kinds:
    """First-order elements of model entities by kind."""
    parts: dict[str, list[Ints]] = {}
    for dim, entity in entities:
        kinds, _, nodes = gmsh.model.mesh.getElements(dim, entity)
        for kind, flat in zip(kinds, nodes, strict=True):
            name, _, degree, n_nodes, *_ = gmsh.model.mesh.getElementProperties(kind)
            if kind not in GMSH_KINDS:
                _refuse(f"{name} (order {degree})")
            if not np.isin(flat, number).all():
                raise MeshError("has cells with vertices that are none of its points")
            rows = np.searchsorted(number, flat.reshape(-1, n_nodes)).astype(np.int64)
            parts.setdefault(GMSH_KINDS[kind], []).append(rows)
    return {kind: np.concatenate(rows) for kind, rows in parts.items()}


def _read_meshio(path: Path) -> RawMesh:
    """Mesh in any format that meshio knows.

    Groups are its cell sets, its point sets (of the facets between their points), and the values of
    whole-number cell data, by the name that the file has for the value or by the value.

    Raises:
        MeshError: the file is not a mesh or has cells of higher order.
    """
    import meshio

    try:
        # meshio prints, and leaves by sys.exit, when no reader understands the file.
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            mesh = meshio.read(path)
    except ImportError as error:
        raise MeshError(f"meshio needs another package to read it: {error}") from error
    except SystemExit as error:
        raise MeshError(f"not a mesh that meshio reads (as {path.suffix} file)") from error
    except Exception as error:  # whatever a reader stumbles over
        raise MeshError(f"not a mesh that meshio reads ({error})") from error
    if not mesh.points.size:
        raise MeshError("holds no points")
    parts: dict[str, list[Ints]] = {}
    groups: dict[str, dict[str, list[Ints]]] = {}
    for k, block in enumerate(mesh.cells):
        if block.type not in KNOWN:
            _refuse(block.type)
        rows = np.asarray(block.data, dtype=np.int64)
        parts.setdefault(block.type, []).append(rows)
        for name, chosen in _sets(mesh, k).items():
            if len(chosen):
                groups.setdefault(name, {}).setdefault(block.type, []).append(rows[chosen])
    points = np.zeros((len(mesh.points), 3))
    points[:, : mesh.points.shape[1]] = mesh.points
    return RawMesh(points, _joined(parts), {name: _joined(kinds) for name, kinds in groups.items()})


def _sets(mesh: Any, block: int) -> dict[str, Ints]:
    """Named parts of one of meshio's blocks: row numbers in the block."""
    rows = mesh.cells[block].data
    sets = {
        name: np.asarray(parts[block], dtype=np.int64) for name, parts in mesh.cell_sets.items()
    }
    for name, points in mesh.point_sets.items():
        sets.setdefault(name, np.flatnonzero(np.all(np.isin(rows, points), axis=1)))
    names = {int(value[0]): name for name, value in mesh.field_data.items()}
    for values in (np.asarray(data[block]) for data in mesh.cell_data.values()):
        if np.issubdtype(values.dtype, np.integer) and values.ndim == 1:
            for value in np.unique(values):
                name = names.get(int(value), str(value))
                sets.setdefault(name, np.flatnonzero(values == value))
    return sets


def _joined(parts: dict[str, list[Ints]]) -> Kinds:
    """One array per kind."""
    return {kind: np.concatenate(rows) for kind, rows in parts.items()}


def _refuse(kind: str) -> None:
    """Raise the error for cells that cannot be used."""
    raise MeshError(f"cells of kind {kind} are not supported: write a mesh of first order")
