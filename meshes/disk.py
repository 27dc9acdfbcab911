"""Disk and ring with a round boundary."""

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from contactfem.common.typing import Floats, Ints
from contactfem.common.units import Length
from contactfem.meshes.builder import Builder, Count, PositiveLength, more
from contactfem.meshes.curves import Boundary, Edge, FairCircle
from contactfem.meshes.data import MeshData, mesh_data

CORE = 0.5  # half the diagonal of a disk's square core over the radius
BULGE = 0.5  # how far the sides of the core are bent towards a circle: 0 straight, 1 a circle


class Disk(Builder):
    """Disk: a core of n x n cells, n = facets/4, in `layers` layers of cells.

    The polygon of `facets` equal facets has the area of the circle, so that its mean radius is
    right; the first node lies on the x axis. Groups: rim.
    """

    builder: Literal["disk"] = Field(default="disk", description="disk")
    radius: PositiveLength = Field(description="mean radius")
    center: tuple[Length, Length] = Field(default=(0.0, 0.0), description="centre")
    facets: Annotated[int, Field(strict=True, ge=8, le=100_000, multiple_of=8)] = Field(
        description="facets along the circle"
    )
    layers: Count = Field(description="layers of cells around the core")

    def refinement(self, factor: float) -> dict[str, Any]:
        """Numbers of facets and layers."""
        return {"facets": more(self.facets, factor, 8), "layers": more(self.layers, factor)}

    def cell_count(self) -> float:
        """Quadrilaterals of the core and the layers."""
        return float((self.facets // 4) ** 2 + self.facets * self.layers)

    def build(self) -> MeshData:
        """Quadrilaterals; the centre is a node, and four nodes of the rim lie on the axes."""
        n = self.facets // 4
        core = _core(n) * CORE * self.radius
        inner = _around(np.arange((n + 1) ** 2, dtype=np.int64).reshape(n + 1, n + 1))
        rim = polygon(fair_radius(self.radius, self.facets), self.facets)
        shells = np.arange(1, self.layers + 1)[:, None, None] / self.layers
        layers = (1.0 - shells) * core[inner] + shells * rim
        number = len(core) + np.arange(self.layers * self.facets, dtype=np.int64)
        circles = np.concatenate([inner[None], number.reshape(self.layers, self.facets)])
        grid = np.arange((n + 1) ** 2, dtype=np.int64).reshape(n + 1, n + 1)
        square = np.stack([grid[:-1, :-1], grid[:-1, 1:], grid[1:, :-1], grid[1:, 1:]], axis=-1)
        return mesh_data(
            np.array(self.center) + np.concatenate([core, layers.reshape(-1, 2)]),
            np.concatenate([square.reshape(-1, 4), _cells(circles)]),
            "quadrilateral",
            {"rim": _closed(circles[-1])},
        )

    def outline(self) -> dict[str, Floats]:
        """The polygon."""
        rim = polygon(fair_radius(self.radius, self.facets), self.facets)
        return {"rim": _loop(rim) + self.center}

    def curves(self) -> Boundary:
        """The circle; polygons of nodes on it have its area, as the polygon of the facets has."""
        return ((FairCircle(self.center, self.radius, ("rim",)),),)


class Ring(Builder):
    """Ring between two circles of `facets` facets, with `layers` layers of cells.

    The inner polygon has the area of its circle, the outer one has its corners on it; the first
    node of each lies on the x axis. Groups: inner, outer.
    """

    builder: Literal["ring"] = Field(default="ring", description="ring")
    inner_radius: PositiveLength = Field(description="radius of the hole")
    outer_radius: PositiveLength = Field(description="outer radius")
    center: tuple[Length, Length] = Field(default=(0.0, 0.0), description="centre")
    facets: Annotated[int, Field(strict=True, ge=8, le=100_000, multiple_of=4)] = Field(
        description="facets along each circle"
    )
    layers: Count = Field(description="layers of cells")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.outer_radius <= self.inner_radius:
            raise ValueError("outer_radius: must be larger than inner_radius")
        return self

    def refinement(self, factor: float) -> dict[str, Any]:
        """Numbers of facets and layers."""
        return {"facets": more(self.facets, factor, 4), "layers": more(self.layers, factor)}

    def cell_count(self) -> float:
        """Quadrilaterals of the layers."""
        return float(self.facets * self.layers)

    def build(self) -> MeshData:
        """Quadrilaterals in polar order; four nodes of each circle lie on the axes."""
        inner = fair_radius(self.inner_radius, self.facets)
        radii = np.linspace(inner, self.outer_radius, self.layers + 1)
        points = np.concatenate([polygon(r, self.facets) for r in radii])
        circles = np.arange(len(points), dtype=np.int64).reshape(-1, self.facets)
        groups = {"inner": _closed(circles[0]), "outer": _closed(circles[-1])}
        return mesh_data(points + self.center, _cells(circles), "quadrilateral", groups)

    def outline(self) -> dict[str, Floats]:
        """Both polygons; the inner one clockwise, with the body on its left."""
        fair = fair_radius(self.inner_radius, self.facets)
        inner = _loop(polygon(fair, self.facets))[::-1]
        outer = _loop(polygon(self.outer_radius, self.facets))
        return {"inner": inner + self.center, "outer": outer + self.center}

    def curves(self) -> Boundary:
        """The outer circle in four arcs; polygons of nodes on the inner one have its area."""
        x, y = self.center
        r = self.outer_radius
        axes = [(x + r, y), (x, y + r), (x - r, y), (x, y - r)]
        outer = tuple(
            Edge(start, end, ("outer",), centre=self.center)
            for start, end in zip(axes, axes[1:] + axes[:1], strict=True)
        )
        return outer, (FairCircle(self.center, self.inner_radius, ("inner",), turn=-1),)


def fair_radius(radius: float, facets: int) -> float:
    """Corner radius [m] of the regular polygon with the circle's area, R sqrt(2 φ / sin 2φ).

    φ = π / facets; in the mean over its facets such a polygon is as far out as the circle.
    """
    phi = np.pi / facets
    return radius * float(np.sqrt(2.0 * phi / np.sin(2.0 * phi)))


def polygon(radius: float, facets: int) -> Floats:
    """Corners (facets, 2) [m] of a regular polygon, the first on the x axis."""
    turn = 2.0 * np.pi * np.arange(facets) / facets
    corners: Floats = radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    quarter = facets // 4
    corners[[0, 2 * quarter], 1] = 0.0  # on the axes to the last digit
    corners[[quarter, 3 * quarter], 0] = 0.0
    return corners


def _core(n: int) -> Floats:
    """Points ((n + 1)², 2) of a square with corners on the unit circle, its sides bent outward."""
    line = np.linspace(-1.0, 1.0, n + 1)
    x, y = np.meshgrid(np.tan(np.pi / 4 * line), np.tan(np.pi / 4 * line))
    size = np.maximum(np.abs(x), np.abs(y))
    on_square = np.stack([x, y], axis=-1) * np.sqrt(0.5)
    length = np.hypot(x, y)
    unit = np.divide(1.0, length, out=np.ones_like(length), where=length > 0.0)
    on_circle = np.stack([x, y], axis=-1) * (size * unit)[..., None]
    # bent in proportion to the distance from the centre, where a circle would be singular
    bend = BULGE * size[..., None]
    points: Floats = ((1.0 - bend) * on_square + bend * on_circle).reshape(-1, 2)
    return points


def _around(grid: Ints) -> Ints:
    """Numbers on the boundary of an array, counter-clockwise from the middle of its right side."""
    n = len(grid) - 1
    walk = np.concatenate([grid[:-1, n], grid[n, :0:-1], grid[:0:-1, 0], grid[0, :-1]])
    return np.roll(walk, -(n // 2))


def _closed(nodes: Ints) -> Ints:
    """Facets (k, 2) of a closed chain of nodes (k,)."""
    return np.stack([nodes, np.roll(nodes, -1)], axis=1)


def _loop(points: Floats) -> Floats:
    """Closed polyline (k + 1, 2) of points (k, 2)."""
    return np.concatenate([points, points[:1]])


def _cells(circles: Ints) -> Ints:
    """Quadrilaterals between circles of nodes (layers + 1, k)."""
    ends = np.roll(circles, -1, axis=1)
    cells: Ints = np.stack([circles[:-1], ends[:-1], circles[1:], ends[1:]], axis=-1)
    return cells.reshape(-1, 4)
