"""Half or quarter of a cylinder's cross section, fine where it touches."""

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from contactfem.common.typing import Floats
from contactfem.common.units import Length
from contactfem.meshes.builder import Builder, PositiveLength, graded_count, smaller
from contactfem.meshes.curves import Boundary, Edge, mapped
from contactfem.meshes.data import MeshData, mesh_data
from contactfem.meshes.fan import fan
from contactfem.meshes.grid import Cell2D
from contactfem.meshes.polygon import doubled, triangulate


class Cylinder(Builder):
    """Half disk, flat on the far side, or its half x >= x_point with a line of symmetry.

    The arc passes through `point`; the body lies above it (`side` = "upper") or below it. Facets on
    the arc have at most the length `size` within `zone` to the left and right of the point; from
    there cells grow by `growth` per distance up to `coarse`. Quadrilaterals form an array.
    Groups: contact (the fine part of the arc), arc (all of it), flat, and of a quarter axis.
    """

    builder: Literal["cylinder"] = Field(default="cylinder", description="half disk")
    radius: PositiveLength = Field(description="radius of the arc")
    point: tuple[Length, Length] = Field(
        default=(0.0, 0.0), description="point of the arc that touches"
    )
    side: Literal["upper", "lower"] = Field(
        default="upper", description="whether the body lies above or below the point"
    )
    part: Literal["half", "quarter"] = Field(
        default="half", description="half disk, or the quarter at x ≥ x of the point"
    )
    zone: PositiveLength = Field(
        description="distance to the left and right of the point where facets are fine"
    )
    size: PositiveLength = Field(description="largest facet within the zone")
    growth: Annotated[float, Field(gt=0, le=1)] = Field(
        default=0.1, description="growth of the cell size per distance from the zone"
    )
    coarse: PositiveLength | None = Field(default=None, description="largest cell size")
    cell: Cell2D = Field(default="triangle", description="kind of cells")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.zone >= self.radius:
            raise ValueError("zone: must be smaller than the radius")
        if not self.size <= self.zone:
            raise ValueError("size: must not be larger than the zone")
        return self

    def refinement(self, factor: float) -> dict[str, Any]:
        """Sizes and their growth."""
        return smaller(factor, self.growth, size=self.size, coarse=self._largest())

    def cell_count(self) -> float:
        """Of a quarter, as sizes grow from its fine part."""
        r = self.radius
        coarse = max(self.size, self._largest())
        return graded_count(min(self.zone, r), self.size, self.growth, coarse, r)

    def build(self) -> MeshData:
        """A quarter, or with its mirror image a half."""
        r = self.radius
        coarse = self._largest()
        if self.cell == "quadrilateral":
            data = fan(r, self.zone, self.size, self.growth, coarse)
        else:
            data = self._triangles(coarse)
        if self.part == "half":
            data = doubled(data, "axis")
        return mesh_data(self._placed(data.points), data.cells, data.cell_type, data.groups)

    def curves(self) -> Boundary:
        """The arc in pieces that meet at the point and at the ends of the fine part, and lines."""
        r, edges = self.radius, self._quarter()
        if self.part == "half":
            arc = edges[:2]
            flat = Edge((r, r), (-r, r), ("flat",))
            edges = [*mapped(arc, (-1.0, 1.0), (0.0, 0.0)), *arc, flat]
        up = 1.0 if self.side == "upper" else -1.0
        return (tuple(mapped(edges, (1.0, up), self.point)),)

    def _largest(self) -> float:
        """Largest cell size [m]."""
        return max(self.size, self.coarse if self.coarse is not None else self.radius / 8)

    def _triangles(self, coarse: float) -> MeshData:
        """Quarter in the frame with the contact point at the origin."""
        return triangulate(self._quarter(), self.size, self.growth, coarse)

    def _quarter(self) -> list[Edge]:
        """Boundary of the quarter in that frame, from the contact point."""
        r = self.radius
        end = (self.zone, r - float(np.sqrt(r**2 - self.zone**2)))
        return [
            Edge((0.0, 0.0), end, ("contact", "arc"), (0.0, r), fine=True),
            Edge(end, (r, r), ("arc",), (0.0, r)),
            Edge((r, r), (0.0, r), ("flat",)),
            Edge((0.0, r), (0.0, 0.0), ("axis",)),
        ]

    def outline(self) -> dict[str, Floats]:
        """The arc by chords of about a degree, the straight sides by their ends."""
        r, zone = self.radius, float(np.arcsin(self.zone / self.radius))
        half = self.part == "half"
        lines = {
            "contact": self._arc(-zone if half else 0.0, zone),
            "arc": self._arc(-np.pi / 2 if half else 0.0, np.pi / 2),
            "flat": np.array([[r, r], [-r if half else 0.0, r]]),
        }
        if not half:
            lines["axis"] = np.array([[0.0, r], [0.0, 0.0]])
        turn = 1 if self.side == "upper" else -1
        return {name: self._placed(line)[::turn] for name, line in lines.items()}

    def _arc(self, start: float, end: float) -> Floats:
        """Points of the arc between two angles from the contact point."""
        angle = np.linspace(start, end, 1 + int(np.ceil((end - start) / np.deg2rad(1))))
        points: Floats = self.radius * np.stack([np.sin(angle), 1 - np.cos(angle)], axis=1)
        return points

    def _placed(self, points: Floats) -> Floats:
        """From the frame with the contact point at the origin and the body above it."""
        up = 1.0 if self.side == "upper" else -1.0
        placed: Floats = points * [1.0, up] + np.array(self.point)
        return placed
