"""Find conditions that cannot hold together."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from contactfem.meshes import MeshFile

if TYPE_CHECKING:
    from contactfem.case.scene import Condition
    from contactfem.case.schema import Case

SAME_POINT = 1e-9  # relative to the body's size


def contradictions(case: Case) -> Iterator[str]:
    """Pairs of conditions that contradict one another.

    Args:
        case: the case; all names in it exist.

    Yields:
        One line "dotted.key: what is wrong" for each pair.
    """
    holding = [
        (number, condition)
        for number, condition in enumerate(case.conditions)
        if condition.kind in ("displacement", "grip")
    ]
    for (i, first), (j, second) in combinations(holding, 2):
        if first.body != second.body:
            continue
        if first.on == second.on and first.at is None and second.at is None:
            yield from _same_surface(i, first, j, second)
        elif (place := _common_point(case, first, second)) is not None:
            yield from _same_point(i, first, j, second, place)


def _same_surface(i: int, first: Condition, j: int, second: Condition) -> Iterator[str]:
    if "grip" in (first.kind, second.kind):
        yield f"conditions.{j}.{second.kind}: conditions.{i} holds '{first.on}' by a {first.kind}"
        return
    for axis in sorted(first.components().keys() & second.components().keys()):
        yield (
            f"conditions.{j}.displacement.{axis}: conditions.{i} prescribes {axis} on "
            f"'{first.on}' already"
        )


def _same_point(
    i: int, first: Condition, j: int, second: Condition, place: tuple[float, ...]
) -> Iterator[str]:
    where = f"at their common point ({', '.join(f'{x:g}' for x in place)}) m"
    a, b = first.components(), second.components()
    for axis in sorted(a.keys() & b.keys()):
        if a[axis] != b[axis]:
            yield f"conditions.{j}: prescribes another {axis} than conditions.{i} {where}"
    for free, held in ((first, b), (second, a)):
        loaded = set(free.grip.force) if free.grip is not None else set()
        for axis in sorted(loaded & held.keys()):
            yield f"conditions.{j}: a grip that is free in {axis} is held {where} (conditions.{i})"


def _common_point(case: Case, first: Condition, second: Condition) -> tuple[float, ...] | None:
    """A point that two conditions on one body share; only known where no file is to be read."""
    mesh = case.bodies[first.body].mesh
    if isinstance(mesh, MeshFile):
        return None
    outline = mesh.outline()
    points = [
        np.array([each.at]) if each.at is not None else outline[each.surface or ""]
        for each in (first, second)
    ]
    distance = np.linalg.norm(points[0][:, None] - points[1][None], axis=2)
    size = float(np.linalg.norm(mesh.extent()[1] - mesh.extent()[0]))
    a, b = np.unravel_index(np.argmin(distance), distance.shape)
    if distance[a, b] > SAME_POINT * size:
        return None
    return tuple(float(x) for x in points[0][a])
