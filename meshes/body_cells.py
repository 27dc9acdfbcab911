"""One body's mesh out of what a file holds."""

from dataclasses import dataclass, replace

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.errors import MeshError
from contactfem.meshes.cell_complex import check_complex, distinct, merged
from contactfem.meshes.data import (
    CellName,
    MeshData,
    boundary_facets,
    check_points,
    matches,
    mesh_data,
)
from contactfem.meshes.raw import CORNERS, Kinds, RawMesh
from contactfem.meshes.simplices import collapsed, split_faces, tetrahedra, triangles, whole

# A cell's name in files: its dimension, our name, its vertices in dolfinx order.
CELLS: dict[str, tuple[int, CellName, list[int]]] = {
    "triangle": (2, "triangle", [0, 1, 2]),
    "quad": (2, "quadrilateral", [0, 1, 3, 2]),
    "tetra": (3, "tetrahedron", [0, 1, 2, 3]),
    "hexahedron": (3, "hexahedron", [0, 1, 3, 2, 4, 5, 7, 6]),
}
WORDS = {
    "triangle": "triangles",
    "quad": "quadrilaterals",
    "tetra": "tetrahedra",
    "pyramid": "pyramids",
    "wedge": "wedges",
    "hexahedron": "hexahedra",
}


@dataclass(frozen=True)
class FileBody:
    """A body from a file.

    Attributes:
        data: its mesh.
        notes: what was left out or changed on the way, a sentence each.
        doubts: what is hardly meant, a sentence each.
    """

    data: MeshData
    notes: tuple[str, ...]
    doubts: tuple[str, ...]


def file_body(raw: RawMesh, body: str | None, unit: float, merge: float | None) -> FileBody:
    """A body's mesh with its groups of facets and of cells.

    Args:
        raw: what the file holds.
        body: group of cells or of nodes, None for all cells.
        unit: length of its coordinates [m].
        merge: distance below which points are one [m], None to leave them.

    Returns:
        The mesh, and what there is to say about it.

    Raises:
        MeshError: no such group, no cells, or cells that do not fill a body once.
    """
    kinds = _chosen(raw, body)
    dim = _dimension(kinds)
    points = raw.points * unit
    for rows in (*kinds.values(), *(rows for kind, rows in raw.cells.items() if kind != "vertex")):
        if len(rows):
            check_points(points, rows)
    first: Ints = np.arange(len(points))
    notes = list(raw.notes)
    if merge is not None:
        first = merged(points, merge)
        notes += _merge_notes(kinds, first, merge)
    kinds, doubled = distinct({kind: first[rows] for kind, rows in kinds.items()})
    if doubled:
        notes.append(f"{doubled} cells are there twice, as those of two groups are: taken once")
    points = (
        _flat(points, np.concatenate([r.ravel() for r in kinds.values()])) if dim == 2 else points
    )
    split = len(kinds) > 1 or any(k not in CELLS or collapsed(rows) for k, rows in kinds.items())
    cells, cell_type = _cells(kinds, points, split)
    if split:
        notes.append(_split_note(kinds, cell_type))
    facets = _facet_groups(raw, body, first, cell_type)
    boundary = boundary_facets(cells, cell_type)
    if body is not None or merge is not None:
        facets = {name: rows[matches(rows, boundary) >= 0] for name, rows in facets.items()}
        facets = {name: rows for name, rows in facets.items() if len(rows)}
    for name, nodes in raw.node_groups.items():
        on = np.isin(boundary, first[nodes]).all(axis=1)
        if on.any() and name != body:
            facets.setdefault(name, boundary[on])
    data = mesh_data(points, cells, cell_type, facets)
    named = {name: parts for name, parts in raw.groups.items() if name != body}
    groups = {name: _cell_group(parts, kinds, first, points) for name, parts in named.items()}
    groups = {name: matches(rows, cells) for name, rows in groups.items() if len(rows)}
    groups = {name: np.unique(found[found >= 0]) for name, found in groups.items()}
    data = replace(data, cell_groups={name: found for name, found in groups.items() if len(found)})
    return FileBody(data, tuple(notes), check_complex(data))


def _chosen(raw: RawMesh, body: str | None) -> Kinds:
    """Cells of a body: those of the largest dimension in its group, or in the file.

    Raises:
        MeshError: there are none.
    """
    found = raw.cells if body is None else raw.groups.get(body, {})
    if not _solid(found) and body in raw.node_groups:
        nodes = raw.node_groups[body]
        found = {kind: rows[np.isin(rows, nodes).all(axis=1)] for kind, rows in raw.cells.items()}
    kinds = _solid(found)
    if not kinds and body is not None:
        names = [name for name, parts in raw.groups.items() if _solid(parts)]
        raise MeshError(f"no group of cells '{body}'; there are: {', '.join(names[:12]) or 'none'}")
    if not kinds:
        raise MeshError(
            f"a body needs cells of kind {', '.join(WORDS)}; found: {', '.join(found) or 'none'}"
        )
    dim = _dimension(kinds)
    return {kind: rows for kind, rows in kinds.items() if CORNERS[kind][0] == dim}


def _solid(kinds: Kinds) -> Kinds:
    """Cells that can fill a plane or solid body."""
    return {kind: rows for kind, rows in kinds.items() if kind in WORDS and len(rows)}


def _dimension(kinds: Kinds) -> int:
    """Largest dimension of cells."""
    return max(CORNERS[kind][0] for kind in kinds)


def _merge_notes(kinds: Kinds, first: Ints, merge: float) -> list[str]:
    """What merging did.

    Raises:
        MeshError: it joins vertices of one cell.
    """
    lost = sum(int((whole(rows) & ~whole(first[rows])).sum()) for rows in kinds.values())
    if lost:
        raise MeshError(f"merge = {merge:g} m joins vertices of one cell, in {lost} cells")
    used = np.unique(np.concatenate([rows.ravel() for rows in kinds.values()]))
    gone = len(used) - len(np.unique(first[used]))
    return [f"merge = {merge:g} m has joined {gone} nodes with others"]


def _cells(kinds: Kinds, points: Floats, split: bool) -> tuple[Ints, CellName]:
    """Cells of one kind in dolfinx order, and their name."""
    if split:
        if _dimension(kinds) == 2:
            return triangles(kinds, points), "triangle"
        return tetrahedra(kinds), "tetrahedron"
    ((kind, rows),) = kinds.items()
    _, cell_type, order = CELLS[kind]
    return rows[:, order], cell_type


def _cell_group(parts: Kinds, kinds: Kinds, first: Ints, points: Floats) -> Ints:
    """Cells (k, nv) of a group, made as those of the body are."""
    rows = {kind: first[parts[kind]] for kind in kinds if kind in parts}
    split = len(kinds) > 1 or any(k not in CELLS or collapsed(r) for k, r in kinds.items())
    return _cells(rows, points, split)[0] if rows else np.empty((0, 1), dtype=np.int64)


def _split_note(kinds: Kinds, cell_type: CellName) -> str:
    """Which cells were split."""
    found = [f"{len(rows)} {WORDS[kind]}" for kind, rows in kinds.items()]
    why = "a body has cells of one kind"
    if any(collapsed(rows) for rows in kinds.values()):
        why = "some have a vertex twice"
    elif len(found) == 1:
        why = "there are no elements for these"
    into = "triangles" if cell_type == "triangle" else "tetrahedra"
    return f"the cells, {' and '.join(found)}, are split into {into}: {why}"


def _facet_groups(
    raw: RawMesh, body: str | None, first: Ints, cell_type: CellName
) -> dict[str, Ints]:
    """Facets (k, nf) of the groups of a file that fit the cells."""
    kinds = {
        "triangle": ("line",),
        "quadrilateral": ("line",),
        "tetrahedron": ("triangle", "quad"),
        "hexahedron": ("quad",),
    }[cell_type]
    groups = {}
    for name, parts in raw.groups.items():
        found = [first[parts[kind]] for kind in kinds if kind in parts]
        if cell_type == "tetrahedron":
            found = [split_faces(rows) for rows in found]
        if found and name != body:
            rows = np.concatenate(found)
            groups[name] = rows[whole(rows)]
    return groups


def _flat(points: Floats, used: Ints) -> Floats:
    """Points in the x-y plane.

    Raises:
        MeshError: the cells are not in a plane of constant z.
    """
    size = np.ptp(points[used], axis=0)
    if size[2] > 1e-9 * max(size[0], size[1]):
        raise MeshError(
            "a plane mesh must lie in a plane of constant z, and this has no solid cells"
        )
    return points[:, :2]
