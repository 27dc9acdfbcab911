"""The heat side of a run: its bodies and interfaces, and their links to those of mechanics."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mpi4py import MPI

from contactfem.common.time_table import Table
from contactfem.common.typing import Floats
from contactfem.contact.conditions import Conditions
from contactfem.contact.rim import rim_values
from contactfem.fem.body_mesh import dofs_at_vertices
from contactfem.heat.body import HeatBody
from contactfem.heat.interface import HeatExchange, HeatInterface
from contactfem.heat.system import HeatSolution, HeatStepInput, HeatSystem
from contactfem.mechanics.body import BodyProblem
from contactfem.meshes.data import Surface
from contactfem.results.data import SurfaceHeat
from contactfem.transfer.lumped_projection import Projection
from contactfem.transfer.volume import SurfaceTransfer, VertexValues, VolumeTransfer


class BodyLink:
    """Displacement to a body's thermal mesh, and temperature back to its mechanical one (28).

    Args:
        comm: All ranks.
        mechanics: The body's mechanical problem.
        heat: Its heat problem; on the same mesh nothing is interpolated.
    """

    def __init__(self, comm: MPI.Comm, mechanics: BodyProblem, heat: HeatBody) -> None:
        self._comm, self._mechanics, self._heat = comm, mechanics, heat
        self._same = mechanics.mesh is heat.mesh
        domain = heat.mesh.mesh
        self._u_dofs = dofs_at_vertices(domain, heat.displacement_space)[0]
        temperature = mechanics.temperature
        assert temperature is not None
        self._temperature = temperature
        self._theta_dofs = dofs_at_vertices(mechanics.mesh.mesh, temperature.function_space)[0]
        if self._same:
            return
        self._u_source = VertexValues(comm, mechanics.mesh, mechanics.vertex_space)
        self._u_target = VertexValues(comm, heat.mesh, heat.displacement_space)
        self._theta_source = VertexValues(comm, heat.mesh, heat.V)
        self._theta_target = VertexValues(comm, mechanics.mesh, temperature.function_space)

    def prepare(self) -> None:
        """Make both transfers, for a run that needs them in every step; collective."""
        if not self._same:
            _ = self._to_heat, self._to_mechanics

    @cached_property
    def _to_heat(self) -> VolumeTransfer:
        return VolumeTransfer(self._comm, self._mechanics.mesh, self._heat.mesh, self._heat.name)

    @cached_property
    def _to_mechanics(self) -> Projection:
        return Projection(self._comm, self._heat.mesh, self._mechanics.mesh, self._heat.name)

    def deform(self) -> None:
        """Give the heat problem the present displacement; collective."""
        mechanics, u = self._mechanics, self._heat.u.x.array
        if self._same:
            u[self._u_dofs] = mechanics.u.x.array[mechanics.vertex_dofs]
        else:
            values = self._u_source.replicate(mechanics.u.x.array)
            self._u_target.insert(self._to_heat(values), u)

    def warm(self, theta: Floats) -> None:
        """Give the mechanical problem temperatures of the heat problem, flat local; collective."""
        array = self._temperature.x.array
        if self._same:
            array[self._theta_dofs] = theta[self._heat.vertex_dofs]
        else:
            values = self._theta_source.replicate(theta)
            self._theta_target.insert(self._to_mechanics(values), array)

    @property
    def warmth(self) -> Floats:
        """Temperatures that mechanics has, flat local; to be written to [K]."""
        array: Floats = self._temperature.x.array
        return array


@dataclass(frozen=True)
class InterfaceLink:
    """An interface of the heat problem and what mechanics gives it.

    Attributes:
        heat: The heat side.
        to_heat: From nodes of the mechanical nonmortar surface to the thermal one.
        to_mechanics: The way back.
        pressure: Pressure over time that stands in for that of mechanics [Pa].
        dissipation: Frictional heat per area that stands in for it [W/m²].
        rubs: Whether mechanics has friction there.
        surface: The mechanical nonmortar surface.
    """

    heat: HeatInterface
    to_heat: SurfaceTransfer
    to_mechanics: SurfaceTransfer
    pressure: Table | None
    dissipation: Table | None
    rubs: bool
    surface: Surface

    def exchange(self, c: Conditions | None, t: float, dt: float, ramp_end: float) -> HeatExchange:
        """What the interface exchanges at the end of a step; collective.

        Args:
            c: Contact conditions there; None without mechanics.
            t: Time at the start of the step [s].
            dt: Its length [s].
            ramp_end: Time at which constant motions are reached [s].
        """
        n = self.to_heat.matrix.shape[1]
        pressure, density, power = np.zeros(n), np.zeros(n), None
        if c is not None:
            pressure = contact_pressure(c)
            if self.rubs:
                density, power = friction_heat(c, dt)
        if self.pressure is not None:
            pressure = np.full(n, self.pressure(t + dt))
        if self.dissipation is not None:
            density = np.full(n, 0.5 * (self.dissipation(t) + self.dissipation(t + dt)))
            power = None
        x = self.heat.nodes.positions(t + dt, ramp_end)
        heat = self.to_heat(density)
        if power is not None and not heat.any():  # it fell between the thermal nodes
            heat = self.to_heat.spread(density)
        return self.heat.exchange(x, self.to_heat(pressure), heat, power)


def contact_pressure(c: Conditions) -> Floats:
    """Pressure at the nonmortar nodes, zero where open [Pa], (n_nonmortar,)."""
    return np.asarray(np.maximum(np.where(c.active, rim_values(c)[0], 0.0), 0.0))


def friction_heat(c: Conditions, dt: float) -> tuple[Floats, float]:
    """Frictional heat per area d = t·ṡ (17) and frictional power of an interface.

    Args:
        c: Contact conditions at the end of a step.
        dt: Length of the step [s].

    Returns:
        d at the nonmortar nodes [W/m²], (n_nonmortar,), and Σ D⁰_jj t_j s_j / dt [W/m].
    """
    density = np.where(c.active, rim_values(c)[1] * c.plastic_slip / dt, 0.0)
    power = float(np.sum(c.history.D * c.traction * c.plastic_slip)) / dt
    return np.maximum(density, 0.0), power


class Thermal:
    """Heat of all bodies, beside mechanics.

    Args:
        system: Their system of equations.
        bodies: Links to mechanics, in the order of the system.
        interfaces: Links of the interfaces.
        held: Names of the prescribed temperatures, in the order of the system.
        initial: Temperatures at time zero, flat local arrays of the bodies [K].
        thermoelastic: Whether straining changes temperatures.
        moving: Whether there is mechanics that moves the bodies.
    """

    def __init__(
        self,
        system: HeatSystem,
        bodies: Sequence[BodyLink],
        interfaces: Sequence[InterfaceLink],
        held: Sequence[str],
        initial: Sequence[Floats],
        *,
        moving: bool,
    ) -> None:
        self.system, self.links, self.interfaces = system, tuple(bodies), tuple(interfaces)
        self.held, self.initial, self.moving = tuple(held), tuple(initial), moving
        for link in self.links if moving else ():
            link.prepare()

    @property
    def bodies(self) -> tuple[HeatBody, ...]:
        """The heat problems."""
        return self.system.bodies

    def warm(self, theta: Sequence[Floats]) -> None:
        """Give mechanics its temperatures; collective.

        Args:
            theta: Flat local arrays of the bodies [K].
        """
        for link, values in zip(self.links, theta, strict=True):
            link.warm(values)

    def solve(
        self,
        theta: Sequence[Floats],
        u: Sequence[Floats],
        conditions: Sequence[Conditions | None],
        t: float,
        dt: float,
        ramp_end: float,
    ) -> tuple[HeatSolution, list[HeatExchange]]:
        """One step of the heat problem in the present configuration; collective.

        Args:
            theta: Temperatures at its start [K], flat local arrays of the bodies.
            u: Displacements there on the thermal meshes [m], likewise.
            conditions: Contact conditions at its end, per interface.
            t: Time at its start [s].
            dt: Its length [s].
            ramp_end: Time at which constant motions are reached [s].

        Returns:
            The solution, and what the interfaces exchange.
        """
        with self.system.timers.book("transfer"):
            for link in self.links if self.moving else ():
                link.deform()
        with self.system.timers.book("heat.interface"):
            exchanges = [
                link.exchange(c, t, dt, ramp_end)
                for link, c in zip(self.interfaces, conditions, strict=True)
            ]
        return self.system.solve(HeatStepInput(t, dt, theta, u, exchanges)), exchanges

    def displacements(self) -> list[Floats]:
        """Displacements on the thermal meshes, copied, flat local arrays [m]."""
        return [body.u.x.array.copy() for body in self.bodies]

    def product(self, a: Sequence[Floats], b: Sequence[Floats]) -> float:
        """(a, b)_M = ∫ ρ₀ c a b dV of two fields of all bodies, flat local arrays; collective."""
        mine = sum(float(body.stored(x) @ y) for body, x, y in zip(self.bodies, a, b, strict=True))
        return float(self.system.comm.allreduce(mine))

    def surface_temperature(self, k: int, theta: Sequence[Floats]) -> Floats:
        """Temperature at the mechanical nonmortar nodes of an interface [K]; collective."""
        link = self.interfaces[k]
        nodes = link.heat.nodes
        return link.to_mechanics(nodes.gather(theta, 0.0)[: nodes.mesh.n_nonmortar])

    def surface_heat(
        self, k: int, theta: Sequence[Floats], exchange: HeatExchange, t: float
    ) -> SurfaceHeat:
        """Heat at the mechanical nonmortar nodes of an interface; collective.

        Args:
            k: Number of the interface.
            theta: Temperatures [K], flat local arrays of the bodies.
            exchange: What it exchanges.
            t: Time, for an obstacle's temperature [s].
        """
        link = self.interfaces[k]
        found = link.heat.at_nodes(theta, exchange, t)
        return SurfaceHeat(*(link.to_mechanics(column) for column in found))
