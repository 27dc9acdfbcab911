"""A plane mesh revolved about the y axis."""

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from contactfem.common.typing import Floats
from contactfem.meshes.builder import Builder, Count, more
from contactfem.meshes.data import CellName, MeshData
from contactfem.meshes.plane_spec import PlaneSpec
from contactfem.meshes.swept import swept

ON_AXIS = 1e-9  # distance from the axis, relative to the largest
FULL = 360.0
Degrees = Annotated[float, Field(gt=0.0, le=FULL, description="in degrees", examples=[90.0])]


class Revolution(Builder):
    """Plane body revolved about the y axis by `angle` degrees, in `layers` layers of cells.

    `plane` is the table of a plane builder in x >= 0, x the distance from the axis. A body that
    touches the axis consists of tetrahedra; others of hexahedra where the plane body has
    quadrilaterals. Groups: those of the plane body but for the axis, and, of less than a full turn,
    start (z = 0) and end.
    """

    builder: Literal["revolution"] = Field(
        default="revolution", description="plane body revolved about the y axis"
    )
    plane: PlaneSpec = Field(description="geometry of the plane body in x >= 0, with its mesh")
    angle: Degrees = Field(default=FULL, description="angle of revolution in degrees")
    layers: Annotated[Count, Field(ge=2)] = Field(description="layers of cells around the axis")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        low, high = self.plane.extent()
        if low[0] < -ON_AXIS * (high[0] - low[0]):
            raise ValueError(f"plane: reaches to x = {low[0]:g} m; x is the distance from the axis")
        if self.angle == FULL and self.layers < 3:
            raise ValueError("layers: a full turn needs at least 3")
        if taken := {"start", "end"} & self.plane.outline().keys():
            raise ValueError(f"plane: has groups {', '.join(sorted(taken))} of its own")
        return self

    def cell_type(self) -> CellName:
        """Hexahedra where the plane body has quadrilaterals and is away from the axis."""
        low, high = self.plane.extent()
        away = low[0] > ON_AXIS * high[0]
        whole = self.plane.cell_type() == "quadrilateral" and away
        return "hexahedron" if whole else "tetrahedron"

    def refinement(self, factor: float) -> dict[str, Any]:
        """The plane body's keys, and the number of layers."""
        plane = {f"plane.{key}": value for key, value in self.plane.refinement(factor).items()}
        return plane | {"layers": more(self.layers, factor)}

    def refined(self, factor: float) -> Self:
        """The plane body refined, and more layers.

        Args:
            factor: how many times smaller the cells are; counts are rounded.
        """
        given = {name: getattr(self, name) for name in self.model_fields_set}
        finer = {"plane": self.plane.refined(factor), "layers": more(self.layers, factor)}
        return self.model_validate(given | finer)

    def cell_count(self) -> float:
        """Plane cells times layers, and tetrahedra three times."""
        share = 1.0 if self.cell_type() == "hexahedron" else 3.0
        return share * self.plane.cell_count() * self.layers

    def build(self) -> MeshData:
        """Cells of the plane mesh, layer by layer."""
        plane = self.plane.build()
        x, y = plane.points.T
        axis, n = x <= ON_AXIS * x.max(), len(x)
        angle = np.deg2rad(self.angle) * np.arange(self.layers + 1) / self.layers
        r = np.where(axis, 0.0, x)
        layers = np.stack(
            (
                np.cos(angle)[:, None] * r,
                np.broadcast_to(y, (len(angle), n)),
                np.sin(angle)[:, None] * r,
            ),
            axis=2,
        )
        node = np.arange(len(angle) * n, dtype=np.int64).reshape(-1, n)
        if self.angle == FULL:
            node[-1] = node[0]
        node[:, axis] = node[0, axis]
        number, node = np.unique(node, return_inverse=True)
        node = node.reshape(len(angle), n)
        first = np.unique(node, return_index=True)[1]
        layers = layers.reshape(-1, 3)[first][node.ravel()].reshape(layers.shape)
        ends = None if self.angle == FULL else ("start", "end")
        assert len(number) == node.max() + 1
        return swept(plane, layers, node, self.cell_type(), ends)

    def outline(self) -> dict[str, Floats]:
        """The plane lines at every few degrees; those on the axis are left out."""
        steps = np.deg2rad(np.linspace(0.0, self.angle, 1 + max(4, int(self.angle // 10))))
        lines = {
            name: line for name, line in self.plane.outline().items() if line[:, 0].max() > ON_AXIS
        }
        turned = {
            name: np.concatenate([_turned(line, angle) for angle in steps])
            for name, line in lines.items()
        }
        if self.angle == FULL:
            return turned
        whole = np.concatenate(list(lines.values()))
        return turned | {"start": _turned(whole, steps[0]), "end": _turned(whole, steps[-1])}


def _turned(line: Floats, angle: float) -> Floats:
    return np.column_stack((np.cos(angle) * line[:, 0], line[:, 1], np.sin(angle) * line[:, 0]))
