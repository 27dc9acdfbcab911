"""Evaluation of mortar operators, in the plane or in space."""

from mpi4py import MPI

from contactfem.common.typing import Floats, Ints
from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.mortar_operators import MortarOperators, mortar_operators
from contactfem.mortar.search_range import SearchRange
from contactfem.mortar.spatial_operators import spatial_operators


def operators_at(
    comm: MPI.Comm, mesh: InterfaceMesh, x: Floats, facets: Ints, reach: SearchRange
) -> MortarOperators:
    """Search, cut and integrate; collective.

    Args:
        comm: Ranks that share the work.
        mesh: The two surfaces.
        x: Positions [m], (n_nodes, dim).
        facets: This rank's nonmortar facets, (k,).
        reach: How far the sides look for each other.

    Returns:
        The operators, the same on all ranks.
    """
    if mesh.dim == 3:
        return spatial_operators(comm, mesh, x, facets, reach.ahead)
    return mortar_operators(comm, mesh, x, facets, reach)
