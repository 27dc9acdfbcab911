"""All that is checked of an accepted state."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from contactfem.audit.breach import Breach, place
from contactfem.audit.forces import (
    BodyForces,
    ContactForces,
    breaches_of_forces,
)
from contactfem.audit.overlap import breaches_of_overlap, overlaps
from contactfem.audit.shapes import BodyShape, ObstacleShape

SHOWN = 3  # cells named


@dataclass(frozen=True)
class AuditState:
    """What is looked at.

    Attributes:
        t: Time [s].
        bodies: The bodies.
        obstacles: The obstacles at this time.
        contacts: Forces of the interfaces.
        forces: Other forces on the bodies.
        unrestrained: Bodies that their conditions leave a rigid motion.
        scene: Diagonal of all that there is at the start [m].
        travel: Farthest that anything is led [m].
        axisymmetric: Whether the bodies stand around the axis x = 0.
        holding: Heat capacity of all bodies [J/m/K], and their largest conductivity [W/m/K].
    """

    t: float
    bodies: tuple[BodyShape, ...]
    obstacles: tuple[ObstacleShape, ...] = ()
    contacts: tuple[ContactForces, ...] = ()
    forces: tuple[BodyForces, ...] = ()
    unrestrained: frozenset[str] = frozenset()
    scene: float = 0.0
    travel: float = 0.0
    axisymmetric: bool = False
    holding: tuple[float, float] = (0.0, 0.0)

    @property
    def met(self) -> Mapping[str, frozenset[str]]:
        """Bodies that have an interface with each obstacle."""
        found: dict[str, set[str]] = {o.name: set() for o in self.obstacles}
        for c in self.contacts:
            if c.mortar in found:
                found[c.mortar].add(c.nonmortar)
        return {name: frozenset(bodies) for name, bodies in found.items()}

    @property
    def give(self) -> Mapping[frozenset[str], float]:
        """Penetration that laws allow between two [m]."""
        found: dict[frozenset[str], float] = {}
        for c in self.contacts:
            pair = frozenset((c.nonmortar, c.mortar))
            found[pair] = max(found.get(pair, 0.0), float(c.give.max(initial=0.0)))
        return found


@dataclass(frozen=True)
class Finding:
    """What a look found.

    Attributes:
        t: Time of the state [s].
        breaches: What it cannot be, the worst kind first.
    """

    t: float
    breaches: tuple[Breach, ...] = field(default=())

    def __str__(self) -> str:
        first = f"at t = {self.t:g} s {self.breaches[0]}" if self.breaches else ""
        more = len(self.breaches) - 1
        return f"{first} (and {more} more)" if more > 0 else first


def look(state: AuditState) -> Finding:
    """Everything that is wrong with a state.

    Args:
        state: The state.

    Returns:
        What was found.
    """
    found = [*_of_numbers(state)]
    if not found:
        found += _of_motion(state)
        found += _of_cells(state)
        found += breaches_of_overlap(
            list(overlaps(state.bodies, state.obstacles, state.met, state.give))
        )
    axes = (1,) if state.axisymmetric else tuple(range(3))
    found += breaches_of_forces(state.contacts, state.forces, axes)
    return Finding(state.t, tuple(found))


def extent(bodies: Sequence[BodyShape], obstacles: Sequence[ObstacleShape]) -> float:
    """Diagonal of all that there is at the start, but for planes [m]."""
    points = [body.X for body in bodies]
    points += [o.points for o in obstacles if o.kind == "polyline"]
    points += [o.points + s * o.radius for o in obstacles if o.radius for s in (-1.0, 1.0)]
    return float(np.linalg.norm(np.ptp(np.concatenate(points), axis=0))) if points else 0.0


def _of_numbers(state: AuditState) -> Iterator[Breach]:
    """Positions that are no numbers."""
    for body in state.bodies:
        if not np.isfinite(body.x).all():
            yield Breach("motion", f"body '{body.name}' is nowhere", "shorter steps may help")


def _of_motion(state: AuditState) -> Iterator[Breach]:
    """Bodies that have left the scene."""
    for body in state.bodies:
        moved = float(np.linalg.norm((body.x - body.X).mean(0)))
        if moved > state.scene + state.travel:
            loose = ", which nothing but contact holds," if body.name in state.unrestrained else ""
            yield Breach(
                "motion",
                f"body '{body.name}'{loose} has moved by {moved:.3g} m, out of a scene of "
                f"{state.scene:.3g} m: it was thrown away",
                "hold it by a condition, start it in touch with what carries it, or take shorter "
                "steps",
                moved,
            )


def _of_cells(state: AuditState) -> Iterator[Breach]:
    """Cells that are inside out."""
    for body in state.bodies:
        cells = body.turned_over()
        if len(cells):
            centre = body.x[body.cells[cells[:SHOWN]]].mean(1)
            where = ", ".join(place(x) for x in centre)
            yield Breach(
                "cells",
                f"{len(cells)} of {len(body.cells)} cells of body '{body.name}' are turned over, "
                f"such as at {where}",
                'shorter steps or a coarser mesh there help; with strain = "small" so large a '
                'deformation has no meaning: take "finite"',
                float(len(cells)),
            )
