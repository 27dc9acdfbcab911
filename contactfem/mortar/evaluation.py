"""Evaluation of mortar operators, in the plane or in space."""

from mpi4py import MPI

from contactfem.common.typing import Floats, Ints
from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.mortar_operators import MortarOperators, mortar_operators
from contactfem.mortar.spatial_operators import spatial_operators


def operators_at(
    comm: MPI.Comm, mesh: InterfaceMesh, x: Floats, facets: Ints, radius: float
) -> MortarOperators:
    """Search, cut and integrate; collective.

    Args:
        comm: Ranks that share the work.
        mesh: The two surfaces.
        x: Positions [m], (n_nodes, dim).
        facets: This rank's nonmortar facets, (k,).
        radius: Search radius [m].

    Returns:
        The operators, the same on all ranks.
    """
    find = spatial_operators if mesh.dim == 3 else mortar_operators
    return find(comm, mesh, x, facets, radius)
