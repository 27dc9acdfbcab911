"""Which material each cell of a body has."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from contactfem.common.text import nearest
from contactfem.common.typing import Floats, Ints
from contactfem.errors import CaseError
from contactfem.meshes import MeshFile
from contactfem.meshes.data import boundary, matches

if TYPE_CHECKING:
    from contactfem.case.schema import Case
    from contactfem.meshes import MeshData


@dataclass(frozen=True)
class CellMaterials:
    """Materials of a body's cells.

    Attributes:
        names: The materials.
        numbers: Which of them each cell of the input mesh has, (cells,); None with only one.
    """

    names: tuple[str, ...]
    numbers: Ints | None

    def values(self, of_each: dict[str, float]) -> float | Floats:
        """A number of every material by name, as one number or one for every cell."""
        found = np.array([of_each[name] for name in self.names])
        return float(found[0]) if self.numbers is None else np.asarray(found[self.numbers])


def broken_cell_materials(case: Case, body: str) -> Iterator[str]:
    """What is wrong with the materials of a body that has several.

    Args:
        case: The case; its bodies' materials are there.
        body: Name of the body.

    Yields:
        One line "dotted.key: what is wrong" per mistake.
    """
    table = case.bodies[body]
    if not table.materials:
        return
    key = f"bodies.{body}.materials"
    for name in ("mesh", "thermal_mesh"):
        if (mesh := getattr(table, name)) is not None and not isinstance(mesh, MeshFile):
            yield f"{key}: needs groups of cells; {name} is of a builder, which makes none"
    own = [case.materials[name] for name in table.all_materials]
    if len({(material.model, *sorted(material.parameters)) for material in own}) > 1:
        yield f"{key}: all must have one model, with the same parameters"
    if len({material.reference_temperature for material in own}) > 1:
        yield f"{key}: all must have the same reference_temperature, or none"
    if case.adaptivity is not None:
        yield f"{key}: adaptivity makes new meshes without groups of cells; leave one of both out"


def cell_materials(case: Case, body: str, data: MeshData) -> CellMaterials:
    """Material of every cell of a body's mesh.

    Args:
        case: The case.
        body: Name of the body.
        data: One of its meshes.

    Raises:
        CaseError: No such group, a cell in two of them, or in none where the body has no material
            for the others.
    """
    table = case.bodies[body]
    names = table.all_materials
    if not table.materials:
        return CellMaterials(names, None)
    key = f"{case.path}: bodies.{body}.materials"
    numbers = np.full(len(data.cells), -1, dtype=np.int64)
    for group, material in table.materials.items():
        if group not in data.cell_groups:
            known = nearest(group, list(data.cell_groups)) or "; the mesh has none"
            raise CaseError(f"{key}.{group}: there is no such group of cells{known}")
        cells = data.cell_groups[group]
        new = names.index(material)
        twice = (numbers[cells] >= 0) & (numbers[cells] != new)
        if twice.any():
            raise CaseError(f"{key}.{group}: {twice.sum()} cells have another material already")
        numbers[cells] = new
    if table.material is None and (numbers < 0).any():
        raise CaseError(
            f"{key}: {(numbers < 0).sum()} of {len(numbers)} cells are in none of these groups; "
            "'material' is that of all other cells"
        )
    numbers[numbers < 0] = names.index(table.material) if table.material is not None else 0
    return CellMaterials(names, numbers)


def surface_modulus(case: Case, body: str, surface: str, data: MeshData) -> float:
    """Smallest Young's modulus of the cells at a surface [Pa].

    Args:
        case: The case.
        body: Name of the body.
        surface: One of its surfaces.
        data: Its mesh.
    """
    materials = cell_materials(case, body, data)
    moduli = materials.values({name: case.materials[name].E for name in materials.names})
    if isinstance(moduli, float):
        return moduli
    facets, cells = boundary(data.cells, data.cell_type)
    return float(moduli[cells[matches(data.groups[surface], facets)]].min())
