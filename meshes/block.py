"""Rectangle of quadrilaterals or triangles."""

from dataclasses import replace
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from contactfem.common.typing import Floats
from contactfem.common.units import Length
from contactfem.meshes.builder import Builder, Count, PositiveLength, more
from contactfem.meshes.curves import Boundary, Edge
from contactfem.meshes.data import CellName, MeshData
from contactfem.meshes.grid import Cell2D, Pattern, graded, grid

Ratio = Annotated[float, Field(ge=1e-6, le=1e6)]
SAME_LINE = 1e-9  # relative to the width


class Structured(Builder):
    """Rectangular array of nx by ny cells.

    `corner` is the lower left one; `pattern` says how triangles split a quadrilateral; `grading` is
    the size of the last cell over that of the first, in x (left to right) and y (bottom to top).
    """

    width: PositiveLength = Field(description="size in x")
    height: PositiveLength = Field(description="size in y")
    corner: tuple[Length, Length] = Field(default=(0.0, 0.0), description="lower left corner")
    nx: Count = Field(description="cells in x")
    ny: Count = Field(description="cells in y")
    cell: Cell2D = Field(default="quadrilateral", description="kind of cells")
    pattern: Pattern = Field(
        default="right", description="diagonals that split quadrilaterals into triangles"
    )
    grading: tuple[Ratio, Ratio] = Field(
        default=(1.0, 1.0),
        description="size of the last cell over that of the first, in x (left to right) and y "
        "(bottom to top)",
    )

    def cell_type(self) -> CellName:
        """Kind of the cells."""
        return self.cell

    def refinement(self, factor: float) -> dict[str, Any]:
        """Numbers of cells, and gradings with which old lines of the array stay."""
        nx, ny = more(self.nx, factor), more(self.ny, factor)
        counts = ((self.nx, nx), (self.ny, ny))
        grading = [
            between(ratio, *count) for ratio, count in zip(self.grading, counts, strict=True)
        ]
        return {"nx": nx, "ny": ny} | ({"grading": grading} if grading != [1.0, 1.0] else {})

    def cell_count(self) -> float:
        """Quadrilaterals of the array."""
        return float(self.nx * self.ny)

    def lines(self) -> tuple[Floats, Floats]:
        """Coordinates (nx + 1,) and (ny + 1,) [m] of the lines of the array."""
        x = self.corner[0] + self.width * graded(self.nx, self.grading[0])
        y = self.corner[1] + self.height * graded(self.ny, self.grading[1])
        return x, y


class Block(Structured):
    """Rectangle with groups left, right, bottom, top.

    `split` gives lines of the array, by their x, that cut the top into the groups top_1, top_2, ...
    from left to right, besides the whole top.
    """

    builder: Literal["block"] = Field(default="block", description="rectangle")
    split: tuple[Length, ...] = Field(
        default=(),
        description="x of lines of the array that cut the top into groups top_1, top_2, ... "
        "from left to right",
    )

    @model_validator(mode="after")
    def _on_lines(self) -> Self:
        inner = self.lines()[0][1:-1]
        for x in self.split:
            if not np.any(np.isclose(inner, x, rtol=0.0, atol=SAME_LINE * self.width)):
                raise ValueError(f"split: no line of the array is at x = {x:g} m")
        if list(self.split) != sorted(set(self.split)):
            raise ValueError("split: positions are out of order; give ascending positions")
        return self

    def build(self) -> MeshData:
        """Structured mesh of nx by ny quadrilaterals, or of these split into triangles."""
        points = np.stack(np.meshgrid(*self.lines()), axis=-1)
        data = grid(points, self.cell, self.pattern)
        top = data.groups["top"]
        middle = data.points[top, 0].mean(axis=1)
        parts = {name: top[(middle > a) & (middle < b)] for name, a, b in self._parts()}
        return replace(data, groups=data.groups | parts)

    def outline(self) -> dict[str, Floats]:
        """The four sides, and the parts of the top."""
        x0, y0 = self.corner
        y1 = y0 + self.height
        parts = {name: np.array([[b, y1], [a, y1]]) for name, a, b in self._parts()}
        return rectangle(x0, y0, x0 + self.width, y1) | parts

    def curves(self) -> Boundary:
        """Three sides and the parts of the top."""
        x0, y0 = self.corner
        x1, y1 = x0 + self.width, y0 + self.height
        parts = self._parts()
        top = [Edge((b, y1), (a, y1), ("top", name)) for name, a, b in reversed(parts)]
        return (
            (
                Edge((x0, y0), (x1, y0), ("bottom",)),
                Edge((x1, y0), (x1, y1), ("right",)),
                *(top or [Edge((x1, y1), (x0, y1), ("top",))]),
                Edge((x0, y1), (x0, y0), ("left",)),
            ),
        )

    def _parts(self) -> list[tuple[str, float, float]]:
        """Name, smallest and largest x [m] of each part of the top."""
        if not self.split:
            return []
        ends = [self.corner[0], *self.split, self.corner[0] + self.width]
        return [(f"top_{k + 1}", a, b) for k, (a, b) in enumerate(pairwise(ends))]


def between(ratio: float, old: int, new: int) -> float:
    """Grading of `new` cells along the curve that `old` ones with a grading follow.

    Sizes grow by q per cell, q^(old - 1) the grading; with q^(old/new) every old node is one of the
    new ones if their number is a multiple.
    """
    return float(ratio ** (old * (new - 1) / (new * (old - 1)))) if old > 1 else 1.0


def rectangle(x0: float, y0: float, x1: float, y1: float) -> dict[str, Floats]:
    """Sides of a rectangle as counter-clockwise polylines (2, 2) [m]."""
    return {
        "left": np.array([[x0, y1], [x0, y0]]),
        "right": np.array([[x1, y0], [x1, y1]]),
        "bottom": np.array([[x0, y0], [x1, y0]]),
        "top": np.array([[x1, y1], [x0, y1]]),
    }
