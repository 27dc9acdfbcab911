"""Nodes, elements, sets and surfaces of an Abaqus model."""

from collections.abc import Iterator

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.errors import MeshError
from contactfem.meshes.abaqus_elements import element_type
from contactfem.meshes.abaqus_model import Block, Model, face_kind, free_faces
from contactfem.meshes.abaqus_text import Keyword, numbers, records, whole_number
from contactfem.meshes.raw import Kinds


class _Set:
    """A set as it grows: its name as first written, its members, whether it is to be shown."""

    def __init__(self, name: str, shown: bool) -> None:
        self.name, self.shown = name, shown
        self.members: Ints = np.empty(0, dtype=np.int64)

    def add(self, members: Ints) -> None:
        """Add members."""
        self.members = np.union1d(self.members, members)


class Scope:
    """Labels and names of the model, or of one instance, and what they stand for."""

    def __init__(self, model: Model, scopes: dict[str, "Scope"], name: str) -> None:
        self.model, self.scopes, self.name = model, scopes, name
        self.nodes: dict[int, int] = {}
        self.elements: dict[int, int] = {}
        self.sets: dict[str, dict[str, _Set]] = {"NSET": {}, "ELSET": {}}
        self.surfaces: dict[str, tuple[str, Kinds]] = {}
        self.surface_nodes: dict[str, tuple[str, Ints]] = {}
        self.left_out: set[int] = set()
        self._points: list[Floats] = []

    def add_nodes(self, keyword: Keyword) -> None:
        """Read *NODE: label, x, y, z in a line, or cylindrical or spherical coordinates.

        Raises:
            MeshError: a line that is not numbers.
        """
        labels = np.empty(len(keyword.data), dtype=np.int64)
        points: Floats = np.zeros((len(keyword.data), 3))
        for k, (line, text) in enumerate(keyword.data):
            values = numbers(line, text)
            labels[k] = whole_number(line, values[0])
            points[k, : len(values[1:4])] = values[1:4]
        system = keyword.options.get("SYSTEM", "R").upper()
        if system not in ("R", "C", "S"):
            raise keyword.wrong(f"has coordinates in a system '{system}': R, C or S is read")
        points = _cartesian(points, system)
        first = self.model.point_count
        self.model.points.append(points)
        self._points.append(points)
        self.model.point_count += len(points)
        self.nodes.update(zip(labels.tolist(), range(first, first + len(points)), strict=True))
        if name := keyword.options.get("NSET"):
            self._set("NSET", name).add(np.arange(first, first + len(points)))

    def move(self, shift: Floats, a: Floats, b: Floats, angle: float) -> None:
        """Shift all nodes, then turn them about the axis from a to b by an angle [rad]."""
        for points in self._points:
            points += shift - a
            points[:] = _turned(points, (b - a) / np.linalg.norm(b - a), angle) + a

    def add_elements(self, keyword: Keyword) -> None:
        """Read *ELEMENT: label and nodes, over as many lines as they take.

        Raises:
            MeshError: a line that is not whole numbers, or a node that is not there.
        """
        name = keyword.needed("TYPE").upper()
        kind = element_type(name)
        if kind is None:
            self._leave_out(keyword, name)
            return
        labels: list[int] = []
        rows: list[list[int]] = []
        for line, values in records(keyword, kind.nodes + 1):
            label = whole_number(line, values[0])
            if label in self.elements:
                raise MeshError(f"{line}: there is an element {label} already")
            self.elements[label] = self.model.count + len(labels)
            labels.append(label)
            rows.append([self._node(line, value) for value in values[1 : kind.corners + 1]])
        first = self.model.count
        if labels:
            block = Block(first, kind, np.array(rows, dtype=np.int64))
            self.model.blocks.append(block)
            self.model.count += len(labels)
        if name := keyword.options.get("ELSET", ""):
            self._set("ELSET", name).add(np.arange(first, self.model.count))

    def _leave_out(self, keyword: Keyword, kind: str) -> None:
        """Note elements that are no cells; sets may name them."""
        self.model.notes.append(f"{keyword.line}: elements of type {kind} are left out")
        words = [text.partition(",")[0].strip() for _, text in keyword.data]
        self.left_out.update(int(word) for word in words if word.isdigit())
        if name := keyword.options.get("ELSET", ""):
            self._set("ELSET", name)

    def add_set(self, keyword: Keyword) -> None:
        """Read *NSET or *ELSET: labels, names of sets, or ranges.

        Raises:
            MeshError: something that is not there.
        """
        kind = keyword.name
        shown = "INTERNAL" not in keyword.options
        target = self._set(kind, keyword.needed(kind), shown)
        scope = self._instance(keyword, keyword.options.get("INSTANCE", ""))
        if kind == "NSET" and (name := keyword.options.get("ELSET")):
            parts = self.model.kinds(scope.members(keyword, keyword.line, "ELSET", name))
            target.add(np.unique(np.concatenate([r.ravel() for r in parts.values()])))
        for line, text in keyword.data:
            if "GENERATE" in keyword.options:
                target.add(scope.range(kind, line, text))
            else:
                for word in filter(None, (word.strip(" \"'") for word in text.split(","))):
                    target.add(scope.members(keyword, line, kind, word))

    def add_surface(self, keyword: Keyword) -> None:
        """Read *SURFACE: faces of elements, or nodes.

        Raises:
            MeshError: elements or faces that are not there.
        """
        name, kind = keyword.needed("NAME"), keyword.options.get("TYPE", "ELEMENT").upper()
        if kind not in ("ELEMENT", "NODE") or "COMBINE" in keyword.options:
            self.model.notes.append(
                f"{keyword.line}: the surface '{name}' is left out: only those of faces of "
                "elements and of nodes are read"
            )
            return
        entries = [(line, *_entry(text)) for line, text in keyword.data]
        if kind == "NODE":
            parts = [self.members(keyword, line, "NSET", what) for line, what, _ in entries]
            nodes = np.unique(np.concatenate([np.empty(0, np.int64), *parts]))
            self.surface_nodes[name.upper()] = (name, nodes)
            return
        faces: dict[str, list[Ints]] = {}
        for line, what, label in entries:
            for face in self._faces(line, self.members(keyword, line, "ELSET", what), label):
                faces.setdefault(face_kind(face), []).append(face)
        joined = {of: np.concatenate(rows) for of, rows in faces.items()}
        self.surfaces[name.upper()] = (name, joined)

    def members(self, keyword: Keyword, line: str, kind: str, word: str) -> Ints:
        """Nodes or elements that a label or a name stands for, "instance.name" as well.

        Raises:
            MeshError: there are none.
        """
        owner, dot, inner = word.partition(".")
        if dot and owner.upper() in self.scopes:
            return self.scopes[owner.upper()].members(keyword, line, kind, inner)
        labels = self.nodes if kind == "NSET" else self.elements
        if word.isdigit():
            if int(word) in labels:
                return np.array([labels[int(word)]], dtype=np.int64)
            if kind == "ELSET" and int(word) in self.left_out:
                return np.empty(0, dtype=np.int64)
            what = "node" if kind == "NSET" else "element"
            raise MeshError(f"{line}: *{keyword.name} names the {what} {word}, which is not there")
        if word.upper() in self.sets[kind]:
            return self.sets[kind][word.upper()].members
        known = ", ".join(list(each.name for each in self.sets[kind].values())[:12])
        what = "set of nodes" if kind == "NSET" else "set of elements"
        raise MeshError(f"{line}: there is no {what} '{word}'; there are: {known or 'none'}")

    def range(self, kind: str, line: str, text: str) -> Ints:
        """Members from one label to another in steps; those that are not there are left out.

        Raises:
            MeshError: not two or three whole numbers.
        """
        values = [whole_number(line, value) for value in numbers(line, text)]
        if len(values) not in (2, 3) or (len(values) == 3 and values[2] < 1):
            raise MeshError(f"{line}: a range is a first label, a last one and a step")
        first, last, step = (*values, 1)[:3]
        labels = self.nodes if kind == "NSET" else self.elements
        return np.array(
            [n for at, n in labels.items() if first <= at <= last and not (at - first) % step],
            dtype=np.int64,
        )

    def groups(self) -> dict[str, Kinds]:
        """Cells of sets of elements and faces of surfaces, by their names here and from outside."""
        named = {
            each.name: self.model.kinds(each.members)
            for each in self.sets["ELSET"].values()
            if each.shown and len(each.members)
        }
        for name, kinds in self.surfaces.values():
            named[name] = named.get(name, {}) | kinds
        if self.name:
            named |= {f"{self.name}.{name}": kinds for name, kinds in named.items()}
            everything = np.array(sorted(self.elements.values()), dtype=np.int64)
            named[self.name] = self.model.kinds(everything)
        return named

    def node_groups(self) -> dict[str, Ints]:
        """Sets of nodes, by their names here and from outside."""
        named = {each.name: each.members for each in self.sets["NSET"].values() if each.shown}
        named |= dict(self.surface_nodes.values())
        return named | {f"{self.name}.{n}": m for n, m in named.items() if self.name}

    def _set(self, kind: str, name: str, shown: bool = True) -> _Set:
        """The set of a name, a new one where there is none."""
        return self.sets[kind].setdefault(name.upper(), _Set(name, shown))

    def _instance(self, keyword: Keyword, name: str) -> "Scope":
        """The scope that a keyword's INSTANCE= names, or this one."""
        if not name:
            return self
        if name.upper() not in self.scopes:
            raise keyword.wrong(f"is of the instance '{name}', which is not there")
        return self.scopes[name.upper()]

    def _node(self, line: str, value: float) -> int:
        """Point of a node's label.

        Raises:
            MeshError: there is no such node.
        """
        if (found := self.nodes.get(whole_number(line, value))) is None:
            raise MeshError(f"{line}: there is no node {value:.0f}")
        return found

    def _faces(self, line: str, elements: Ints, label: str) -> Iterator[Ints]:
        """One face of each of the elements; all that belong to one element only without a label.

        Raises:
            MeshError: elements of this kind have no such face.
        """
        if not label:
            yield from free_faces(
                self.model.kinds(elements), self.model.kinds(np.arange(self.model.count))
            )
            return
        for block, own in self.model.own(elements):
            face = block.type.face(label)
            if face is not None:
                yield block.rows[own][:, list(face)]
            elif label in ("SPOS", "SNEG", "SP", "SN") and not block.type.plane_or_solid:
                yield block.rows[own]
            else:
                raise MeshError(f"{line}: {block.type.kind} elements have no face {label}")


def _entry(text: str) -> tuple[str, str]:
    """What a line of a surface names, and the label of the face."""
    words = [*(word.strip() for word in text.split(",")), ""]
    return words[0], words[1].upper()


def _cartesian(points: Floats, system: str) -> Floats:
    """Coordinates (n, 3) from cylindrical (C) or spherical (S) ones, angles in degrees."""
    if system == "R":
        return points
    r, around, third = points.T
    theta = np.deg2rad(around)
    flat, z = (
        (r, third)
        if system == "C"
        else (r * np.cos(np.deg2rad(third)), r * np.sin(np.deg2rad(third)))
    )
    return np.stack([flat * np.cos(theta), flat * np.sin(theta), z], axis=1)


def _turned(x: Floats, axis: Floats, angle: float) -> Floats:
    """Points (n, 3) turned about an axis through the origin (Rodrigues' formula)."""
    along = np.outer(x @ axis, axis)
    turned: Floats = along + np.cos(angle) * (x - along) + np.sin(angle) * np.cross(axis, x)
    return turned
