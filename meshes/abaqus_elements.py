"""Elements of Abaqus: their kinds, numbers of nodes, faces."""

import re
from dataclasses import dataclass

from contactfem.meshes.raw import CORNERS

# faces S1, S2, ... by the corners of the element
FACES: dict[str, tuple[tuple[int, ...], ...]] = {
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quad": ((0, 1), (1, 2), (2, 3), (3, 0)),
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "pyramid": ((0, 1, 2, 3), (0, 4, 1), (1, 4, 2), (2, 4, 3), (3, 4, 0)),
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    "hexahedron": (
        (0, 1, 2, 3),
        (4, 7, 6, 5),
        (0, 4, 5, 1),
        (1, 5, 6, 2),
        (2, 6, 7, 3),
        (3, 7, 4, 0),
    ),
}
PLANE = {3: "triangle", 4: "quad", 6: "triangle", 8: "quad"}
SHELL = {3: "triangle", 4: "quad", 5: "quad", 6: "triangle", 8: "quad", 9: "quad"}
SOLID = {
    **{4: "tetra", 10: "tetra", 5: "pyramid", 13: "pyramid"},
    **{6: "wedge", 15: "wedge", 8: "hexahedron", 20: "hexahedron", 27: "hexahedron"},
}
LINE = {2: "line", 3: "line"}
# beginning of a type's name, before its number of nodes; letters may follow that
FAMILIES: tuple[tuple[str, dict[int, str]], ...] = (
    ("CPE|CPEG|CPS|CAX|CGAX|DC2D|DCAX|DCC2D|DCCAX|AC2D|ACAX|WARP2D", PLANE),
    ("C3D|DC3D|DCC3D|AC3D|Q3D|SC", SOLID),
    ("S|DS|M3D|R3D|SFM3D|STRI", SHELL),
    ("T2D|T3D|R2D|RAX|F2D|SAX|MAX|B2|B3|DC1D", LINE),
)
NUMBERED = ("B2", "B3", "SAX", "MAX")


@dataclass(frozen=True)
class ElementType:
    """A kind of element: its cell, how many nodes it has, and whether S1 and so on are its faces.

    Of shells and lines they are its two sides; E1 and so on are the edges of a shell.
    """

    kind: str
    nodes: int
    plane_or_solid: bool

    @property
    def corners(self) -> int:
        """Number of corners."""
        return CORNERS[self.kind][1]

    def face(self, label: str) -> tuple[int, ...] | None:
        """Corners of a face by its label, such as S1; of a shell E1. None if there is none."""
        letter = "S" if self.plane_or_solid else "E"
        faces = FACES.get(self.kind, ())
        if not re.fullmatch(rf"{letter}[1-6]", label) or int(label[1]) > len(faces):
            return None
        return faces[int(label[1]) - 1]


def element_type(name: str) -> ElementType | None:
    """A type of element by its name, such as CPE4RT; None if it is not one of cells."""
    if re.fullmatch(r"STRI65[A-Z]*", name):
        return ElementType("triangle", 6, False)
    for beginnings, kinds in FAMILIES:
        found = re.fullmatch(rf"({beginnings})(\d+)[A-Z]*5?", name)
        if found is None:
            continue
        digits = int(found[2])
        if found[1] in NUMBERED:  # B21 and SAX1 have 2 nodes, B22 and SAX2 have 3
            digits = digits + 1 if digits < 3 else 0
        if digits in kinds:
            return ElementType(kinds[digits], digits, kinds is PLANE or kinds is SOLID)
    return None
