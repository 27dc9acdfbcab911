"""Unknowns and positions of the nodes of an interface."""

import numpy as np

from contactfem.common.typing import Bools, Floats
from contactfem.geometry.facets import around
from contactfem.mechanics.bulk_system import System
from contactfem.mortar.interface_mesh import Basis, InterfaceMesh
from contactfem.mortar.sides import BodySide, RigidSide
from contactfem.mortar.surface_nodes import SurfaceNodes, owned_nodes


class InterfaceNodes:
    """Nodes of both sides of an interface, nonmortar first; the same numbers on all ranks.

    Args:
        system: The system.
        nonmortar: Nonmortar side.
        mortar: Mortar side.
        basis: Of the multiplier.
        shared: Nonmortar nodes that are on another surface of an interface too.

    Attributes:
        body: Number of every node's body, -1 of an obstacle, (n,).
        vertex: Its input vertex there, (n,).
    """

    def __init__(
        self,
        system: System,
        nonmortar: BodySide,
        mortar: BodySide | RigidSide,
        basis: Basis = "dual",
        shared: Bools | None = None,
    ) -> None:
        self.comm = system.comm
        self.nonmortar = nonmortar
        self._rigid = mortar if isinstance(mortar, RigidSide) else None
        first, second = (
            nonmortar.surface,
            mortar.surface if isinstance(mortar, BodySide) else mortar,
        )
        n = len(first.X)
        self.X = np.vstack((first.X, second.X))
        self.body = np.full(len(self.X), -1, np.int64)
        self.vertex = np.full(len(self.X), -1, np.int64)
        self.body[:n], self.vertex[:n] = nonmortar.body, nonmortar.surface.vertices
        if isinstance(mortar, BodySide):
            self.body[n:], self.vertex[n:] = mortar.body, mortar.surface.vertices
        self.unknown = np.full(self.X.shape, -1, np.int64)
        self._sources = [_owned(system, nonmortar, 0)]
        if isinstance(mortar, BodySide):
            self._sources.append(_owned(system, mortar, n))
        found = np.zeros_like(self.unknown)
        for source in self._sources:
            found[source.node] += system.numbering.unknown[source.body][source.dofs] + 1
        self.unknown = self.comm.allreduce(found) - 1
        tied = (self.unknown >= 0) & (self.unknown < len(system.tied))
        free = (self.unknown >= 0) & ~tied
        directions = None if self._rigid is None else self._rigid.directions
        own, other = (
            around(facets) if self.X.shape[1] == 3 else facets
            for facets in (first.facets, second.facets + n)
        )
        self.mesh = InterfaceMesh(
            n, own, other, self.X, free, basis, system.axisymmetric, directions, shared
        )
        self._system = system

    @property
    def is_rigid(self) -> bool:
        """Whether the mortar side is an obstacle."""
        return self._rigid is not None

    def positions(self, t: float, ramp_end: float) -> Floats:
        """Current positions of all nodes [m], (n, dim); collective.

        Args:
            t: Time, for the motion of an obstacle [s].
            ramp_end: Time at which constant motions are reached [s].
        """
        u = np.zeros_like(self.X)
        for source in self._sources:
            u[source.node] = self._system.bodies[source.body].u.x.array[source.dofs]
        total = np.empty_like(u)
        self.comm.Allreduce(u, total)
        if self._rigid is not None:
            motion = [table.at(t, ramp_end) for table in self._rigid.displacement]
            total[self.mesh.n_nonmortar :] = motion
        return self.X + total

    def gather(self, values: Floats, first: int) -> Floats:
        """Entries of a distributed vector at the nonmortar nodes, 0 where prescribed; collective.

        Args:
            values: This rank's entries, flat.
            first: Global number of the first of them.

        Returns:
            (n_nonmortar, dim) on all ranks.
        """
        local = self.unknown[: self.mesh.n_nonmortar] - first
        mine = self.mesh.free[: self.mesh.n_nonmortar] & (local >= 0) & (local < len(values))
        part = np.zeros(local.shape)
        part[mine] = values[local[mine]]
        total = np.empty_like(part)
        self.comm.Allreduce(part, total)
        return total


def _owned(system: System, side: BodySide, offset: int) -> SurfaceNodes:
    body = system.bodies[side.body]
    return owned_nodes(side, offset, body.vertices, body.vertex_dofs, body.n_owned)
