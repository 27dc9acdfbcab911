"""Cross section of a tire's carcass that stands on its tread."""

from dataclasses import dataclass, replace
from math import hypot, sqrt
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from contactfem.common.typing import Floats
from contactfem.common.units import Length
from contactfem.meshes.builder import Builder, PositiveLength, smaller
from contactfem.meshes.curves import Boundary, Edge, equal_parts, mapped, outlined
from contactfem.meshes.data import MeshData, mesh_data
from contactfem.meshes.polygon import doubled, triangulate

Size = Annotated[float, Field(gt=0)]


THIN = 0.5  # smallest distance of the two surfaces over the smallest thickness given


@dataclass(frozen=True)
class _Surface:
    """Right half of the outer or inner surface: arcs of tread, shoulder and sidewall.

    The tread starts at (0, `bottom`) with a `curvature` [1/m] and reaches to x = `tread`; `width`
    and `rim` are the largest x of the sidewall and that at its end, on the `height` [m].
    """

    curvature: float
    bottom: float
    tread: float
    shoulder: float
    width: float
    rim: float
    height: float

    def edges(self) -> list[Edge]:
        """The three arcs from the middle of the tread to the rim; all but the sidewall are fine.

        The sidewall's circle, of radius R about (width - R, y), touches that of the shoulder, of
        radius r about c, from outside and passes through the rim's point. With a = width - rim,
        b = width - c_x and e = b - r both say what R is,
        2 a R = a² + (y - height)² and 2 e R = b² - r² + (y - c_y)².

        Raises:
            ValueError: there is no such circle whose widest place lies between shoulder and rim.
        """
        r, k, x = self.shoulder, self.curvature, self.tread
        slope = sqrt(1.0 - (k * x) ** 2)
        low = (x, self.bottom + k * x**2 / (1.0 + slope))
        cx, cy = low[0] - r * k * x, low[1] + r * slope
        a, b = self.width - self.rim, self.width - cx
        e = b - r
        quadratic = [
            e - a,
            2.0 * (a * cy - e * self.height),
            e * (a**2 + self.height**2) - a * (b**2 - r**2 + cy**2),
        ]
        roots = [float(y.real) for y in np.roots(quadratic) if cy < y.real < self.height]
        if len(roots) != 1 or not np.polyval(quadratic, cy) > 0.0:
            raise ValueError("height: leaves no room for round sidewalls between shoulders and rim")
        radius = (a**2 + (roots[0] - self.height) ** 2) / (2.0 * a)
        wall = (self.width - radius, roots[0])
        away = hypot(cx - wall[0], cy - wall[1])
        high = (cx + r * (cx - wall[0]) / away, cy + r * (cy - wall[1]) / away)
        middle = (0.0, self.bottom + 1.0 / k) if k > 0.0 else None
        return [
            Edge((0.0, self.bottom), low, ("tread",), middle, fine=True),
            Edge(low, high, ("tread",), (cx, cy), fine=True),
            Edge(high, (self.rim, self.height), ("right_sidewall",), wall),
        ]


class Tire(Builder):
    """Carcass, symmetric about a vertical line, open above between its two rim flanges.

    The tread is an arc that rises by `crown` from its middle, the `point`, to its ends, which are
    `tread_width` apart; arcs of radius `shoulder` lead over to the sidewalls. A sidewall is an arc
    that is widest, `width` apart from the other, where its tangent is vertical, and ends on the rim
    at the `height`; the outer ends of the two flanges are `rim_width` apart. The inner surface is
    built alike, `tread_thickness` above the point, `wall_thickness` inside the widest place and
    `flange_thickness` from the outer end of the flange, with arcs of radius `inner_shoulder`.

    Cells have the size `tread_size` on the tread and its shoulders, from there they grow by
    `growth` per distance up to `size`.
    Groups: tread (with shoulders: all that may touch), left_sidewall, right_sidewall, inner,
    left_flange, right_flange.
    """

    builder: Literal["tire"] = Field(default="tire", description="cross-section of a tire")
    width: PositiveLength = Field(
        default=0.2, description="distance of the sidewalls at the widest place"
    )
    height: PositiveLength = Field(default=0.15, description="height of the rim above the point")
    point: tuple[Length, Length] = Field(default=(0.0, 0.0), description="middle of the tread")
    tread_width: PositiveLength = Field(
        default=0.14, description="distance of the ends of the tread"
    )
    crown: Annotated[Length, Field(ge=0)] = Field(
        default=0.002, description="how far the tread rises from its middle to its ends"
    )
    shoulder: PositiveLength = Field(
        default=0.025, description="radius from the tread to the sidewall"
    )
    inner_shoulder: PositiveLength = Field(default=0.02, description="the same radius inside")
    rim_width: PositiveLength = Field(
        default=0.15, description="distance of the outer ends of the flanges"
    )
    tread_thickness: PositiveLength = Field(
        default=0.02, description="thickness at the middle of the tread"
    )
    wall_thickness: PositiveLength = Field(
        default=0.012, description="thickness at the widest place"
    )
    flange_thickness: PositiveLength = Field(default=0.018, description="thickness at the flange")
    size: PositiveLength = Field(default=0.006, description="largest cell size")
    tread_size: PositiveLength = Field(
        default=0.003, description="cell size on the tread and its shoulders"
    )
    growth: Annotated[float, Field(gt=0, le=1)] = Field(
        default=0.2, description="growth of the cell size per distance"
    )

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.rim_width >= self.width:
            raise ValueError("rim_width: must be smaller than the width")
        if self.tread_width + 2.0 * self.shoulder >= self.width:
            raise ValueError("tread_width: with both shoulders it must be smaller than the width")
        if self.crown >= 0.5 * self.tread_width:
            raise ValueError("crown: must be smaller than half the tread_width")
        if self.tread_size > self.size:
            raise ValueError("tread_size: must not be larger than the size")
        inner = self._inner()
        if inner.rim <= 0.0:
            raise ValueError("flange_thickness: must be smaller than half the rim_width")
        if inner.width <= inner.rim:
            raise ValueError("wall_thickness: the inner surface must be wider than at the rim")
        if inner.tread <= 0.0:
            raise ValueError("inner_shoulder: leaves no width for the inner side of the tread")
        if inner.curvature * inner.tread >= 1.0:
            raise ValueError("crown: must be smaller for this tread_thickness")
        distance = _distance(self._outer().edges(), inner.edges())
        least = min(self.tread_thickness, self.wall_thickness, self.flange_thickness)
        if distance < THIN * least:
            raise ValueError(
                f"wall_thickness: the inner surface comes as close as {distance:.3g} m to the outer"
            )
        return self

    def refinement(self, factor: float) -> dict[str, Any]:
        """Sizes and their growth."""
        return smaller(factor, self.growth, size=self.size, tread_size=self.tread_size)

    def cell_count(self) -> float:
        """Of a half: so many triangles on its tread, and on the rest as on a strip of that."""
        thick = max(self.tread_thickness, self.wall_thickness, self.flange_thickness)
        tread, half = 0.5 * self.tread_width + self.shoulder, 0.5 * self.width + self.height
        return 2.3 * thick * (tread / self.tread_size**2 + half / self.size**2)

    def build(self) -> MeshData:
        """Triangles, a half and its mirror image."""
        half = self._half()
        edges = [*half, Edge(half[-1].end, half[0].start, ("axis",))]
        data = doubled(triangulate(edges, self.tread_size, self.growth, self.size), "axis")
        groups = {}
        for name, facets in data.groups.items():
            if name.startswith("right_"):
                on_right = data.points[facets, 0].mean(axis=1) > 0.0
                groups[name] = facets[on_right]
                groups[_left(name)] = facets[~on_right]
            else:
                groups[name] = facets
        return mesh_data(data.points + np.array(self.point), data.cells, data.cell_type, groups)

    def outline(self) -> dict[str, Floats]:
        """Arcs by chords of about a degree, flanges by their ends."""
        return outlined(self.curves())

    def curves(self) -> Boundary:
        """Arcs and flanges, from the left end of the tread."""
        half = self._half()
        left = [
            replace(edge, groups=tuple(_left(name) for name in edge.groups))
            for edge in mapped(half, (-1.0, 1.0), (0.0, 0.0))
        ]
        return (tuple(mapped([*left[-2:], *half, *left[:-2]], (1.0, 1.0), self.point)),)

    def _half(self) -> list[Edge]:
        """Right half of the boundary about the point, from the tread to the inner surface."""
        outer, inner = self._outer().edges(), self._inner().edges()
        inside = [
            replace(edge, start=edge.end, end=edge.start, groups=("inner",), fine=False)
            for edge in reversed(inner)
        ]
        return [*outer, Edge(outer[-1].end, inside[0].start, ("right_flange",)), *inside]

    def _outer(self) -> _Surface:
        """The outer surface about the point."""
        half = 0.5 * self.tread_width
        return _Surface(
            curvature=2.0 * self.crown / (half**2 + self.crown**2),
            bottom=0.0,
            tread=half,
            shoulder=self.shoulder,
            width=0.5 * self.width,
            rim=0.5 * self.rim_width,
            height=self.height,
        )

    def _inner(self) -> _Surface:
        """The inner surface; its shoulder is as far inside the widest place as the outer one."""
        outer = self._outer()
        return _Surface(
            curvature=outer.curvature / (1.0 - outer.curvature * self.tread_thickness),
            bottom=self.tread_thickness,
            tread=outer.tread + self.shoulder - self.wall_thickness - self.inner_shoulder,
            shoulder=self.inner_shoulder,
            width=outer.width - self.wall_thickness,
            rim=outer.rim - self.flange_thickness,
            height=self.height,
        )


def _left(name: str) -> str:
    """The group of the mirror image."""
    return name.replace("right_", "left_")


def _distance(outer: list[Edge], inner: list[Edge]) -> float:
    """Smallest distance [m] of two surfaces, by samples of them."""
    t = equal_parts(64)
    a, b = (np.concatenate([edge.at(t) for edge in edges]) for edges in (outer, inner))
    return float(np.min(np.linalg.norm(a[:, None] - b, axis=2)))
