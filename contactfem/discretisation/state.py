"""State of a run between two steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from contactfem.common.typing import Floats
from contactfem.contact.slip import transported
from contactfem.contact.state import ContactHistory, ContactState
from contactfem.discretisation.discretise import Discretisation
from contactfem.heat.ringing import Increments
from contactfem.laws.active_set import ActiveSet

if TYPE_CHECKING:
    from contactfem.heat.interface import HeatExchange


@dataclass
class State:
    """The one mutable object of a run; it changes only when a step is accepted.

    Attributes:
        t: Time [s].
        x: This rank's unknowns [m].
        u: Displacements of the bodies, flat over local dofs [m].
        histories: Operators at the present positions, per interface.
        slip: Accumulated slip at the nonmortar nodes, vectors in the present tangent planes, per
            interface [m].
        conditions: Of the last accepted step, per interface; empty before the first.
        theta: Temperatures of the bodies, flat over local dofs [K]; empty without heat.
        thermal_u: Displacements on the thermal meshes, likewise [m].
        dt: Length of the last step [s]; zero before the first.
        repeatable: Whether a later step may go back to the state before it.
        rate: Mean rates of temperature in the last step, likewise [K/s]; empty before the first.
        guess: Contact status to start from where there are no conditions, per interface.
        warmth: Temperatures that mechanics last had its equilibrium at, likewise [K].
        exchanges: Heat through the interfaces in the last step; empty before the first.
        increments: Of the temperatures in the last steps, by which ringing is found.
    """

    t: float
    x: Floats
    u: list[Floats]
    histories: tuple[ContactHistory, ...]
    slip: list[Floats]
    conditions: tuple[ContactState, ...] = field(default=())
    theta: list[Floats] = field(default_factory=list)
    thermal_u: list[Floats] = field(default_factory=list)
    dt: float = 0.0
    repeatable: bool = False
    rate: list[Floats] = field(default_factory=list)
    guess: tuple[ActiveSet | None, ...] = ()
    mechanical_temperature: list[Floats] = field(default_factory=list)
    exchanges: tuple[HeatExchange, ...] = ()
    increments: Increments = field(default_factory=Increments)

    def starts(self) -> tuple[ActiveSet | None, ...]:
        """Contact status that the next step may start from, per interface; None to find it."""
        if not self.conditions:
            return self.guess or (None,) * len(self.histories)
        return tuple(c.active_set if c.active.any() else None for c in self.conditions)

    def restore(self, discretisation: Discretisation) -> None:
        """Put unknowns and displacements back to those of this state."""
        discretisation.system.x.array[:] = self.x
        for body, u in zip(discretisation.system.bodies, self.u, strict=True):
            body.u.x.array[:] = u
        if discretisation.heat is not None:
            heat = zip(discretisation.heat.bodies, self.thermal_u, self.theta, strict=True)
            for set_temperature, moved, theta in heat:
                set_temperature.u.x.array[:], set_temperature.theta.x.array[:] = moved, theta
            for link, mechanical_temperature in zip(
                discretisation.heat.links, self.mechanical_temperature, strict=True
            ):
                link.mechanical_temperature[:] = mechanical_temperature

    def accept(
        self, t: float, discretisation: Discretisation, conditions: list[ContactState]
    ) -> None:
        """Make the bodies' present state the last good one.

        Args:
            t: Time reached [s].
            discretisation: Holds unknowns and displacements.
            conditions: Contact conditions there, per interface.
        """
        self.dt, self.t = t - self.t, t
        self.x = discretisation.system.x.array.copy()
        self.u = [body.u.x.array.copy() for body in discretisation.system.bodies]
        self.histories = tuple(c.as_history() for c in conditions)
        self.slip = [
            transported(slip, c.history.normals, c.operators.normals.n) + c.slip
            for slip, c in zip(self.slip, conditions, strict=True)
        ]
        self.conditions = tuple(conditions)

    def accept_heat(
        self,
        theta: list[Floats],
        exchanges: Sequence[HeatExchange],
        discretisation: Discretisation,
    ) -> None:
        """Make the temperatures of a step the last good ones.

        Args:
            theta: Temperatures at its end [K], flat local arrays of the bodies.
            exchanges: Heat through the interfaces.
            discretisation: Holds the displacements on the thermal meshes.
        """
        assert discretisation.heat is not None
        self.theta, self.exchanges = theta, tuple(exchanges)
        self.thermal_u = discretisation.heat.displacements()
        self.mechanical_temperature = [
            link.mechanical_temperature.copy() for link in discretisation.heat.links
        ]
        for body, values in zip(discretisation.heat.bodies, theta, strict=True):
            body.theta.x.array[:] = values


def initial_state(discretisation: Discretisation, ramp_end: float) -> State:
    """State at time zero: undeformed, obstacles at their first place; collective.

    Args:
        discretisation: The discretisation.
        ramp_end: Time at which constant motions are reached [s].
    """
    histories = []
    for interface in discretisation.interfaces:
        operators = interface.contact.operators(interface.nodes.positions(0.0, ramp_end))
        histories.append(ContactHistory.at(operators))
    state = State(
        0.0,
        discretisation.system.x.array.copy(),
        [body.u.x.array.copy() for body in discretisation.system.bodies],
        tuple(histories),
        [np.zeros((i.nodes.mesh.n_nonmortar, i.nodes.mesh.dim)) for i in discretisation.interfaces],
    )
    if discretisation.heat is not None:
        initial = [theta.copy() for theta in discretisation.heat.initial]
        discretisation.heat.set_temperature(initial)
        state.accept_heat(initial, (), discretisation)
    return state
