"""Search range of an interface from its present meshes."""

from collections.abc import Mapping

from mpi4py import MPI

from contactfem.case.schema import Case
from contactfem.case.search_distances import (
    obstacle_thickness,
    outline_of,
    radius_in_space,
    search_distances,
    side_thickness,
)
from contactfem.fem.body_mesh import BodyMesh
from contactfem.mortar.search_range import SearchRange


def search_range(
    case: Case, name: str, meshes: Mapping[str, BodyMesh], comm: MPI.Comm
) -> SearchRange:
    """Search range of an interface of the case; collective.

    Args:
        case: The case.
        name: The interface.
        meshes: Meshes of the bodies; the whole ones are read on the first rank.
        comm: All ranks.

    Returns:
        The range.
    """
    interface = case.interfaces[name]
    body, _, surface = interface.nonmortar.partition(".")
    nonmortar = meshes[body].surface(surface)
    if case.axes == 3:
        radius = interface.search_radius or radius_in_space(nonmortar)
        return SearchRange.within(radius, len(nonmortar.facets))
    if interface.search_radius is not None:
        return SearchRange.within(interface.search_radius, len(nonmortar.facets))
    found = None
    if (data := meshes[body].data) is not None:
        other = None
        if interface.mortar in case.obstacles:
            other = obstacle_thickness(case.obstacles[interface.mortar])
        else:
            second, _, face = interface.mortar.partition(".")
            mesh = meshes[second]
            if second != body and mesh.data is not None:
                other = side_thickness(mesh.surface(face), outline_of(mesh.data))
        found = search_distances(interface, nonmortar, outline_of(data), other)
    ahead, behind = comm.bcast(found)
    return SearchRange(ahead, behind)
