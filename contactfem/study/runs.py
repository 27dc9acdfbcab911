"""Families of runs of one case, finer from level to level."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

from contactfem.case.read import read_case
from contactfem.case.schema import Case
from contactfem.errors import CaseError
from contactfem.study.refinement import What, refinement

CASE_ITSELF = "base"  # as a variant
OPENING, CLOSING, QUOTES = "[{", "]}", "\"'"


@dataclass(frozen=True)
class Curve:
    """Runs that differ in nothing but how fine they are.

    Attributes:
        label: what tells it from others; empty if there are no others.
        variant: name of a variant, or None for the case itself.
        overrides: "a.b.c=value" each.
        ranks: number of processes.
    """

    label: str
    variant: str | None
    overrides: tuple[str, ...]
    ranks: int = 1


@dataclass(frozen=True)
class Member:
    """One run of a family.

    Attributes:
        curve: where it belongs.
        level: its place there, from 0.
        factor: how many times finer than the first it is.
        overrides: all changes of the case file, "a.b.c=value" each.
        mechanics: whether it solves for displacements.
        problem: why it cannot be run, else empty.
    """

    curve: Curve
    level: int
    factor: float
    overrides: tuple[str, ...] = ()
    mechanics: bool = True
    problem: str = ""


def values_of(text: str) -> list[str]:
    """Parts of a text between its commas, except those inside brackets and quotes."""
    parts, depth, quote = [""], 0, ""
    for letter in text:
        if quote:
            quote = "" if letter == quote else quote
        elif letter in QUOTES:
            quote = letter
        depth += (letter in OPENING) - (letter in CLOSING) if not quote else 0
        if letter == "," and not depth and not quote:
            parts.append("")
        else:
            parts[-1] += letter
    return [part.strip() for part in parts]


def curves(base: Curve, variations: Sequence[str], ranks: Sequence[int]) -> list[Curve]:
    """All combinations of varied values and numbers of ranks.

    Args:
        base: what all have in common.
        variations: "a.b.c=v1,v2" each; "variant=v1,v2" takes variants, "base" the case itself.
        ranks: numbers of processes.

    Returns:
        The curves; the first value of a variation comes first, the last variation varies fastest.

    Raises:
        CaseError: a variation that is not of this form.
    """
    choices = [_choices(text) for text in variations]
    found = []
    for chosen in product(*choices):
        curve = base
        for key, value in chosen:
            curve = _with(curve, key, value)
        for count in ranks:
            words = f"{count} rank{'s' * (count > 1)}" if len(ranks) > 1 else ""
            label = ", ".join(word for word in (curve.label, words) if word)
            found.append(replace(curve, label=label, ranks=count))
    return found


def _choices(text: str) -> list[tuple[str, str]]:
    """Pairs of key and value that a variation stands for."""
    key, sign, values = text.partition("=")
    if not sign or not key.strip() or not all(parts := values_of(values)):
        raise CaseError(f"--vary {text}: must be of the form a.b.c=v1,v2 or variant=v1,v2")
    return [(key.strip(), part) for part in parts]


def _with(curve: Curve, key: str, value: str) -> Curve:
    """Curve with a value changed and named."""
    plain = value.strip(QUOTES)
    words = plain if key == "variant" else f"{key.rpartition('.')[2]} = {plain}"
    label = f"{curve.label}, {words}" if curve.label else words
    if key == "variant":
        return replace(curve, label=label, variant=None if plain == CASE_ITSELF else plain)
    return replace(curve, label=label, overrides=(*curve.overrides, f"{key}={value}"))


def members(path: Path, curve: Curve, levels: int, what: Collection[What]) -> list[Member]:
    """The runs of a curve, each twice as fine as the one before.

    Args:
        path: the case file.
        curve: the curve.
        levels: how many.
        what: what becomes finer.

    Returns:
        The runs; those that the case file does not allow say why.
    """
    found = []
    for level in range(levels):
        member = Member(curve, level, 2.0**level, curve.overrides)
        try:
            case = read_case(path, curve.overrides, curve.variant)
            found.append(_finer(member, case, what))
        except CaseError as error:
            found.append(replace(member, problem=str(error)))
    return found


def _finer(member: Member, case: Case, what: Collection[What]) -> Member:
    """A run with the changes of its level."""
    changes = refinement(case, member.factor, what) if member.level else []
    overrides = (*member.overrides, *changes)
    return replace(member, overrides=overrides, mechanics=case.mechanics)
