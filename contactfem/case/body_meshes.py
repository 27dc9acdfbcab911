"""Meshes of a case's bodies, checked that they fit the case."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Literal

from contactfem.case.cell_materials import cell_materials
from contactfem.common.text import one_line
from contactfem.errors import CaseError, MeshError
from contactfem.meshes import MeshFile

if TYPE_CHECKING:
    from contactfem.case.schema import Case
    from contactfem.meshes import MeshData

type MeshKey = Literal["mesh", "thermal_mesh"]
KEYS: tuple[MeshKey, ...] = ("mesh", "thermal_mesh")
ON_AXIS = 1e-12  # distance from the axis over the largest that counts as none


def built_mesh(case: Case, body: str, key: MeshKey) -> MeshData:
    """A body's mesh, which fits the dimension of the case.

    Args:
        case: the case.
        body: name of the body.
        key: which of its meshes.

    Returns:
        The mesh; a file is read once.

    Raises:
        CaseError: it is no mesh, of the wrong dimension, or on the wrong side of the axis.
    """
    where = f"{case.path}: bodies.{body}.{key}"
    try:
        data: MeshData = getattr(case.bodies[body], key).build()
    except MeshError as error:
        raise CaseError(f"{where}: {one_line(str(error))}") from None
    dim = data.points.shape[1]
    if dim != case.axes:
        raise CaseError(f"{where}: is in {dim}D; dimension = {case.dimension}")
    cell_materials(case, body, data)
    if case.axisymmetric:
        r = data.points[:, 0]
        if r.min() < -ON_AXIS * float(abs(r).max()):
            raise CaseError(
                f"{where}: reaches to x = {r.min():g} m; x is the distance from the axis"
            )
    return data


def mesh_files(case: Case) -> Iterator[tuple[str, MeshKey, MeshFile]]:
    """Body, key and mesh of all meshes that come from files."""
    for name, body in case.bodies.items():
        for key in KEYS:
            if isinstance(mesh := getattr(body, key), MeshFile):
                yield name, key, mesh


def mesh_remarks(case: Case) -> Iterator[tuple[str, str, bool]]:
    """What there is to say about the meshes from files.

    Args:
        case: the case.

    Yields:
        Body and key, a sentence, and whether it is a doubt.

    Raises:
        CaseError: a file that is not a mesh.
    """
    for name, key, mesh in mesh_files(case):
        built_mesh(case, name, key)
        for texts, doubtful in ((mesh.read.notes, False), (mesh.read.doubts, True)):
            for text in texts:
                yield f"bodies.{name}.{key}", text, doubtful
