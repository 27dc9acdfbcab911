"""Read mesh and sets of an Abaqus or CalculiX file."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from contactfem.common.typing import Floats
from contactfem.errors import MeshError
from contactfem.meshes.abaqus_model import Model
from contactfem.meshes.abaqus_scope import Scope
from contactfem.meshes.abaqus_text import Keyword, keywords
from contactfem.meshes.raw import Collected, RawMesh

# what makes nodes or elements in ways that are not read
GENERATORS = (
    *("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM", "IMPORT"),
    *("SYMMETRICMODELGENERATION", "NODALTHICKNESSGENERATION"),
)
MESH = ("NODE", "ELEMENT", "NSET", "ELSET", "SURFACE")


@dataclass
class _Instance:
    """A part's place in the assembly: what the file says of it."""

    keyword: Keyword
    own: list[Keyword] = field(default_factory=list)


@dataclass
class _Outline:
    """Keywords of a file by where they stand."""

    model: list[Keyword] = field(default_factory=list)
    parts: dict[str, tuple[str, list[Keyword]]] = field(default_factory=dict)
    instances: list[_Instance] = field(default_factory=list)


def read_abaqus(path: Path) -> RawMesh:
    """Mesh of an input file with its sets and surfaces; parts are where their instances are.

    Groups are the sets of elements, the surfaces made of faces of elements, and the instances; node
    groups are the sets of nodes. What belongs to a part goes by its own name, and by
    "instance.name".

    Args:
        path: the file.

    Raises:
        MeshError: what is wrong or not understood, with the number of its line.
    """
    outline = _outline(keywords(path))
    model = Model()
    scopes: dict[str, Scope] = {}
    for name, own, motion in _scopes(outline):
        scope = Scope(model, scopes, name)
        for keyword in (k for k in own if k.name == "NODE"):
            scope.add_nodes(keyword)
        if motion is not None:
            scope.move(*motion)
        for keyword in (k for k in own if k.name == "ELEMENT"):
            scope.add_elements(keyword)
        scopes[name.upper()] = scope
    if not model.count:
        raise MeshError("has no *NODE and *ELEMENT: not a mesh of Abaqus or CalculiX")
    for name, own, _ in reversed(_scopes(outline)):
        for keyword in (k for k in own if k.name in ("NSET", "ELSET")):
            scopes[name.upper()].add_set(keyword)
        for keyword in (k for k in own if k.name == "SURFACE"):
            scopes[name.upper()].add_surface(keyword)
    return _mesh(model, scopes)


def _mesh(model: Model, scopes: dict[str, Scope]) -> RawMesh:
    """The whole with its groups.

    A name of an instance alone stands for that in all instances, unless the model has it.
    """
    cells = Collected()
    for block in model.blocks:
        cells.add(block.type.kind, block.rows, block.type.nodes > block.type.corners)
    top = scopes[""]
    groups, nodes = top.groups(), top.node_groups()
    taken = groups.keys() | nodes.keys()
    for scope in scopes.values():
        for name, kinds in scope.groups().items() if scope is not top else ():
            for kind, rows in kinds.items() if name not in taken else ():
                cells.add_to(name, kind, rows)
        for name, points in scope.node_groups().items() if scope is not top else ():
            if name not in taken:
                nodes[name] = np.union1d(nodes.get(name, points), points)
    groups |= cells.groups()
    notes = (*cells.notes(), *model.notes)
    return RawMesh(np.concatenate(model.points), cells.cells(), groups, nodes, notes)


def _outline(found: list[Keyword]) -> _Outline:
    """Sort keywords into those of parts, of instances, and of the model as a whole."""
    outline = _Outline()
    place = outline.model
    for keyword in found:
        if keyword.name in GENERATORS:
            raise keyword.wrong("is not read; write nodes and elements out, each in a line")
        if keyword.name == "PART":
            place = []
            outline.parts[keyword.needed("NAME").upper()] = (keyword.options["NAME"], place)
        elif keyword.name == "INSTANCE":
            outline.instances.append(_Instance(keyword))
            place = outline.instances[-1].own
        elif keyword.name in ("ENDPART", "ENDINSTANCE"):
            place = outline.model
        elif keyword.name in MESH:
            place.append(keyword)
    return outline


type _Motion = tuple[Floats, Floats, Floats, float]


def _scopes(outline: _Outline) -> list[tuple[str, list[Keyword], _Motion | None]]:
    """Name, keywords and motion of the model and of every instance."""
    scopes: list[tuple[str, list[Keyword], _Motion | None]] = [("", outline.model, None)]
    if not outline.instances:
        scopes += [(name, own, None) for name, own in outline.parts.values()]
    for instance in outline.instances:
        keyword = instance.keyword
        part = keyword.needed("PART")
        if part.upper() not in outline.parts:
            known = ", ".join(name for name, _ in outline.parts.values())
            raise keyword.wrong(f"is of the part '{part}', which is not there: {known or 'none'}")
        own = outline.parts[part.upper()][1] + instance.own
        name = keyword.needed("NAME")
        if name.upper() in (each.upper() for each, _, _ in scopes):
            raise keyword.wrong(f"is named '{name}', as another one")
        scopes.append((name, own, _motion(keyword)))
    return scopes


def _motion(keyword: Keyword) -> _Motion | None:
    """Translation, two points of the axis and the angle [rad] of an instance.

    Raises:
        MeshError: not three, or three and seven numbers.
    """
    if not keyword.data:
        return None
    try:
        rows = [[float(x) for x in t.split(",") if x.strip()] for _, t in keyword.data]
    except ValueError:
        raise keyword.wrong("has a motion that is not numbers") from None
    shift = np.array((rows[0] + [0.0] * 3)[:3])
    if len(rows) == 1 and len(rows[0]) <= 3:
        return shift, np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.0
    if len(rows) != 2 or len(rows[0]) > 3 or len(rows[1]) != 7:
        raise keyword.wrong("has a motion that is not 3 numbers, or 3 and 7 in a second line")
    a, b = np.array(rows[1][:3]), np.array(rows[1][3:6])
    if not np.linalg.norm(b - a) > 0.0:
        raise keyword.wrong("turns about an axis whose two points are one")
    return shift, a, b, float(np.deg2rad(rows[1][6]))
