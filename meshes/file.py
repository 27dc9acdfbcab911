"""A body's mesh from a file."""

from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, ValidationInfo, field_validator

from contactfem.common.typing import Floats
from contactfem.common.units import Length
from contactfem.errors import MeshError
from contactfem.meshes.body_cells import FileBody, file_body
from contactfem.meshes.builder import Builder
from contactfem.meshes.curves import Boundary
from contactfem.meshes.data import CellName, MeshData, Surface
from contactfem.meshes.readers import read_mesh
from contactfem.meshes.reconstruct import reconstructed


class MeshFile(Builder):
    """Mesh file with coordinates in the length `unit`.

    Its named groups of facets, and of nodes the boundary facets between them, are the body's
    surfaces. A relative path starts at the case file's folder.
    """

    file: Path = Field(description="a mesh of gmsh, Abaqus, CalculiX, or what meshio reads")
    unit: Length = Field(gt=0, examples=["mm"], description="length unit of its coordinates")
    body: str | None = Field(
        default=None, description="group of cells, where the file holds more than this body"
    )
    merge: Annotated[Length, Field(ge=0)] | None = Field(
        default=None, description="nodes closer than this are one"
    )

    @field_validator("unit", mode="before")
    @classmethod
    def _one(cls, value: Any) -> Any:
        return f"1 {value}" if isinstance(value, str) and value[:1].isalpha() else value

    @field_validator("file")
    @classmethod
    def _found(cls, value: Path, info: ValidationInfo) -> Path:
        path = Path((info.context or {}).get("folder", "")) / value
        if not path.is_file():
            raise ValueError(f"there is no file '{path}'")
        return path

    def build(self) -> MeshData:
        """Mesh of the body, its lengths converted.

        Raises:
            MeshError: not a mesh, unknown kinds of cells, cells that do not fill a body once, or no
                such body.
        """
        return self.read.data

    def refinement(self, factor: float) -> dict[str, Any]:
        """Nothing in a file can be made finer.

        Raises:
            MeshError: always.
        """
        raise MeshError(f"{self.file}: a mesh from a file cannot be refined; let it adapt instead")

    @cached_property
    def read(self) -> FileBody:
        """The mesh with what there is to say about it, read once.

        Raises:
            MeshError: as `build`.
        """
        try:
            return file_body(read_mesh(self.file), self.body, self.unit, self.merge)
        except MeshError as error:
            raise MeshError(f"{self.file}: {error}") from error

    def cell_type(self) -> CellName:
        """Kind of the cells."""
        return self.build().cell_type

    def outline(self) -> dict[str, Floats]:
        """Boundary polylines of the groups; reads the file. In 3D the groups' points."""
        data = self.build()
        return {name: polyline(data.surface(name)) for name, f in data.groups.items() if len(f)}

    def curves(self) -> Boundary:
        """Smooth curves through the boundary nodes, with corners where that turns by 30 degrees.

        Raises:
            MeshError: the mesh is solid, in several pieces, or its boundary touches itself.
        """
        try:
            return reconstructed(self.build())
        except MeshError as error:
            raise MeshError(f"{self.file}: {error}") from error

    def extent(self) -> Floats:
        """Smallest and largest coordinates (2, dim) [m]; reads the file."""
        points = self.build().points
        return np.array([points.min(axis=0), points.max(axis=0)])


def polyline(surface: Surface) -> Floats:
    """Points along a 2D surface, with a row of NaN between separate chains; in 3D its points."""
    if surface.X.shape[1] == 3:
        return surface.X
    a, b = surface.facets.T
    breaks = np.flatnonzero(a[1:] != b[:-1]) + 1
    chains = np.split(np.arange(len(a)), breaks)
    gap = np.full((1, 2), np.nan)
    parts = [part for k in chains for part in (gap, surface.X[a[k]], surface.X[b[k[-1:]]])]
    return np.concatenate(parts[1:])
