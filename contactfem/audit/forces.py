"""Balance, pressure, friction and heat as an observer sees them."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from contactfem.audit.breach import Breach, place
from contactfem.common.typing import Floats

SHARE = 1e-6  # of all forces of a body or an interface that may be out of balance or of sign
MOMENT = 0.05  # of force times lever that both sides of curved surfaces may leave over
ROUND_OFF = 1e-12  # of positions, to which slip is known
HEAT = 1e-6  # of the heat of a step that may come from nowhere


@dataclass(frozen=True)
class ContactForces:
    """Forces of one interface on its nodes, n nonmortar ones first.

    Attributes:
        name: Name of the interface.
        nonmortar: Body of the nonmortar side.
        mortar: Body or obstacle of the mortar side.
        x: Current positions [m], (n_nodes, dim).
        normals: Outward unit normals of the nonmortar nodes [-], (n, dim).
        force: Force on each node [N/m], (n_nodes, dim).
        bound: Largest tangential force at each nonmortar node [N/m], (n,); infinite where no
            multiplier of its own acts.
        slip: Slip of each nonmortar node in the step [m], (n,).
        work: Work of friction there [J/m], (n,).
        give: Penetration that a compliant law allows at each nonmortar node [m], (n,).
        floor: Force that round-off may leave [N/m].
    """

    name: str
    nonmortar: str
    mortar: str
    x: Floats
    normals: Floats
    force: Floats
    bound: Floats
    slip: Floats
    work: Floats
    give: Floats
    floor: float = 0.0

    def on(self, body: str) -> tuple[Floats, float]:
        """Force on a body, and the sum of its nodal forces' sizes [N/m]."""
        n, dim = self.normals.shape
        parts = [self.force[:n]] * (body == self.nonmortar)
        parts += [self.force[n:]] * (body == self.mortar)
        if not parts:
            return np.zeros(dim), 0.0
        force = np.concatenate(parts)
        return force.sum(0), float(np.linalg.norm(force, axis=1).sum())


@dataclass(frozen=True)
class BodyForces:
    """Forces on one body that do not come from contact [N/m], (dim,) each.

    Attributes:
        name: Name of the body.
        loads: Sum of its loads.
        supports: Sum of what prescribed motions exert.
        size: Sum of the sizes of both.
        floor: What round-off may leave over.
    """

    name: str
    loads: Floats
    supports: Floats
    size: float
    floor: float


@dataclass(frozen=True)
class HeatTerms:
    """Heat of one step [J/m]: what is stored, and where it came from.

    Attributes:
        stored: Growth of what the bodies hold.
        sources: Where it came from, by name.
        passed: What went through the interfaces.
        noise: What round-off may leave over of the heat that bodies hold and conduct.
    """

    stored: float
    sources: dict[str, float]
    passed: float = 0.0
    noise: float = 0.0


def breaches_of_forces(
    contacts: tuple[ContactForces, ...], bodies: tuple[BodyForces, ...], axes: tuple[int, ...]
) -> Iterator[Breach]:
    """What forces of a state cannot be.

    Args:
        contacts: Of the interfaces.
        bodies: Of the bodies.
        axes: Directions in which forces balance: not across an axis of symmetry.
    """
    for body in bodies:
        yield from _unbalanced(body, contacts, axes)
    for c in contacts:
        yield from _one_sided(c, axes)
        yield from _pulling(c)
        yield from _rubbing(c)


def breaches_of_heat(heat: HeatTerms) -> Iterator[Breach]:
    """What the heat of a step cannot be."""
    scale = max([abs(heat.stored), heat.passed, *map(abs, heat.sources.values())])
    defect = heat.stored - sum(heat.sources.values())
    if abs(defect) > HEAT * scale + heat.noise:
        yield Breach(
            "heat",
            f"{defect:.3g} J/m of heat come from nowhere, {abs(defect) / scale:.1g} of what moves",
            "a smaller time step or solver.tolerance may help",
        )
    friction = heat.sources.get("friction", 0.0)
    if friction < -HEAT * scale - heat.noise:
        yield Breach(
            "heat",
            f"friction takes {-friction:.3g} J/m of heat instead of giving it",
            "a smaller time step may help",
        )


def _unbalanced(
    body: BodyForces, contacts: tuple[ContactForces, ...], axes: tuple[int, ...]
) -> Iterator[Breach]:
    """A body whose forces do not sum to zero."""
    found = [c.on(body.name) for c in contacts]
    total = (
        body.loads + body.supports + sum((force for force, _ in found), np.zeros_like(body.loads))
    )
    left = float(np.linalg.norm(total[_those(axes, total)]))
    scale = body.size + sum(size for _, size in found)
    if left > SHARE * scale + body.floor:
        yield Breach(
            "balance",
            f"the forces on body '{body.name}' leave {left:.3g} N/m over, {left / scale:.1g} of "
            "all of them",
            "a smaller solver.tolerance may help",
        )


def _one_sided(c: ContactForces, axes: tuple[int, ...]) -> Iterator[Breach]:
    """An interface whose two sides feel different forces, or far from opposite moments."""
    sizes = np.linalg.norm(c.force, axis=1)
    whole = float(sizes.sum())
    left = float(np.linalg.norm(c.force.sum(0)[_those(axes, c.x[0])]))
    if left > SHARE * whole + c.floor:
        yield Breach(
            "action and reaction",
            f"the two sides of interface '{c.name}' feel forces that differ by {left:.3g} N/m",
            "this is a defect of the program",
        )
    if whole == 0.0 or 0 not in axes:
        return
    pressed = sizes > 0.0
    arm = c.x - c.x[pressed].mean(0)
    moment = np.abs(_moments(arm, c.force).sum(0)).max()
    lever = float(np.linalg.norm(arm[pressed], axis=1).max())
    if moment > (MOMENT * whole + c.floor) * lever:
        yield Breach(
            "action and reaction",
            f"the two sides of interface '{c.name}' feel moments that differ by {moment:.3g} N",
            "finer facets where it is curved help",
        )


def _those(axes: tuple[int, ...], vector: Floats) -> list[int]:
    """Directions that a vector has."""
    return [axis for axis in axes if axis < len(vector)]


def _moments(arm: Floats, force: Floats) -> Floats:
    """Moments of forces, (n, 1) in 2D, (n, 3) in 3D."""
    if arm.shape[1] == 3:
        return np.asarray(np.cross(arm, force))
    return np.asarray(arm[:, :1] * force[:, 1:] - arm[:, 1:] * force[:, :1])


def _normal_and_tangential(c: ContactForces) -> tuple[Floats, Floats]:
    """Forces that press the nonmortar nodes, and the size of those along the surface [N/m]."""
    force = c.force[: len(c.normals)]
    normal = -np.einsum("ni,ni->n", force, c.normals)
    along = np.linalg.norm(force + normal[:, None] * c.normals, axis=1)
    return normal, along


def _pulling(c: ContactForces) -> Iterator[Breach]:
    """Contact that pulls."""
    normal, _ = _normal_and_tangential(c)
    if not len(normal):
        return
    pulled = np.where(np.isfinite(c.bound), normal, 0.0)
    worst = int(np.argmin(pulled))
    if pulled[worst] < -SHARE * np.linalg.norm(c.force[: len(normal)], axis=1).sum() - c.floor:
        yield Breach(
            "pressure",
            f"contact at '{c.name}' pulls with {-normal[worst]:.3g} N/m at {place(c.x[worst])}",
            "a smaller time step or solver.tolerance may help",
        )


def _rubbing(c: ContactForces) -> Iterator[Breach]:
    """Friction above its bound, or that does work instead of taking it."""
    normal, along = _normal_and_tangential(c)
    excess = along - c.bound
    scale = float(np.linalg.norm(c.force[: len(normal)], axis=1).sum())
    if len(excess) and excess.max() > SHARE * scale + c.floor:
        worst = int(np.argmax(excess))
        yield Breach(
            "friction",
            f"the tangential force at '{c.name}', {place(c.x[worst])}, is {along[worst]:.3g} N/m, "
            f"above its bound {c.bound[worst]:.3g} N/m",
            "a smaller time step or solver.tolerance may help",
        )
    motion = SHARE * np.abs(c.slip).max(initial=0.0) + ROUND_OFF * np.abs(c.x).max()
    least = SHARE * float(np.abs(c.work).sum()) + scale * float(motion)
    if len(c.work) and c.work.min() < -least:
        worst = int(np.argmin(c.work))
        yield Breach(
            "friction",
            f"friction at '{c.name}', {place(c.x[worst])}, gives {-c.work[worst]:.3g} J/m instead "
            "of taking work",
            "a smaller time step may help",
        )
