"""What a run knows between steps: everything that a failed step must give back."""

from dataclasses import dataclass, field

import numpy as np

from contactfem.contact import Conditions, History
from contactfem.discretise import Discretisation
from contactfem.surfaces import Floats


@dataclass
class State:
    """The one mutable object of a run; it changes only when a step is accepted.

    Attributes:
        t: Time [s].
        x: This rank's unknowns [m].
        u: Displacements of the bodies, flat over local dofs [m].
        histories: Operators at the present positions, per interface.
        slip: Accumulated slip at the nonmortar nodes, per interface [m].
        conditions: Of the last accepted step, per interface; empty before the first.
    """

    t: float
    x: Floats
    u: list[Floats]
    histories: tuple[History, ...]
    slip: list[Floats]
    conditions: tuple[Conditions, ...] = field(default=())

    def restore(self, discretisation: Discretisation) -> None:
        """Put unknowns and displacements back to those of this state."""
        discretisation.system.x.array[:] = self.x
        for body, u in zip(discretisation.system.bodies, self.u, strict=True):
            body.u.x.array[:] = u

    def accept(
        self, t: float, discretisation: Discretisation, conditions: list[Conditions]
    ) -> None:
        """Make the bodies' present state the last good one.

        Args:
            t: Time reached [s].
            discretisation: Holds unknowns and displacements.
            conditions: Contact conditions there, per interface.
        """
        self.t = t
        self.x = discretisation.system.x.array.copy()
        self.u = [body.u.x.array.copy() for body in discretisation.system.bodies]
        self.histories = tuple(
            History(c.operators.D, c.operators.M, c.pressure, c.traction) for c in conditions
        )
        for slip, c in zip(self.slip, conditions, strict=True):
            slip += c.slip
        self.conditions = tuple(conditions)


def initial_state(discretisation: Discretisation, ramp_end: float) -> State:
    """State at time zero: undeformed, obstacles at their first place; collective.

    Args:
        discretisation: The discretisation.
        ramp_end: Time at which constant motions are reached [s].
    """
    histories = []
    for interface in discretisation.interfaces:
        operators = interface.contact.operators(interface.nodes.positions(0.0, ramp_end))
        histories.append(History(operators.D, operators.M))
    return State(
        0.0,
        discretisation.system.x.array.copy(),
        [body.u.x.array.copy() for body in discretisation.system.bodies],
        tuple(histories),
        [np.zeros(i.nodes.mesh.n_nonmortar) for i in discretisation.interfaces],
    )
