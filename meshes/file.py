"""A body's mesh from a file."""

from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field, ValidationInfo, field_validator

from contactfem.common.typing import Floats, Ints
from contactfem.common.units import Length
from contactfem.errors import MeshError
from contactfem.meshes.builder import Builder
from contactfem.meshes.curves import Boundary
from contactfem.meshes.data import (
    CellName,
    MeshData,
    Surface,
    boundary_facets,
    check_points,
    matches,
    mesh_data,
)
from contactfem.meshes.readers import RawMesh, read_mesh
from contactfem.meshes.reconstruct import reconstructed

# A cell's name in files: its dimension, our name, its vertices in dolfinx order.
CELLS: dict[str, tuple[int, CellName, list[int]]] = {
    "triangle": (2, "triangle", [0, 1, 2]),
    "quad": (2, "quadrilateral", [0, 1, 3, 2]),
    "tetra": (3, "tetrahedron", [0, 1, 2, 3]),
    "hexahedron": (3, "hexahedron", [0, 1, 3, 2, 4, 5, 7, 6]),
}


class MeshFile(Builder):
    """Mesh file with coordinates in the length `unit`.

    Its named groups of facets are the body's surfaces. `body` names a group of cells, where the
    file holds more than this body. A relative path starts at the case file's folder.
    """

    file: Path = Field(description="mesh file: gmsh's .msh, or another format that meshio reads")
    unit: Length = Field(gt=0, examples=["mm"], description="length unit of its coordinates")
    body: str | None = Field(
        default=None, description="group of cells, where the file holds more than this body"
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
            MeshError: not a mesh, mixed or unknown kinds of cells, or no such body.
        """
        return self._mesh

    def refinement(self, factor: float) -> dict[str, Any]:
        """Nothing in a file can be made finer.

        Raises:
            MeshError: always.
        """
        raise MeshError(f"{self.file}: a mesh from a file cannot be refined; let it adapt instead")

    @cached_property
    def _mesh(self) -> MeshData:
        """The mesh, read once."""
        try:
            return self._body(read_mesh(self.file))
        except MeshError as error:
            raise MeshError(f"{self.file}: {error}") from error

    def cell_type(self) -> CellName:
        """Kind of the cells."""
        return self._mesh.cell_type

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

    def _body(self, raw: RawMesh) -> MeshData:
        """The body's cells and facet groups out of everything in the file."""
        chosen = raw.groups.get(self.body, {}) if self.body is not None else raw.cells
        kinds = [kind for kind in CELLS if kind in chosen]
        dim = max((CELLS[kind][0] for kind in kinds), default=0)
        kinds = [kind for kind in kinds if CELLS[kind][0] == dim]
        if self.body is not None and not kinds:
            names = [name for name, parts in raw.groups.items() if CELLS.keys() & parts.keys()]
            raise MeshError(
                f"no group of cells '{self.body}'; there are: {', '.join(names) or 'none'}"
            )
        if len(kinds) != 1:
            raise MeshError(
                f"a body needs cells of one kind: {', '.join(CELLS)}; found: "
                f"{', '.join(kinds or raw.cells) or 'none'}"
            )
        _, cell_type, order = CELLS[kinds[0]]
        rows = np.asarray(chosen[kinds[0]])
        if rows.ndim != 2:
            raise MeshError(f"the {kinds[0]} cells of the file are not lists of vertices")
        cells = rows[:, order]
        points = raw.points * self.unit
        check_points(points, cells)
        for kind, others in raw.cells.items():
            if kind != "vertex" and len(others):
                check_points(points, others)
        if dim == 2:
            points = _flat(points, cells)
        facet_kinds = {2: ["line"], 3: ["triangle", "quad"]}[dim]
        groups = {
            name: parts[kind]
            for name, parts in raw.groups.items()
            for kind in facet_kinds
            if kind in parts and name != self.body
        }
        if self.body is not None:
            boundary = boundary_facets(cells, cell_type)
            groups = {name: f[matches(f, boundary) >= 0] for name, f in groups.items()}
            groups = {name: f for name, f in groups.items() if len(f)}
        return mesh_data(points, cells, cell_type, groups)


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


def _flat(points: Floats, cells: Ints) -> Floats:
    """Points in the x-y plane.

    Raises:
        MeshError: the surface is not in a plane of constant z.
    """
    xyz = points[np.unique(cells)]
    size = np.ptp(xyz, axis=0)
    if size[2] > 1e-9 * max(size[0], size[1]):
        raise MeshError("a plane mesh must lie in a plane of constant z")
    return points[:, :2]
