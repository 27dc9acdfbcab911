"""Heat of a run: bodies, interfaces, transfers to mechanics."""

from collections.abc import Sequence

import numpy as np

from mpi4py import MPI

from contactfem.common.typing import Floats
from contactfem.contact.pressure import contact_pressure
from contactfem.contact.state import ContactState
from contactfem.heat.body import HeatBody
from contactfem.heat.interface import HeatExchange
from contactfem.heat.system import HeatSolution, HeatStepInput, HeatSystem
from contactfem.results.data import SurfaceHeat
from contactfem.thermomechanics.body_transfer import BodyLink
from contactfem.thermomechanics.interface_transfer import InterfaceLink


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

    def set_temperature(self, theta: Sequence[Floats]) -> None:
        """Give mechanics its temperatures; collective.

        Args:
            theta: Flat local arrays of the bodies [K].
        """
        for link, values in zip(self.links, theta, strict=True):
            link.set_temperature(values)

    def solve(
        self,
        theta: Sequence[Floats],
        u: Sequence[Floats],
        conditions: Sequence[ContactState | None],
        t: float,
        dt: float,
        ramp_end: float,
        before: Sequence[HeatExchange] = (),
    ) -> tuple[HeatSolution, list[HeatExchange]]:
        """One step of the heat problem in the present configuration; collective.

        Args:
            theta: Temperatures at its start [K], flat local arrays of the bodies.
            u: Displacements there on the thermal meshes [m], likewise.
            conditions: Contact conditions at its end, per interface.
            t: Time at its start [s].
            dt: Its length [s].
            ramp_end: Time at which constant motions are reached [s].
            before: What the interfaces exchange at its start; empty if that is not known.

        Returns:
            The solution, and what the interfaces exchange.
        """
        with self.system.timers.book("transfer"):
            for link in self.links if self.moving else ():
                link.set_displacement()
        with self.system.timers.book("heat.interface"):
            exchanges = [
                link.exchange(c, t, dt, ramp_end)
                for link, c in zip(self.interfaces, conditions, strict=True)
            ]
        return self.system.solve(HeatStepInput(t, dt, theta, u, exchanges, before)), exchanges

    def expansions(self, difference: Sequence[Floats]) -> float:
        """How far a difference of temperatures moves a surface, Σ α L max |Δϑ| [m]; collective."""
        comm = self.system.comm
        largest = np.array([float(np.abs(d).max(initial=0.0)) for d in difference])
        comm.Allreduce(MPI.IN_PLACE, largest, MPI.MAX)
        lengths = [link.expansion * link.extent for link in self.links]
        return float(largest @ np.array(lengths))

    def conductance_change(self, conditions: Sequence[ContactState | None], moved: float) -> float:
        """Largest relative change of a conductance if its gap grows by a length [-].

        Args:
            conditions: Contact conditions per interface; None without mechanics.
            moved: The length [m].
        """
        changes = [0.0]
        for link, c in zip(self.interfaces, conditions, strict=True):
            law = link.heat.law.conductance
            seen = None if c is None else np.isfinite(c.operators.gap)
            if law is not None and c is not None and seen is not None and seen.any():
                gap, pressure = c.operators.gap[seen], contact_pressure(c)[seen]
                h, wider = law(pressure, gap).h, law(pressure, gap + moved).h
                largest = float(np.abs(h).max())
                changes.append(float(np.abs(wider - h).max()) / largest if largest > 0.0 else 0.0)
        return max(changes)

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
