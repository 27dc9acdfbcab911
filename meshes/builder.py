"""What every named geometry offers: a mesh, and its outline without meshing."""

from abc import ABC, abstractmethod
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from contactfem.meshes.data import CellName, Floats, MeshData
from contactfem.units import Length

PositiveLength = Annotated[Length, Field(gt=0)]
Count = Annotated[int, Field(strict=True, ge=1, le=100_000)]


class Builder(BaseModel, ABC):
    """A geometry with its mesh parameters, as a case file gives them."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    @abstractmethod
    def build(self) -> MeshData:
        """Mesh of the geometry, the same for the same parameters."""

    @abstractmethod
    def outline(self) -> dict[str, Floats]:
        """Boundary polyline (k, 2) [m] of every group, the body on the left; without meshing."""

    def cell_type(self) -> CellName:
        """Kind of the cells, without meshing."""
        return "triangle"

    def extent(self) -> Floats:
        """Smallest and largest coordinates (2, 2) [m] of the outline."""
        points = np.concatenate(list(self.outline().values()))
        return np.array([np.nanmin(points, axis=0), np.nanmax(points, axis=0)])
