"""A die: a rectangle whose bottom is a circular arc."""

from typing import Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from contactfem.common.typing import Floats
from contactfem.common.units import Length
from contactfem.meshes.builder import Builder, Count, PositiveLength, more
from contactfem.meshes.curves import Boundary, Edge
from contactfem.meshes.data import MeshData, mesh_data
from contactfem.meshes.grid import grid


class Die(Builder):
    """Straight sides of length `straight` above an arc of the given radius, `width` across.

    `point` is the lowest one; the arc has `n_arc` facets of equal length, each side `n_side`.
    Groups: sole (the arc and both sides), top.
    """

    builder: Literal["die"] = Field(default="die", description="straight sides above an arc")
    width: PositiveLength = Field(description="width across")
    straight: PositiveLength = Field(description="length of the straight sides")
    radius: PositiveLength = Field(description="radius of the arc")
    point: tuple[Length, Length] = Field(default=(0.0, 0.0), description="lowest point of the arc")
    n_arc: Count = Field(description="facets along the arc")
    n_side: Count = Field(description="facets along each side")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.width >= 2.0 * self.radius:
            raise ValueError("width: must be smaller than the diameter of the arc")
        return self

    @property
    def sagitta(self) -> float:
        """Height of the arc, R - sqrt(R² - w²/4) [m]."""
        return self.radius - float(np.sqrt(self.radius**2 - 0.25 * self.width**2))

    def refinement(self, factor: float) -> dict[str, Any]:
        """Numbers of facets."""
        return {"n_arc": more(self.n_arc, factor), "n_side": more(self.n_side, factor)}

    def cell_count(self) -> float:
        """Quadrilaterals of the array."""
        return float(self.n_arc * self.n_side)

    def build(self) -> MeshData:
        """Quadrilaterals in columns above the facets of the arc."""
        bottom = self._arc(self.n_arc)
        x, y = self.point
        # evenly spread at the top, so that the columns are not thin at the corners of the arc
        top = np.full(self.n_arc + 1, y + self.sagitta + self.straight)
        ends = np.stack([x + self.width * np.linspace(-0.5, 0.5, self.n_arc + 1), top], axis=1)
        up = np.linspace(0.0, 1.0, self.n_side + 1)[:, None, None]
        data = grid((1.0 - up) * bottom + up * ends, "quadrilateral", "right")
        sides = data.groups
        sole = np.concatenate([sides["left"], sides["bottom"], sides["right"]])
        return mesh_data(
            data.points, data.cells, data.cell_type, {"sole": sole, "top": sides["top"]}
        )

    def outline(self) -> dict[str, Floats]:
        """The arc by chords of about a degree, the straight sides by their ends."""
        half = np.arcsin(0.5 * self.width / self.radius)
        arc = self._arc(int(np.ceil(np.rad2deg(2.0 * half))))
        up = [0.0, self.straight]
        sole = np.concatenate([arc[:1] + up, arc, arc[-1:] + up])
        return {"sole": sole, "top": sole[[-1, 0]]}

    def curves(self) -> Boundary:
        """The sides, the arc and the top."""
        x, y = self.point
        low, high = y + self.sagitta, y + self.sagitta + self.straight
        left, right = x - 0.5 * self.width, x + 0.5 * self.width
        return (
            (
                Edge((left, high), (left, low), ("sole",)),
                Edge((left, low), (right, low), ("sole",), centre=(x, y + self.radius)),
                Edge((right, low), (right, high), ("sole",)),
                Edge((right, high), (left, high), ("top",)),
            ),
        )

    def _arc(self, facets: int) -> Floats:
        """Nodes (facets + 1, 2) [m] of the arc from left to right."""
        half = np.arcsin(0.5 * self.width / self.radius)
        angle = np.linspace(-half, half, facets + 1)
        points: Floats = self.radius * np.stack([np.sin(angle), 1.0 - np.cos(angle)], axis=1)
        points += self.point
        return points
