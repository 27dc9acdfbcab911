"""Box that is fine at a zone of its top or bottom."""

from itertools import pairwise
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from contactfem.common.typing import Floats, Ints
from contactfem.common.units import Length
from contactfem.meshes.box import SIDES, TETRAHEDRA
from contactfem.meshes.builder import Builder, PositiveLength, smaller
from contactfem.meshes.data import CellName, MeshData, boundary_facets, mesh_data

ALL = 1e-9  # part of a length by which a zone may miss the end of a side


class GradedBox(Builder):
    """Box of cells of the length `size` in the part `zone_x` by `zone_z` of its top or bottom.

    `corner` is the lowest one in x, y and z. From the zone cells grow by `growth` per distance up
    to `coarse`. The side with the zone may be round: `radius_x` and `radius_z` are its radii of
    curvature at the middle of the zone (a sphere's where both are the same, a cylinder's where one
    is not given), and the body bulges there: `height` is that at the middle.
    Groups: left, right (x), bottom, top (y), back, front (z), and contact, the facets of the zone.
    """

    builder: Literal["graded_box"] = Field(
        default="graded_box", description="box that is fine on a part of its top or bottom"
    )
    width: PositiveLength = Field(description="size in x")
    height: PositiveLength = Field(description="size in y, at the middle of the zone")
    depth: PositiveLength = Field(description="size in z")
    corner: tuple[Length, Length, Length] = Field(
        default=(0.0, 0.0, 0.0), description="corner with the smallest coordinates"
    )
    side: Literal["top", "bottom"] = Field(default="top", description="side with the fine part")
    zone_x: tuple[Length, Length] = Field(description="smallest and largest x of the fine part")
    zone_z: tuple[Length, Length] = Field(description="smallest and largest z of the fine part")
    size: PositiveLength = Field(description="length of the cells in the zone")
    growth: Annotated[float, Field(gt=0, le=1)] = Field(
        default=0.3, description="growth of the cell size per distance from the zone"
    )
    coarse: PositiveLength | None = Field(default=None, description="largest cell size")
    radius_x: PositiveLength | None = Field(
        default=None,
        description="radius of curvature of the side in the x direction; flat if not given",
    )
    radius_z: PositiveLength | None = Field(
        default=None,
        description="radius of curvature of the side in the z direction; flat if not given",
    )
    cell: Literal["hexahedron", "tetrahedron"] = Field(
        default="hexahedron", description="kind of cells"
    )

    @model_validator(mode="after")
    def _fits(self) -> Self:
        for name, axis, length in (("zone_x", 0, self.width), ("zone_z", 2, self.depth)):
            zone, low = getattr(self, name), self.corner[axis]
            slack = ALL * length
            if not low - slack <= zone[0] < zone[1] <= low + length + slack:
                raise ValueError(f"{name}: must be a part of the side, {low} m to {low + length} m")
        if self.drop(np.array(self.corner)[None], far=True).max() >= self.height:
            raise ValueError("radius_x, radius_z: the round side cuts through the far side")
        return self

    def cell_type(self) -> CellName:
        """Kind of the cells."""
        return self.cell

    def refinement(self, factor: float) -> dict[str, Any]:
        """Sizes and their growth."""
        return smaller(factor, self.growth, size=self.size, coarse=self._largest())

    def cell_count(self) -> float:
        """Hexahedra of the array, or tetrahedra of these."""
        count = np.prod([len(line) - 1.0 for line in self.lines()])
        return float(count) * (1.0 if self.cell == "hexahedron" else 6.0)

    def lines(self) -> tuple[Floats, Floats, Floats]:
        """Coordinates of the lines of the array in x, y (from the fine side), and z [m]."""
        x, _, z = self.corner
        coarse = self._largest()
        return (
            graded_line(x, x + self.width, self.zone_x, self.size, self.growth, coarse),
            graded_line(0.0, self.height, (0.0, 0.0), self.size, self.growth, coarse),
            graded_line(z, z + self.depth, self.zone_z, self.size, self.growth, coarse),
        )

    def drop(self, points: Floats, *, far: bool = False) -> Floats:
        """How far the round side lies behind its highest point, (k,) [m].

        A sphere where both radii are the same, else x²/2R_x + z²/2R_z to second order.

        Args:
            points: Points (k, 3) [m].
            far: At the farthest corner of the box instead.
        """
        result = np.zeros(len(points))
        middle = [0.5 * sum(self.zone_x), 0.5 * sum(self.zone_z)]
        lengths = (self.width, self.depth)
        away = points[:, [0, 2]] - middle
        if far:
            low = np.array([self.corner[0], self.corner[2]]) - middle
            away = np.broadcast_to(np.maximum(np.abs(low), np.abs(low + lengths)), away.shape)
        radii = (self.radius_x, self.radius_z)
        if radii[0] is not None and radii[0] == radii[1]:
            square = np.minimum((away**2).sum(axis=1), radii[0] ** 2)
            return np.asarray(radii[0] - np.sqrt(radii[0] ** 2 - square))
        for k, radius in enumerate(radii):
            if radius is not None:
                square = np.minimum(away[:, k] ** 2, radius**2)
                result = result + radius - np.sqrt(radius**2 - square)
        return result

    def build(self) -> MeshData:
        """Array of hexahedra, or of these split into tetrahedra, with a round side."""
        x, y, z = self.lines()
        index = np.arange(len(x) * len(y) * len(z), dtype=np.int64)
        index = index.reshape(len(z), len(y), len(x))
        grid = np.stack(np.meshgrid(z, y, x, indexing="ij"), axis=-1)[..., ::-1]
        points = self._placed(grid.reshape(-1, 3))
        n = (len(z) - 1, len(y) - 1, len(x) - 1)
        corners = [
            index[k : k + n[0], j : j + n[1], i : i + n[2]].ravel()
            for k in (0, 1)
            for j in (0, 1)
            for i in (0, 1)
        ]
        cells = np.stack(corners, axis=1)
        if self.cell == "tetrahedron":
            cells = cells[:, TETRAHEDRA].reshape(-1, 4)
        return mesh_data(points, cells, self.cell, self._groups(grid.reshape(-1, 3), cells))

    def _groups(self, grid: Floats, cells: Ints) -> dict[str, Ints]:
        """Sides by the lines of the array."""
        facets = boundary_facets(cells, self.cell)
        on = grid[facets]
        lines = self.lines()
        groups = {}
        for name, (axis, end) in SIDES.items():
            end = end if axis != 1 or self.side == "bottom" else 1 - end
            groups[name] = facets[np.all(on[..., axis] == lines[axis][-end], axis=1)]
        inside = np.ones(len(facets), bool)
        for axis, zone in ((0, self.zone_x), (2, self.zone_z)):
            slack = ALL * (lines[axis][-1] - lines[axis][0])
            within = (on[..., axis] >= zone[0] - slack) & (on[..., axis] <= zone[1] + slack)
            inside &= within.all(axis=1)
        fine = np.all(on[..., 1] == lines[1][0], axis=1)
        return groups | {"contact": facets[fine & inside]}

    def outline(self) -> dict[str, Floats]:
        """Points of every side, 9 by 9."""
        x, _, z = self.corner
        low, size = np.array((x, 0.0, z)), np.array((self.width, self.height, self.depth))
        part = np.linspace(0.0, 1.0, 9)
        lines = {}
        for name, (axis, end) in SIDES.items():
            end = end if axis != 1 or self.side == "bottom" else 1 - end
            ranges = [part, part, part]
            ranges[axis] = np.array([float(end)])
            lines[name] = low + size * np.stack(np.meshgrid(*ranges), axis=-1).reshape(-1, 3)
        zone = np.linspace(*self.zone_x, 9), np.zeros(1), np.linspace(*self.zone_z, 9)
        lines["contact"] = np.stack(np.meshgrid(*zone), axis=-1).reshape(-1, 3)
        return {name: self._placed(points) for name, points in lines.items()}

    def _placed(self, points: Floats) -> Floats:
        """Points of the body from those of the array, whose y counts from the fine side [m]."""
        placed = points.copy()
        share = 1.0 - points[:, 1] / self.height  # 1 on the fine side, 0 on the far one
        inward = points[:, 1] + share * self.drop(points)
        up = self.side == "bottom"
        placed[:, 1] = self.corner[1] + (inward if up else self.height - inward)
        return placed

    def _largest(self) -> float:
        """Largest cell size [m]."""
        usual = max(self.width, self.height, self.depth) / 6
        return max(self.size, self.coarse if self.coarse is not None else usual)


def graded_line(
    low: float, high: float, zone: tuple[float, float], size: float, growth: float, coarse: float
) -> Floats:
    """Points from `low` to `high`: even in the zone, with growing distances outside of it.

    Args:
        low: First point [m].
        high: Last point [m].
        zone: The even part [m].
        size: Largest distance in it [m].
        growth: Increase of the distance per distance from the zone [-].
        coarse: Largest distance [m].

    Returns:
        The points [m].
    """
    a, b = zone
    slack = ALL * (high - low)
    a, b = (low if a - low < slack else a), (high if high - b < slack else b)
    inner = np.linspace(a, b, 1 + int(np.ceil((b - a) / size - 1e-9))) if b > a else np.array([a])
    left = a - outward(a - low, size, growth, coarse)[::-1]
    right = b + outward(high - b, size, growth, coarse)
    return np.concatenate((left, inner, right))


def outward(length: float, size: float, growth: float, coarse: float) -> Floats:
    """Distances from a zone of the lines outside of it [m]; the last is `length`."""
    if length <= 0.0:
        return np.empty(0)
    steps: list[float] = []
    while sum(steps) < length:
        steps.append(min(coarse, size + growth * sum(steps)))
    if len(steps) > 1 and sum(steps) - length > 0.5 * steps[-1]:
        steps.pop()
    found = np.cumsum(steps) * (length / sum(steps))
    found[-1] = length
    assert all(b > a for a, b in pairwise(found))
    return found
