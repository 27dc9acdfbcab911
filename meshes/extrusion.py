"""A plane mesh extruded in z."""

from typing import Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from contactfem.common.typing import Floats
from contactfem.common.units import Length
from contactfem.meshes.builder import Builder, Count, PositiveLength, more
from contactfem.meshes.data import CellName, MeshData
from contactfem.meshes.plane_spec import PlaneSpec
from contactfem.meshes.swept import swept


class Extrusion(Builder):
    """Plane body extruded from `z` to `z + depth` in `layers` layers of cells.

    `plane` is the table of a plane builder. Quadrilaterals become hexahedra, triangles prisms that
    are split into three tetrahedra each. Groups: those of the plane body, and back (smallest z) and
    front. Bodies of revolution about z are the extrusion of a disk or a ring.
    """

    builder: Literal["extrusion"] = Field(default="extrusion", description="extruded plane body")
    plane: PlaneSpec = Field(description="geometry of the plane body, with its mesh")
    depth: PositiveLength = Field(description="size in z")
    layers: Count = Field(description="layers of cells in z")
    z: Length = Field(default=0.0, description="smallest z")

    @model_validator(mode="after")
    def _names(self) -> Self:
        if taken := {"back", "front"} & self.plane.outline().keys():
            raise ValueError(f"plane: has groups {', '.join(sorted(taken))} of its own")
        return self

    def cell_type(self) -> CellName:
        """Hexahedra where the plane body has quadrilaterals."""
        return "hexahedron" if self.plane.cell_type() == "quadrilateral" else "tetrahedron"

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
        n, k = len(plane.points), self.layers
        z = self.z + self.depth * np.linspace(0.0, 1.0, k + 1)
        flat = np.broadcast_to(plane.points, (k + 1, n, 2))
        layers = np.concatenate((flat, np.broadcast_to(z[:, None, None], (k + 1, n, 1))), axis=2)
        node = np.arange((k + 1) * n, dtype=np.int64).reshape(k + 1, n)
        return swept(plane, layers, node, self.cell_type(), ("back", "front"))

    def outline(self) -> dict[str, Floats]:
        """Of every group the plane line at both ends; the ends by the lines of all groups."""
        low, high = self.z, self.z + self.depth
        lines = self.plane.outline()
        both = {
            name: np.concatenate([_at(line, low), _at(line[::-1], high)])
            for name, line in lines.items()
        }
        whole = np.concatenate(list(lines.values()))
        return both | {"back": _at(whole, low), "front": _at(whole, high)}


def _at(line: Floats, z: float) -> Floats:
    return np.column_stack((line, np.full(len(line), z)))
