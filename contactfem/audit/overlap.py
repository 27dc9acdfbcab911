"""How deep bodies lie in each other and in obstacles."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from contactfem.audit.breach import Breach, place
from contactfem.audit.shapes import BodyShape, ObstacleShape
from contactfem.common.typing import Floats

FLAT = 0.03  # of the facets' size that nodes of flat surfaces may lie inside
BEND = 0.25  # of that times the turn from facet to facet [rad], beside it


@dataclass(frozen=True)
class Overlap:
    """The deepest node of a body in another one.

    Attributes:
        body: The body.
        other: What it is in, a body or an obstacle.
        at: Where [m], (dim,).
        depth: How deep [m].
        allowed: How deep facets and compliant laws of contact explain [m].
    """

    body: str
    other: str
    at: Floats
    depth: float
    allowed: float


def overlaps(
    bodies: Sequence[BodyShape],
    obstacles: Sequence[ObstacleShape],
    met: Mapping[str, frozenset[str]],
    give: Mapping[frozenset[str], float],
) -> Iterator[Overlap]:
    """Deepest node of every body in every other one, and in the obstacles that it may touch.

    Args:
        bodies: The bodies.
        obstacles: The obstacles.
        met: Bodies that may touch each obstacle: behind the others anything may stand.
        give: Penetration that compliant laws allow between two, by their names [m].
    """
    for body in bodies:
        points = body.x[body.nodes]
        others = [other for other in bodies if other is not body]
        others += [o for o in obstacles if body.name in met.get(o.name, ())]
        for other in others:
            depth = other.depth(points)
            worst = int(np.argmax(depth))
            if depth[worst] > FLAT * body.finest:
                size, turn = body.around(body.nodes[worst])
                if isinstance(other, BodyShape):
                    size, turn = np.maximum((size, turn), other.near(points[worst]))
                yield Overlap(
                    body.name, other.name, points[worst], float(depth[worst]),
                    (FLAT + BEND * float(turn)) * float(size)
                    + 2.0 * give.get(frozenset((body.name, other.name)), 0.0),
                )  # fmt: skip


def breaches_of_overlap(found: Sequence[Overlap]) -> Iterator[Breach]:
    """Overlaps that no discretisation explains."""
    for o in found:
        if o.depth > o.allowed:
            yield Breach(
                "depth",
                f"body '{o.body}' is {o.depth:.3g} m deep in '{o.other}' at {place(o.at)}",
                "an interface between the surfaces that meet there, shorter steps, or a larger "
                "search_radius may be missing",
                o.depth,
            )
