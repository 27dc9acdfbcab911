"""Nodes of both thermal surfaces of an interface."""

from collections.abc import Sequence

import numpy as np

from mpi4py import MPI

from contactfem.common.typing import Bools, Floats
from contactfem.fem.dof_numbering import Unknowns
from contactfem.heat.body import HeatBody
from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.sides import BodySide, RigidSide
from contactfem.mortar.surface_nodes import SurfaceNodes, owned_nodes


class HeatNodes:
    """Nodes of both thermal surfaces, nonmortar first; the same numbers on all ranks.

    Args:
        bodies: All heat bodies.
        unknowns: Their unknowns.
        nonmortar: Nonmortar side.
        mortar: Mortar side.
        free: Components of each node that contact may move, (n, 2), for the normals.
        axisymmetric: Whether the surfaces run around the axis x = 0.
    """

    def __init__(
        self,
        bodies: Sequence[HeatBody],
        unknowns: Unknowns,
        nonmortar: BodySide,
        mortar: BodySide | RigidSide,
        free: Bools,
        axisymmetric: bool,
    ) -> None:
        self.comm, self._bodies = unknowns.comm, bodies
        self._rigid = mortar if isinstance(mortar, RigidSide) else None
        second = mortar if isinstance(mortar, RigidSide) else mortar.surface
        n = len(nonmortar.surface.X)
        X = np.vstack((nonmortar.surface.X, second.X))
        facets = nonmortar.surface.facets, second.facets + n
        directions = None if self._rigid is None else self._rigid.directions
        self.mesh = InterfaceMesh(
            n, *facets, X, free, axisymmetric=axisymmetric, directions=directions
        )
        self._sources = [_owned(bodies[nonmortar.body], nonmortar, 0)]
        if isinstance(mortar, BodySide):
            self._sources.append(_owned(bodies[mortar.body], mortar, n))
        found = np.zeros(len(X), np.int64)
        for source in self._sources:
            found[source.node] += unknowns.numbering.unknown[source.body][source.dofs[:, 0]] + 1
        self.unknown = self.comm.allreduce(found) - 1

    @property
    def is_rigid(self) -> bool:
        """Whether the mortar side is an obstacle."""
        return self._rigid is not None

    @property
    def is_of_body(self) -> Bools:
        """Which nodes belong to a body, not to an obstacle, (n,)."""
        count = self.mesh.n_nonmortar if self.is_rigid else len(self.mesh.X)
        return np.asarray(np.arange(len(self.mesh.X)) < count)

    def positions(self, t: float, ramp_end: float) -> Floats:
        """Current positions of all nodes [m], (n, 2); collective.

        Args:
            t: Time, for the motion of an obstacle [s].
            ramp_end: Time at which constant motions are reached [s].
        """
        u = np.zeros_like(self.mesh.X)
        for source in self._sources:
            dofs = u.shape[1] * source.dofs + np.arange(u.shape[1])
            u[source.node] = self._bodies[source.body].u.x.array[dofs]
        self.comm.Allreduce(MPI.IN_PLACE, u)
        if self._rigid is not None:
            u[self.mesh.n_nonmortar :] = [v.at(t, ramp_end) for v in self._rigid.displacement]
        return self.mesh.X + u

    def gather(self, values: Sequence[Floats], obstacle: float) -> Floats:
        """Nodal values of the bodies' local arrays, (n,) on all ranks; collective.

        Args:
            values: One array per body, flat over local dofs.
            obstacle: Value of an obstacle's nodes.
        """
        found = np.zeros(len(self.mesh.X))
        for source in self._sources:
            found[source.node] = values[source.body][source.dofs[:, 0]]
        self.comm.Allreduce(MPI.IN_PLACE, found)
        if self._rigid is not None:
            found[self.mesh.n_nonmortar :] = obstacle
        return found

    def scatter(self, values: Floats, parts: Sequence[Floats]) -> None:
        """Add nodal values to the bodies' local arrays, each on the rank that owns the node."""
        for source in self._sources:
            parts[source.body][source.dofs[:, 0]] += values[source.node]


def _owned(body: HeatBody, side: BodySide, offset: int) -> SurfaceNodes:
    return owned_nodes(side, offset, body.vertices, body.vertex_dofs, body.n_owned)
