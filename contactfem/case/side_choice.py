"""Choice of the nonmortar side of interfaces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from contactfem.case.base import AXES
from contactfem.case.body_meshes import built_mesh
from contactfem.case.cell_materials import surface_modulus
from contactfem.common.text import nearest
from contactfem.errors import CaseError
from contactfem.geometry.side_comparison import Facets, compare

if TYPE_CHECKING:
    from contactfem.case.schema import Case

FINER = 1.5  # mortar facets over nonmortar ones from which pressures show the mortar side's corners
SAME = 1.01  # ratio of sizes or moduli up to which two sides are alike


@dataclass(frozen=True)
class Difference:
    """How two sides differ.

    Attributes:
        ratio: Size of the second one's facets over that of the first one's [-].
        stiffer: Young's modulus of the second one over that of the first one [-].
        overhang: Number of ends at which the first one overhangs, less those of the second.
    """

    ratio: float
    stiffer: float
    overhang: int


def with_provisional_sides(case: Case) -> Case:
    """Case in which every interface has two sides, an obstacle as the mortar one.

    Args:
        case: The case, as read.
    """
    interfaces = dict(case.interfaces)
    for name, given in case.interfaces.items():
        if given.between is not None:
            first, second = given.between
            if first in case.obstacles:
                first, second = second, first
            interfaces[name] = given.with_sides(first, second, "")
    return case.model_copy(update={"interfaces": interfaces})


def with_chosen_sides(case: Case) -> Case:
    """Case in which interfaces that only say `between` have their nonmortar side chosen.

    Args:
        case: The case with provisional sides; its names are right.

    Raises:
        CaseError: A mesh or a surface that is not there, or two sides that are both the nonmortar
            side of another interface.
    """
    taken = {i.nonmortar: name for name, i in case.interfaces.items() if i.between is None}
    interfaces = dict(case.interfaces)
    for name, given in case.interfaces.items():
        if given.between is not None:
            nonmortar, mortar, why = _chosen(case, name, taken)
            taken[nonmortar] = name
            interfaces[name] = given.with_sides(nonmortar, mortar, why)
    return case.model_copy(update={"interfaces": interfaces})


def difference(case: Case, first: str, second: str) -> Difference:
    """Compare two surfaces "body.surface" of the input meshes.

    Args:
        case: The case.
        first: One surface.
        second: The other one.

    Raises:
        CaseError: A body that cannot be meshed, or a surface that is not there.
    """
    sides: list[Facets] = []
    moduli: list[float] = []
    for on in (first, second):
        body, _, surface = on.partition(".")
        data = built_mesh(case, body, "mesh")
        if not len(data.groups.get(surface, ())):
            known = nearest(surface, list(data.groups)) or "; it has no named surfaces"
            raise CaseError(f"= {on}: '{body}' has no surface '{surface}' with facets{known}")
        found = data.surface(surface)
        sides.append(Facets(found.X, found.facets))
        moduli.append(surface_modulus(case, body, surface, data))
    compared = compare(sides[0], sides[1])
    overhang = compared.first_overhangs - compared.second_overhangs
    return Difference(compared.ratio, moduli[1] / moduli[0], overhang)


def _chosen(case: Case, name: str, taken: dict[str, str]) -> tuple[str, str, str]:
    """Nonmortar side, mortar side, and why."""
    sides = case.interfaces[name]
    key = f"{case.path}: interfaces.{name}.between"
    if sides.mortar in case.obstacles:
        if (other := taken.get(sides.nonmortar)) is not None:
            raise CaseError(
                f"{key}: {sides.nonmortar} is the nonmortar side of '{other}' already, and an "
                "obstacle can only be the mortar side"
            )
        return sides.nonmortar, sides.mortar, "an obstacle is always the mortar side"
    first, second = sorted((sides.nonmortar, sides.mortar))
    if first in taken and second in taken:
        raise CaseError(
            f"{key}: {first} is the nonmortar side of '{taken[first]}' already, and {second} that "
            f"of '{taken[second]}'"
        )
    try:
        found = difference(case, first, second)
    except CaseError as error:
        text = str(error)
        raise CaseError(f"{key} {text}" if text.startswith("=") else text) from None
    for lead, why in _reasons(case, taken, first, second, found):
        if lead:
            return (first, second, why) if lead > 0 else (second, first, why)
    return first, second, "both sides are alike; it is the first by name"


def _reasons(
    case: Case, taken: dict[str, str], first: str, second: str, found: Difference
) -> Iterator[tuple[int, str]]:
    """Reasons by weight: 1 if one speaks for the first side, -1 for the second, 0 for neither."""
    lead = (second in taken) - (first in taken)
    other = second if lead > 0 else first
    yield lead, f"{other} is the nonmortar side of '{taken.get(other)}' already"
    held = {side: _prescribed(case, side) for side in (first, second)}
    lead = (held[second] > held[first]) - (held[first] > held[second])
    yield lead, f"the motion of {second if lead > 0 else first} is prescribed"
    lead = (found.overhang < 0) - (found.overhang > 0)
    yield lead, f"{second if lead > 0 else first} extends beyond its ends"
    coarser = max(found.ratio, 1.0 / found.ratio)
    softer = max(found.stiffer, 1.0 / found.stiffer)
    by_size = 1 if found.ratio < 1.0 else -1
    by_modulus = 1 if found.stiffer > 1.0 else -1
    large = f"its facets are {coarser:.3g} times as large"
    yield by_size if coarser >= FINER else 0, large
    yield by_modulus if softer > SAME else 0, f"its material is {softer:.3g} times as soft"
    yield by_size if coarser > SAME else 0, f"its facets are {coarser:.3g} times as large"


def _prescribed(case: Case, on: str) -> int:
    """Number of components of a surface's motion that a condition prescribes."""
    axes: set[str] = set()
    for condition in case.conditions:
        if condition.on == on and condition.at is None:
            if condition.kind == "grip":
                axes |= set(AXES[: case.axes])
            elif condition.kind == "displacement":
                axes |= set(condition.components())
    return len(axes)
