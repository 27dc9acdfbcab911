"""What Newton's method asks of the equations of mechanics with contact."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from petsc4py import PETSc

from contactfem.common.timers import Timers
from contactfem.common.typing import Floats
from contactfem.contact.conditions import Contact
from contactfem.contact.state import ContactHistory, ContactState
from contactfem.laws.active_set import ActiveSet
from contactfem.mechanics.bulk_system import System
from contactfem.mechanics.interface_nodes import InterfaceNodes


@dataclass(frozen=True)
class Interface:
    """One interface of the system."""

    name: str
    nodes: InterfaceNodes
    contact: Contact


class ContactEquations(Protocol):
    """Equilibrium of a system of bodies with the contact conditions of its interfaces.

    Attributes:
        system: The bodies.
        interfaces: The interfaces.
        timers: Where time is booked.
        eliminates_multipliers: Whether the unknowns are those of the bodies alone.
    """

    system: System
    interfaces: tuple[Interface, ...]
    timers: Timers
    eliminates_multipliers: bool

    def evaluate(
        self,
        positions: Sequence[Floats],
        histories: Sequence[ContactHistory],
        starts: Sequence[ActiveSet | None],
        bulk: PETSc.Vec,
        out: PETSc.Vec,
    ) -> list[ContactState]:
        """Contact states, and the residual from that of the bulk; collective.

        Args:
            positions: Of the nodes of every interface [m].
            histories: What the step started from, per interface.
            starts: Active set to take, per interface; None for that of the trial multipliers.
            bulk: Residual without contact [N/m].
            out: Receives the residual [N/m].

        Returns:
            The state of every interface.
        """

    def linearise(
        self, states: Sequence[ContactState], jumps: Sequence[Floats | None]
    ) -> PETSc.Mat:
        """The tangent, which stays valid until the next one is asked for; collective.

        Args:
            states: Of every interface.
            jumps: Jumps of prescribed motions that the bulk has not followed yet.
        """
