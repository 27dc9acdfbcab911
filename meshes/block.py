"""Rectangle of quadrilaterals or triangles."""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from contactfem.meshes.builder import Builder, Count, PositiveLength
from contactfem.meshes.data import Floats, MeshData
from contactfem.meshes.grid import Cell2D, Pattern, graded, grid
from contactfem.units import Length

Ratio = Annotated[float, Field(gt=0)]


class Structured(Builder):
    """Rectangular array of nx by ny cells.

    `corner` is the lower left one; `pattern` says how triangles split a quadrilateral; `grading` is
    the size of the last cell over that of the first, in x (left to right) and y (bottom to top).
    """

    width: PositiveLength
    height: PositiveLength
    corner: tuple[Length, Length] = (0.0, 0.0)
    nx: Count
    ny: Count
    cell: Cell2D = "quadrilateral"
    pattern: Pattern = "right"
    grading: tuple[Ratio, Ratio] = (1.0, 1.0)

    def lines(self) -> tuple[Floats, Floats]:
        """Coordinates (nx + 1,) and (ny + 1,) [m] of the lines of the array."""
        x = self.corner[0] + self.width * graded(self.nx, self.grading[0])
        y = self.corner[1] + self.height * graded(self.ny, self.grading[1])
        return x, y


class Block(Structured):
    """Rectangle with groups left, right, bottom, top."""

    builder: Literal["block"] = "block"

    def build(self) -> MeshData:
        """Structured mesh of nx by ny quadrilaterals, or of these split into triangles."""
        points = np.stack(np.meshgrid(*self.lines()), axis=-1)
        return grid(points, self.cell, self.pattern)

    def outline(self) -> dict[str, Floats]:
        """The four sides."""
        x0, y0 = self.corner
        return rectangle(x0, y0, x0 + self.width, y0 + self.height)


def rectangle(x0: float, y0: float, x1: float, y1: float) -> dict[str, Floats]:
    """Sides of a rectangle as counter-clockwise polylines (2, 2) [m]."""
    return {
        "left": np.array([[x0, y1], [x0, y0]]),
        "right": np.array([[x1, y0], [x1, y1]]),
        "bottom": np.array([[x0, y0], [x1, y0]]),
        "top": np.array([[x1, y1], [x0, y1]]),
    }
