"""A mesh builder of one's own: a symmetric trapezoid of quadrilaterals or triangles."""

from typing import Literal

import numpy as np
from pydantic import Field

from contactfem.meshes.block import Structured, rectangle
from contactfem.meshes.builder import PositiveLength
from contactfem.meshes.curves import Boundary, line
from contactfem.meshes.data import Floats, MeshData
from contactfem.meshes.grid import grid


class Trapezoid(Structured):
    """Trapezoid with groups left, right, bottom, top; `width` is that of its bottom."""

    builder: Literal["trapezoid"] = Field(default="trapezoid", description="symmetric trapezoid")
    top_width: PositiveLength = Field(description="size in x of the top")

    def build(self) -> MeshData:
        """Structured mesh whose rows shrink or grow towards the top."""
        x, y = self.lines()
        return grid(self._bent(np.stack(np.meshgrid(x, y), axis=-1)), self.cell, self.pattern)

    def outline(self) -> dict[str, Floats]:
        """The four sides, the body on the left."""
        x, y = self.lines()
        sides = rectangle(x[0], y[0], x[-1], y[-1])
        return {name: self._bent(side) for name, side in sides.items()}

    def curves(self) -> Boundary:
        """The four sides as exact curves, for adapted meshes."""
        sides = self.outline()
        return (tuple(line(sides[n], (n,)) for n in ("bottom", "right", "top", "left")),)

    def _bent(self, points: Floats) -> Floats:
        """Points (..., 2) [m] of the rectangle moved to where they are in the trapezoid."""
        middle = self.corner[0] + self.width / 2
        height = (points[..., 1] - self.corner[1]) / self.height
        factor = 1.0 + height * (self.top_width / self.width - 1.0)
        x = middle + factor * (points[..., 0] - middle)
        return np.stack([x, points[..., 1]], axis=-1)
