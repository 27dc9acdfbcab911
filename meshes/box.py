"""Box of hexahedra or tetrahedra."""

from typing import Any, Literal

import numpy as np
from pydantic import Field

from contactfem.common.typing import Floats, Ints
from contactfem.common.units import Length
from contactfem.meshes.builder import Builder, Count, PositiveLength, more
from contactfem.meshes.data import CellName, MeshData, boundary_facets, mesh_data

# Six tetrahedra around the diagonal of a cube from vertex 0 to vertex 7 (tensor order).
TETRAHEDRA = np.array(
    [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]]
)
# Axis of a side, and which end of it.
SIDES = {
    "left": (0, 0),
    "right": (0, 1),
    "bottom": (1, 0),
    "top": (1, 1),
    "back": (2, 0),
    "front": (2, 1),
}


class Box(Builder):
    """Box with groups left, right (x), bottom, top (y), back, front (z).

    `rotate` turns the diagonal of the tetrahedra by that many quarters about the y axis, so that
    the facets of two boxes on each other do not match.
    """

    builder: Literal["box"] = Field(default="box", description="box")
    width: PositiveLength = Field(description="size in x")
    height: PositiveLength = Field(description="size in y")
    depth: PositiveLength = Field(description="size in z")
    corner: tuple[Length, Length, Length] = Field(
        default=(0.0, 0.0, 0.0), description="corner with the smallest coordinates"
    )
    nx: Count = Field(description="cells in x")
    ny: Count = Field(description="cells in y")
    nz: Count = Field(description="cells in z")
    cell: Literal["hexahedron", "tetrahedron"] = Field(
        default="hexahedron", description="kind of cells"
    )
    rotate: Literal[0, 1, 2, 3] = Field(
        default=0,
        description="quarter turns about y of the diagonals of tetrahedra, so that facets of "
        "two boxes do not match",
    )

    def cell_type(self) -> CellName:
        """Kind of the cells."""
        return self.cell

    def refinement(self, factor: float) -> dict[str, Any]:
        """Numbers of cells."""
        return {name: more(getattr(self, name), factor) for name in ("nx", "ny", "nz")}

    def cell_count(self) -> float:
        """Hexahedra of the array."""
        return float(self.nx * self.ny * self.nz)

    def build(self) -> MeshData:
        """Structured mesh of nx by ny by nz hexahedra, or of these split into tetrahedra."""
        counts = np.array([self.nx, self.ny, self.nz])
        sizes = (self.width, self.height, self.depth)
        lines = [
            start + size * np.linspace(0, 1, n + 1)
            for start, size, n in zip(self.corner, sizes, counts, strict=True)
        ]
        # z varies slowest, x fastest, like the bits of a vertex's place in a hexahedron.
        points = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).transpose(2, 1, 0, 3)
        index = np.arange(points[..., 0].size, dtype=np.int64).reshape(points.shape[:3])
        hexahedra = np.stack(
            [
                index[k : k + self.nz, j : j + self.ny, i : i + self.nx].ravel()
                for k in (0, 1)
                for j in (0, 1)
                for i in (0, 1)
            ],
            axis=1,
        )
        cells = hexahedra if self.cell == "hexahedron" else self._split(hexahedra)
        facets = boundary_facets(cells, self.cell)
        flat = points.reshape(-1, 3)
        groups = {
            name: facets[np.all(flat[facets][..., axis] == lines[axis][-end], axis=1)]
            for name, (axis, end) in SIDES.items()
        }
        return mesh_data(flat, cells, self.cell, groups)

    def outline(self) -> dict[str, Floats]:
        """The corners (4, 3) of the six sides."""
        return {
            name: np.array(self.corner)
            + np.array([self.width, self.height, self.depth]) * _corners(axis, end)
            for name, (axis, end) in SIDES.items()
        }

    def _split(self, hexahedra: Ints) -> Ints:
        """Six tetrahedra per hexahedron about a diagonal."""
        turn = list(range(8))
        for _ in range(self.rotate):
            turn = [turn[k] for k in (1, 5, 3, 7, 0, 4, 2, 6)]
        return hexahedra[:, np.array(turn)[TETRAHEDRA]].reshape(-1, 4)


def _corners(axis: int, end: int) -> Floats:
    """Corners (4, 3) of a side of the unit cube."""
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=np.float64)
    return np.insert(square, axis, end, axis=1)
