"""Meshes of a case's bodies on the ranks: built, given, or kept."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from mpi4py import MPI

from contactfem.case.schema import Case
from contactfem.common.typing import Floats
from contactfem.errors import CaseError
from contactfem.fem.body_mesh import BodyMesh, distribute
from contactfem.meshes.data import MeshData

ON_AXIS = 1e-12  # distance from the axis over the largest that counts as none


@dataclass(frozen=True)
class GivenMeshes:
    """Meshes that stand in for those of the case file, on the first rank: adapted ones.

    Attributes:
        mechanical: By body.
        thermal: By body.
    """

    mechanical: Mapping[str, MeshData | None]
    thermal: Mapping[str, MeshData | None]


def mechanical_mesh(
    case: Case, name: str, comm: MPI.Comm, given: GivenMeshes | None, kept: BodyMesh | None
) -> BodyMesh:
    """A body's mechanical mesh; collective.

    Args:
        case: The case.
        name: The body.
        comm: All ranks.
        given: Meshes to take instead of those of the case.
        kept: The mesh it had, which stays if none is given.
    """
    if given is None:
        return _mesh(case, name, "mesh", comm)
    if kept is not None and name not in given.mechanical:
        return kept
    return distribute(comm, given.mechanical.get(name))


def thermal_mesh(
    case: Case,
    name: str,
    comm: MPI.Comm,
    given: GivenMeshes | None,
    mechanical: BodyMesh,
    kept: BodyMesh | None,
) -> BodyMesh:
    """A body's thermal mesh: its own, or its mechanical one; collective.

    Args:
        case: The case.
        name: The body.
        comm: All ranks.
        given: Meshes to take instead of those of the case.
        mechanical: Its mechanical mesh.
        kept: The thermal mesh it had, which stays if none is given.
    """
    if given is None:
        own = case.bodies[name].thermal_mesh is not None
        return _mesh(case, name, "thermal_mesh", comm) if own else mechanical
    if kept is not None and name not in given.thermal:
        return kept
    own = bool(comm.bcast(name in given.thermal))
    return distribute(comm, given.thermal.get(name)) if own else mechanical


def _mesh(case: Case, name: str, key: Literal["mesh", "thermal_mesh"], comm: MPI.Comm) -> BodyMesh:
    """A body's mesh on the ranks; an error of the builder on the first rank is raised on all."""
    data, error = None, None
    if comm.rank == 0:
        try:
            data = getattr(case.bodies[name], key).build()
            if case.axisymmetric:
                _check_radii(data.points[:, 0])
        except CaseError as raised:
            error = CaseError(f"{case.path}: bodies.{name}.{key}: {raised}")
    error = comm.bcast(error)
    if error is not None:
        raise error
    return distribute(comm, data)


def _check_radii(r: Floats) -> None:
    """Radii must not be negative, beyond round-off.

    Raises:
        CaseError: Some are.
    """
    if r.min() < -ON_AXIS * float(np.abs(r).max()):
        raise CaseError(f"reaches to x = {r.min():g} m; x is the distance from the axis")
