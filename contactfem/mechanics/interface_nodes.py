"""An interface within the system: which unknowns its nodes have and where they are now."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contactfem.common.time_table import Table
from contactfem.common.typing import Bools, Floats, Ints
from contactfem.mechanics.bulk_system import System
from contactfem.meshes.data import Surface
from contactfem.mortar.directions import OfCircle, of_plane
from contactfem.mortar.interface_mesh import Basis, Directions, InterfaceMesh


@dataclass(frozen=True)
class BodySide:
    """A side that is a surface of a body."""

    body: int
    surface: Surface


@dataclass(frozen=True)
class RigidSide:
    """A side that is a rigid obstacle: a chain of facets that moves as a whole.

    Attributes:
        X: Nodes at time 0 [m], (n, 2).
        facets: Facets with the obstacle on the left, (k, 2).
        displacement: x and y over time [m].
        directions: Of contact with it; None for the nonmortar side's normals.
    """

    X: Floats
    facets: Ints
    displacement: tuple[Table, Table]
    directions: Directions | None


class InterfaceNodes:
    """Nodes of both sides of an interface, nonmortar first; the same numbers on all ranks.

    Args:
        system: The system.
        nonmortar: Nonmortar side.
        mortar: Mortar side.
        basis: Of the multiplier.
        shared: Nonmortar nodes that are on another surface of an interface too.
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
        self.unknown = np.full((len(self.X), 2), -1, np.int64)
        self._sources = [_Source(system, nonmortar, 0)]
        if isinstance(mortar, BodySide):
            self._sources.append(_Source(system, mortar, n))
        found = np.zeros_like(self.unknown)
        for source in self._sources:
            found[source.node] += system.numbering.unknown[source.body][source.dofs] + 1
        self.unknown = self.comm.allreduce(found) - 1
        tied = (self.unknown >= 0) & (self.unknown < len(system.grips))
        free = (self.unknown >= 0) & ~tied
        directions = None if self._rigid is None else self._rigid.directions
        self.mesh = InterfaceMesh(
            n, first.facets, second.facets + n, self.X, free, basis, system.axisymmetric,
            directions, shared,
        )  # fmt: skip
        self._system = system

    @property
    def is_rigid(self) -> bool:
        """Whether the mortar side is an obstacle."""
        return self._rigid is not None

    def positions(self, t: float, ramp_end: float) -> Floats:
        """Current positions of all nodes [m], (n, 2); collective.

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
            (n_nonmortar, 2) on all ranks.
        """
        local = self.unknown[: self.mesh.n_nonmortar] - first
        mine = self.mesh.free[: self.mesh.n_nonmortar] & (local >= 0) & (local < len(values))
        part = np.zeros(local.shape)
        part[mine] = values[local[mine]]
        total = np.empty_like(part)
        self.comm.Allreduce(part, total)
        return total


class _Source:
    """Owned vertices of one body on one side: their node numbers and scalar dofs."""

    def __init__(self, system: System, side: BodySide, offset: int) -> None:
        body = system.bodies[side.body]
        self.body = side.body
        order = np.argsort(side.surface.vertices)
        at = np.searchsorted(side.surface.vertices[order], body.vertices)
        at = np.minimum(at, len(order) - 1)
        owned = body.vertex_dofs[:, 0] < body.n_owned
        here = owned & (side.surface.vertices[order[at]] == body.vertices)
        self.node = order[at[here]] + offset
        self.dofs = body.vertex_dofs[here]


def plane_side(
    point: Sequence[float],
    normal: Sequence[float],
    extent: float,
    displacement: tuple[Table, Table],
) -> RigidSide:
    """A rigid plane as one long facet.

    Args:
        point: A point on it [m].
        normal: Outward from the obstacle [-], not necessarily of unit length.
        extent: Half its length [m].
        displacement: x and y over time [m].

    Returns:
        The side.
    """
    n = np.asarray(normal, float)
    n = n / np.hypot(*n)
    along = extent * np.array((-n[1], n[0]))  # outward normal (dy, -dx) of b - a
    X = np.asarray(point) + np.array((-along, along))
    return RigidSide(X, np.array(((0, 1),)), displacement, of_plane)


def polyline_side(points: Floats, closed: bool, displacement: tuple[Table, Table]) -> RigidSide:
    """A rigid chain of facets.

    Args:
        points: Its points with the solid on the left [m], (n, 2).
        closed: Whether the last point is joined to the first.
        displacement: x and y over time [m].

    Returns:
        The side.
    """
    ends = np.arange(len(points) - (0 if closed else 1))
    facets = np.column_stack((ends, (ends + 1) % len(points)))
    return RigidSide(points, facets, displacement, of_plane if len(facets) == 1 else None)


def circle_side(
    centre: Sequence[float],
    radius: float,
    inside: bool,
    facets: int,
    displacement: tuple[Table, Table],
) -> RigidSide:
    """A rigid circle as a closed polygon of equal area error on both sides of the arc.

    Args:
        centre: Its centre [m].
        radius: Its radius [m].
        inside: Whether bodies touch it from inside (the obstacle lies around the circle).
        facets: Number of facets.
        displacement: x and y over time [m].

    Returns:
        The side.
    """
    turn = 2 * np.pi * np.arange(facets) / facets * (-1 if inside else 1)
    # Corners outside and midpoints inside the circle, so that chords cross it
    r = radius * (1 + (1 - np.cos(np.pi / facets)) / 3)
    X = np.asarray(centre) + r * np.column_stack((np.cos(turn), np.sin(turn)))
    ends = np.arange(facets)
    pairs = np.column_stack((ends, (ends + 1) % facets))
    return RigidSide(X, pairs, displacement, OfCircle(inside))
