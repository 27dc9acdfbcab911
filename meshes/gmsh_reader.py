"""Read meshes by gmsh: .msh, universal (.unv), Nastran (.bdf)."""

from pathlib import Path
from typing import Any

import numpy as np

from contactfem.common.typing import Ints
from contactfem.errors import MeshError
from contactfem.meshes.gmsh_session import gmsh_session
from contactfem.meshes.raw import CORNERS, Collected, RawMesh

KINDS = {shape: kind for kind, shape in CORNERS.items()}


def read_gmsh(path: Path) -> RawMesh:
    """Mesh with its physical groups; one without a name goes by its number.

    A file of another program without physical groups has those of its entities, such as the
    properties of Nastran, by their numbers.

    Raises:
        MeshError: the file is not a mesh.
    """
    own = path.suffix.lower() == ".msh"
    with path.open("rb") as file:
        if own and file.read(1) != b"$":  # gmsh would run it as a script
            raise MeshError("not a mesh in gmsh's format: that begins with $MeshFormat")
    found = Collected()
    with gmsh_session() as gmsh:
        try:
            gmsh.merge(str(path))
        except Exception as error:  # gmsh raises nothing more special
            raise MeshError(f"not a mesh that gmsh reads ({error})") from error
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        order = np.argsort(tags)
        number = tags[order]
        if not len(tags):
            raise MeshError("holds no points")
        for kind, rows, higher in _elements(gmsh, number, [(-1, -1)]):
            found.add(kind, rows, higher)
        for name, entities in _named(gmsh, own):
            for kind, rows, _ in _elements(gmsh, number, entities):
                found.add_to(name, kind, rows)
    points = coordinates.reshape(-1, 3)[order]
    return RawMesh(points, found.cells(), found.groups(), notes=found.notes())


def _named(gmsh: Any, own: bool) -> list[tuple[str, list[tuple[int, int]]]]:
    """Names of groups, and the model entities (dimension, tag) in each."""
    groups = []
    for dim, tag in gmsh.model.getPhysicalGroups():
        entities = [(dim, e) for e in gmsh.model.getEntitiesForPhysicalGroup(dim, tag)]
        groups.append((gmsh.model.getPhysicalName(dim, tag) or str(tag), entities))
    if not groups and not own:
        groups = [(str(tag), [(dim, tag)]) for dim, tag in gmsh.model.getEntities()]
    return groups


def _elements(
    gmsh: Any, number: Ints, entities: list[tuple[int, int]]
) -> list[tuple[str, Ints, bool]]:
    """Elements of model entities: kind, corners (n, nv), and whether they have more nodes."""
    parts = []
    for dim, entity in entities:
        for code, flat in zip(*gmsh.model.mesh.getElements(dim, entity)[::2], strict=True):
            name, size, order, nodes, _, primary = gmsh.model.mesh.getElementProperties(code)
            kind = KINDS.get((size, primary))
            if kind is None:
                raise MeshError(f"cells of kind {name} (order {order}) are not supported")
            rows = flat.reshape(-1, nodes)[:, :primary]
            if not np.isin(rows, number).all():
                raise MeshError("has cells with vertices that are none of its points")
            parts.append((kind, np.searchsorted(number, rows).astype(np.int64), order > 1))
    return parts
