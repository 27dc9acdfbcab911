"""Rectangle of triangles, fine on part of its top or bottom."""

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from contactfem.common.typing import Floats
from contactfem.common.units import Length
from contactfem.meshes.block import rectangle
from contactfem.meshes.builder import Builder, PositiveLength, graded_count, smaller
from contactfem.meshes.curves import Boundary, Edge, mapped
from contactfem.meshes.data import MeshData, mesh_data
from contactfem.meshes.polygon import triangulate


class GradedBlock(Builder):
    """Rectangle that is fine on a part of one side.

    Facets have at most the length `size` on the part `zone` of the top or bottom (`side`).
    `corner` is the lower left one, `zone` the smallest and largest x of the fine part. From there
    cells grow by `growth` per distance up to `coarse`.
    Groups: left, right, bottom, top, and contact, the fine part.
    """

    builder: Literal["graded_block"] = Field(
        default="graded_block", description="rectangle that is fine on a part of one side"
    )
    width: PositiveLength = Field(description="size in x")
    height: PositiveLength = Field(description="size in y")
    corner: tuple[Length, Length] = Field(default=(0.0, 0.0), description="lower left corner")
    side: Literal["top", "bottom"] = Field(default="top", description="side with the fine part")
    zone: tuple[Length, Length] = Field(description="smallest and largest x of the fine part")
    size: PositiveLength = Field(description="largest facet in the zone")
    growth: Annotated[float, Field(gt=0, le=1)] = Field(
        default=0.1, description="growth of the cell size per distance from the zone"
    )
    coarse: PositiveLength | None = Field(default=None, description="largest cell size")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        x0, x1 = self.corner[0], self.corner[0] + self.width
        slack = 1e-9 * self.width
        if not x0 - slack <= self.zone[0] < self.zone[1] <= x1 + slack:
            raise ValueError(f"zone: must be a part of the width, from {x0} m to {x1} m")
        return self

    def refinement(self, factor: float) -> dict[str, Any]:
        """Sizes and their growth."""
        return smaller(factor, self.growth, size=self.size, coarse=self._largest())

    def cell_count(self) -> float:
        """As sizes grow from the fine part."""
        extent, zone = max(self.width, self.height), self.zone[1] - self.zone[0]
        coarse = max(self.size, self._largest())
        return graded_count(max(zone, 0.0), self.size, self.growth, coarse, extent)

    def build(self) -> MeshData:
        """Triangles, made with the fine part on top and turned over if it is the bottom."""
        data = triangulate(self._edges(), self.size, self.growth, self._largest())
        points = data.points if self.side == "top" else data.points * [1, -1] + [0, self.height]
        return mesh_data(points + np.array(self.corner), data.cells, data.cell_type, data.groups)

    def curves(self) -> Boundary:
        """The four sides, that with the fine part in two or three pieces."""
        x0, y0 = self.corner
        if self.side == "top":
            return (tuple(mapped(self._edges(), (1.0, 1.0), (x0, y0))),)
        return (tuple(mapped(self._edges(), (1.0, -1.0), (x0, y0 + self.height))),)

    def _largest(self) -> float:
        """Largest cell size [m]."""
        usual = max(self.width, self.height) / 8
        return max(self.size, self.coarse if self.coarse is not None else usual)

    def _edges(self) -> list[Edge]:
        """Sides of the block with its corner at the origin and the fine part on top."""
        w, h = self.width, self.height
        a, b = self._zone()
        other = "bottom" if self.side == "top" else "top"
        edges = [
            Edge((0.0, 0.0), (w, 0.0), (other,)),
            Edge((w, 0.0), (w, h), ("right",)),
            Edge((w, h), (b, h), (self.side,)),
            Edge((b, h), (a, h), (self.side, "contact"), fine=True),
            Edge((a, h), (0.0, h), (self.side,)),
            Edge((0.0, h), (0.0, 0.0), ("left",)),
        ]
        return [edge for edge in edges if edge.start != edge.end]

    def outline(self) -> dict[str, Floats]:
        """The four sides and the fine part."""
        x0, y0 = self.corner
        sides = rectangle(x0, y0, x0 + self.width, y0 + self.height)
        fine = sides[self.side].copy()
        a, b = self._zone()
        fine[:, 0] = (x0 + a, x0 + b) if self.side == "bottom" else (x0 + b, x0 + a)
        return sides | {"contact": fine}

    def _zone(self) -> tuple[float, float]:
        """Ends of the fine part, from the left side; those of the whole side if all but there."""
        a, b = (x - self.corner[0] for x in self.zone)
        slack = 1e-9 * self.width
        return 0.0 if a < slack else a, self.width if b > self.width - slack else b
