"""Whether the meshes of one problem are replaced, and by which sizes: from the errors of cells."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from contactfem.adaptivity import MeshPolicy, MeshReport, Remesh, decide_mesh
from contactfem.recovery import Floats, Ints
from contactfem.relative_error import RelativeError
from contactfem.sizes import (
    Prediction,
    SizeLimits,
    equal_error_sizes,
    goal,
    predict,
    predicted_cells,
    rounded,
    size_field,
)

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
    """

    name: str
    points: Floats
    cells: Ints
    sizes: Floats
    errors: Floats
    largest: Floats


@dataclass(frozen=True)
class CellLimits:
    """Limits that a case gives: sizes [m], growth per distance, cells of all meshes together."""

    size_min: float | None
    size_max: float | None
    growth: float
    cells: int

    def of(self, points: Floats) -> SizeLimits:
        """Limits of one body's cells; without given sizes they follow from its extent."""
        largest = self.size_max or float(np.ptp(points, axis=0).max()) / LARGEST
        smallest = self.size_min or largest / SMALLEST
        return SizeLimits(smallest, max(largest, smallest), self.growth, self.cells)


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
    found = [predict(b.points, b.cells, sizes[b.name], b.errors, ORDER) for b in bodies]
    square = max(kept, 0.0) + sum(part.error_square for part in found)
    expected = RelativeError(square, whole.norm_square + whole.error_square - square)
    decision = decide_mesh(
        replace(
            report,
            predicted_eta=expected.eta,
            predicted_cells=sum(part.cells for part in found),
            limited=_limited(bodies, wanted, limits, found),
        ),
        policy,
    )
    return MeshChoice(sizes if isinstance(decision, Remesh) else {}, decision.reason)


def _limited(
    bodies: Sequence[BodyCells],
    wanted: Mapping[str, Floats],
    limits: CellLimits,
    found: Sequence[Prediction],
) -> bool:
    """Whether there are as many cells as may be, or most of the error is where none is smaller."""
    if sum(part.cells for part in found) > FULL * limits.cells:
        return True
    smallest = [wanted[body.name] < limits.of(body.points).smallest for body in bodies]
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
        h, limit = body.sizes, limits.of(body.points)
        largest = np.minimum(limit.largest, limit.coarsening * h)
        new = np.clip(wanted[body.name], limit.smallest, np.maximum(largest, limit.smallest))
        count += float(np.sum((h / new) ** 2))
    return count


def _sizes(
    bodies: Sequence[BodyCells], wanted: Mapping[str, Floats], limits: CellLimits
) -> dict[str, Floats]:
    """Nodal sizes within the limits, of each mesh and of all together."""
    fields = {
        b.name: size_field(b.points, b.cells, wanted[b.name], limits.of(b.points)) for b in bodies
    }
    count = sum(predicted_cells(b.points, b.cells, fields[b.name]) for b in bodies)
    scale = max(1.0, float(np.sqrt(count / limits.cells)))
    return {name: rounded(scale * sizes) for name, sizes in fields.items()}
