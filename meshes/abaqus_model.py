"""Points and elements of an Abaqus file, in one numbering."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.meshes.abaqus_elements import FACES, ElementType
from contactfem.meshes.data import numbered
from contactfem.meshes.raw import CORNERS, Kinds


@dataclass(frozen=True)
class Block:
    """Elements of one type: numbers from `first` on, corners (n, nv) by point."""

    first: int
    type: ElementType
    rows: Ints


class Model:
    """All of a file, with one numbering of points and of elements."""

    def __init__(self) -> None:
        self.points: list[Floats] = []
        self.blocks: list[Block] = []
        self.notes: list[str] = []
        self.point_count = self.count = 0

    def kinds(self, elements: Ints) -> Kinds:
        """Cells (n, nv) of elements by kind."""
        found: dict[str, list[Ints]] = {}
        for block, own in self.own(elements):
            found.setdefault(block.type.kind, []).append(block.rows[own])
        return {kind: np.concatenate(rows) for kind, rows in found.items()}

    def own(self, elements: Ints) -> Iterator[tuple[Block, Ints]]:
        """Blocks that have some of the elements, with the rows of these."""
        for block in self.blocks:
            own = elements - block.first
            own = own[(own >= 0) & (own < len(block.rows))]
            if len(own):
                yield block, own


def free_faces(chosen: Kinds, everything: Kinds) -> Iterator[Ints]:
    """Faces of chosen cells that no other cell has."""
    for count in (2, 3, 4):
        mine, others = (
            [
                rows[:, list(f)]
                for kind, rows in cells.items()
                for f in FACES.get(kind, ())
                if len(f) == count
            ]
            for cells in (chosen, everything)
        )
        if mine:
            faces = np.concatenate(mine)
            number = numbered(np.concatenate([faces, *others]))
            times = np.bincount(number[len(faces) :], minlength=int(number.max()) + 1)
            yield faces[times[number[: len(faces)]] == 1]


def face_kind(face: Ints) -> str:
    """Kind of faces (n, nv)."""
    return next(k for k, (d, n) in CORNERS.items() if n == face.shape[1] and d == min(n - 1, 2))
