"""Meshes of a case's bodies on the ranks: built, given, or kept."""

from collections.abc import Mapping
from dataclasses import dataclass

from mpi4py import MPI

from contactfem.case.body_meshes import MeshKey, built_mesh
from contactfem.case.schema import Case
from contactfem.errors import CaseError
from contactfem.fem.body_mesh import BodyMesh, distribute
from contactfem.meshes.data import MeshData


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


def _mesh(case: Case, name: str, key: MeshKey, comm: MPI.Comm) -> BodyMesh:
    """A body's mesh on the ranks; an error of the builder on the first rank is raised on all."""
    data, error = None, None
    if comm.rank == 0:
        try:
            data = built_mesh(case, name, key)
        except CaseError as raised:
            error = raised
    error = comm.bcast(error)
    if error is not None:
        raise error
    return distribute(comm, data)
