"""Base of mesh builders: mesh, outline, adapted meshes."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Annotated, Any, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from contactfem.common.typing import Floats
from contactfem.common.units import Length
from contactfem.errors import MeshError
from contactfem.meshes.adapted_mesh import adapt
from contactfem.meshes.curves import Boundary
from contactfem.meshes.data import CellName, MeshData
from contactfem.meshes.layers import Layers
from contactfem.meshes.size_field import SizeField

PositiveLength = Annotated[Length, Field(gt=0)]
Count = Annotated[int, Field(strict=True, ge=1, le=100_000)]

MOST_CELLS = 5_000_000  # of a body: several times what can be solved for


class Builder(BaseModel, ABC):
    """A geometry with its mesh parameters, as a case file gives them."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    @abstractmethod
    def build(self) -> MeshData:
        """Mesh of the geometry, the same for the same parameters."""

    def cell_count(self) -> float:
        """About how many cells `build` makes, without meshing; 0 where only it can tell."""
        return 0.0

    @model_validator(mode="after")
    def _countable(self) -> Self:
        if (count := self.cell_count()) > MOST_CELLS:
            raise ValueError(f"asks for {count:.1e} cells; a body may have {MOST_CELLS:.0e}")
        return self

    @abstractmethod
    def outline(self) -> dict[str, Floats]:
        """Boundary polyline (k, 2) [m] of every group, the body on the left; without meshing."""

    def curves(self) -> Boundary:
        """Exact boundary, without meshing.

        Raises:
            MeshError: the body is solid.
        """
        raise MeshError("only plane bodies have adapted meshes")

    def adapted(
        self,
        field: SizeField,
        keep: Sequence[Sequence[float]] = (),
        layers: Layers | None = None,
    ) -> MeshData:
        """Triangles of given sizes in the exact geometry, with the groups of the builder's mesh.

        Args:
            field: wanted sizes.
            keep: points (k, 2) [m] that become nodes, such as those of point conditions; where one
                is closer to the boundary than a tenth of the size, the nearest point of that does.
            layers: surfaces with flat cells, for which sizes are thicknesses.

        Returns:
            The mesh, the same for the same arguments; nodes of curves lie exactly on them.

        Raises:
            MeshError: the body is solid, or cannot be meshed at these sizes.
        """
        points = np.array(keep, dtype=np.float64).reshape(-1, 2)
        return adapt(self.curves(), field, points, layers)

    def refined(self, factor: float) -> Self:
        """The same geometry and groups with cells that are smaller everywhere.

        Args:
            factor: how many times smaller; counts are rounded.

        Returns:
            The builder.

        Raises:
            MeshError: the mesh has no sizes.
        """
        given = {name: getattr(self, name) for name in self.model_fields_set}
        return self.model_validate(given | self.refinement(factor))

    @abstractmethod
    def refinement(self, factor: float) -> dict[str, Any]:
        """Keys of a case file's table, and their values there, that `refined` changes."""

    def cell_type(self) -> CellName:
        """Kind of the cells, without meshing."""
        return "triangle"

    def extent(self) -> Floats:
        """Smallest and largest coordinates (2, 2) [m] of the outline."""
        points = np.concatenate(list(self.outline().values()))
        return np.array([np.nanmin(points, axis=0), np.nanmax(points, axis=0)])


def more(count: int, factor: float, multiple: int = 1) -> int:
    """A count times a factor, rounded to a multiple, at least one of these."""
    return multiple * max(1, round(count * factor / multiple))


def smaller(factor: float, growth: float, **sizes: float) -> dict[str, Any]:
    """Sizes [m] and their growth per distance [-] over a factor, as a case file gives them.

    With the growth too, sizes are divided everywhere: size + growth * distance.
    """
    lengths = {name: f"{size / factor!r} m" for name, size in sizes.items()}
    return lengths | {"growth": min(1.0, growth / factor)}


def graded_count(fine: float, size: float, growth: float, coarse: float, extent: float) -> float:
    """About how many triangles a mesh has whose size grows with the distance from fine facets.

    Args:
        fine: length of the fine part of the boundary [m].
        size: size of the cells there [m].
        growth: increase of the size per distance [-].
        coarse: largest size of a cell [m].
        extent: of the body in either direction [m].

    Returns:
        The integral of 2.3 / h² over the body, where strips around the fine part lie in it.
    """
    s = np.concatenate([[0.0], np.geomspace(1e-3 * min(size, extent), extent, 200)])
    h = np.minimum(coarse, size + growth * s)
    density = 2.3 * np.minimum(fine + np.pi * s, extent) / h / h
    return float(np.sum(0.5 * (density[1:] + density[:-1]) * np.diff(s)))
