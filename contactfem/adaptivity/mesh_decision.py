"""Whether meshes are replaced, and the sizes of the new ones."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from contactfem.adaptivity.policies import MeshPolicy, MeshReport, Remesh, decide_mesh
from contactfem.adaptivity.sizes import (
    SizeLimits,
    equal_error_sizes,
    goal,
    predicted_cells,
    predicted_error,
    rounded,
    size_field,
)
from contactfem.common.typing import Floats, Ints
from contactfem.results.relative_error import RelativeError

ORDER = 1  # of the elements: P1, Q1 and MINI
LEAST_SHARE = 0.01  # of the square of the error wanted, that is left to the meshes that may change
FULL = 0.9  # of the cells that are allowed
LARGEST, SMALLEST = 8.0, 256.0  # size_max is the extent over the first, size_min that over both


@dataclass(frozen=True, eq=False)
class BodyCells:
    """A body's mesh and the squares of the errors of its cells.

    Attributes:
        name: Name of the body.
        points: Its vertices [m], (n, 2).
        cells: Its cells, (m, 3 or 4).
        sizes: Sizes of the cells [m], (m,).
        errors: ‖e‖² of each cell, (m,).
        largest: Largest new size in each cell's place [m], (m,); infinite where errors decide.
        aspect: Largest length over size of new cells at the vertices [-], (n,) or the same at all.
    """

    name: str
    points: Floats
    cells: Ints
    sizes: Floats
    errors: Floats
    largest: Floats
    aspect: float | Floats = 1.0


@dataclass(frozen=True)
class CellLimits:
    """Limits that a case gives: sizes [m], growth per distance, cells of all meshes together.

    `longest` is the length that flat cells do not exceed [m].
    """

    size_min: float | None
    size_max: float | None
    growth: float
    cells: int
    longest: float = math.inf

    def of(self, body: BodyCells) -> SizeLimits:
        """Limits of one body's cells; without given sizes they follow from its extent."""
        largest = self.size_max or float(np.ptp(body.points, axis=0).max()) / LARGEST
        smallest = self.size_min or largest / SMALLEST
        return SizeLimits(
            smallest,
            max(largest, smallest),
            self.growth,
            self.cells,
            aspect=body.aspect,
            longest=self.longest,
        )


@dataclass(frozen=True)
class Lifetime:
    """How long the meshes have lasted, and may.

    Attributes:
        remeshes: New meshes in this step so far.
        steps_left: Steps to the end.
        life: Steps that a new mesh may last.
        age: Steps on the present meshes.
        gained: Part of the error that these took away when they were made.
    """

    remeshes: int
    steps_left: float
    life: float
    age: float = math.inf
    gained: float = 1.0


@dataclass(frozen=True)
class MeshChoice:
    """Sizes at the vertices by body [m], empty to keep the present meshes, and why."""

    sizes: Mapping[str, Floats]
    reason: str


def choose_meshes(
    bodies: Sequence[BodyCells],
    whole: RelativeError,
    limits: CellLimits,
    policy: MeshPolicy,
    lifetime: Lifetime,
) -> MeshChoice:
    """Keep the meshes of one problem, or replace all that may change.

    What is certain without new sizes is decided without them: they cost more than errors do.

    Args:
        bodies: Meshes that may change.
        whole: Error of all meshes, also of those that may not.
        limits: Limits of the cells.
        policy: When meshes are replaced, and the tolerance.
        lifetime: How long a new mesh may be of use.

    Returns:
        The choice.
    """
    if not whole.error_square > 0.0:
        return MeshChoice({}, "no error")
    report = MeshReport(
        eta=whole.eta,
        cells=sum(len(body.cells) for body in bodies),
        predicted_eta=0.0,
        predicted_cells=0.0,
        remeshes=lifetime.remeshes,
        steps_left=lifetime.steps_left,
        life=lifetime.life,
        age=lifetime.age,
        gained=lifetime.gained,
    )
    if not bodies:
        return MeshChoice({}, "no mesh may change")
    wanted = _wanted(bodies, whole, policy)
    hope = replace(report, predicted_cells=_fewest_cells(bodies, wanted, limits))
    if not isinstance(decision := decide_mesh(hope, policy), Remesh):
        return MeshChoice({}, decision.reason)
    sizes = _sizes(bodies, wanted, limits)
    kept = whole.error_square - sum(float(body.errors.sum()) for body in bodies)
    count = _count(bodies, sizes, limits)
    square = max(kept, 0.0) + sum(
        predicted_error(b.cells, b.sizes, sizes[b.name], b.errors, ORDER) for b in bodies
    )
    expected = RelativeError(square, whole.norm_square + whole.error_square - square)
    decision = decide_mesh(
        replace(
            report,
            predicted_eta=expected.eta,
            predicted_cells=count,
            limited=_limited(bodies, wanted, limits, count),
        ),
        policy,
    )
    return MeshChoice(sizes if isinstance(decision, Remesh) else {}, decision.reason)


def _limited(
    bodies: Sequence[BodyCells],
    wanted: Mapping[str, Floats],
    limits: CellLimits,
    count: float,
) -> bool:
    """Whether there are as many cells as may be, or most of the error is where none is smaller."""
    if count > FULL * limits.cells:
        return True
    smallest = [wanted[body.name] < limits.of(body).smallest for body in bodies]
    there = sum(float(body.errors[s].sum()) for body, s in zip(bodies, smallest, strict=True))
    return there > 0.5 * sum(float(body.errors.sum()) for body in bodies)


def _wanted(
    bodies: Sequence[BodyCells], whole: RelativeError, policy: MeshPolicy
) -> dict[str, Floats]:
    """Sizes in the present cells that distribute the error equally, or smaller where asked for."""
    kept = whole.error_square - sum(float(body.errors.sum()) for body in bodies)
    square = goal(whole, policy.aim * policy.tolerance) - kept
    square = max(square, LEAST_SHARE * goal(whole, policy.tolerance))
    h = np.concatenate([body.sizes for body in bodies])
    e = np.concatenate([body.errors for body in bodies])
    largest = np.concatenate([body.largest for body in bodies])
    new = np.minimum(equal_error_sizes(h, e, square, ORDER), largest)
    ends = np.cumsum([len(body.cells) for body in bodies])[:-1]
    return dict(zip([body.name for body in bodies], np.split(new, ends), strict=True))


def _fewest_cells(
    bodies: Sequence[BodyCells], wanted: Mapping[str, Floats], limits: CellLimits
) -> float:
    """Cells without a limit of their growth: no mesh with the wanted sizes has fewer."""
    count = 0.0
    for body in bodies:
        h, limit = body.sizes, limits.of(body)
        largest = np.minimum(limit.largest, limit.coarsening * h)
        new = np.clip(wanted[body.name], limit.smallest, np.maximum(largest, limit.smallest))
        aspect = np.broadcast_to(limit.aspect, len(body.points))[body.cells].max(axis=1)
        lengths = replace(limit, aspect=aspect).lengths
        count += float(np.sum(h * lengths(h) / (new * lengths(new))))
    return count


def _sizes(
    bodies: Sequence[BodyCells], wanted: Mapping[str, Floats], limits: CellLimits
) -> dict[str, Floats]:
    """Nodal sizes within the limits, of each mesh and of all together."""
    fields = {
        b.name: size_field(b.points, b.cells, b.sizes, wanted[b.name], limits.of(b)) for b in bodies
    }
    scale = max(1.0, float(np.sqrt(_count(bodies, fields, limits) / limits.cells)))
    return {name: rounded(scale * sizes) for name, sizes in fields.items()}


def _count(bodies: Sequence[BodyCells], sizes: Mapping[str, Floats], limits: CellLimits) -> float:
    """Cells of all meshes with these sizes at the vertices."""
    return sum(predicted_cells(b.points, b.cells, sizes[b.name], limits.of(b)) for b in bodies)
