"""Judge the numbers measured on a run against what its case expects."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from contactfem.common.text import one_line, similar
from contactfem.errors import CaseError
from contactfem.results.measures import measurable, measure

if TYPE_CHECKING:
    from contactfem.case.schema import Case
    from contactfem.case.settings import Expectation

__all__ = ["Verdict", "check_names", "judge", "measure"]


@dataclass(frozen=True)
class Verdict:
    """One expectation and what became of it.

    Attributes:
        key: name of the number.
        unit: its SI unit.
        value: what was measured [unit].
        low: smallest value allowed [unit].
        high: largest value allowed [unit].
        passed: whether the value lies between them.
    """

    key: str
    unit: str
    value: float
    low: float
    high: float
    passed: bool


def check_names(case: Case) -> None:
    """Make sure that all that the case expects and studies can be measured, before it is run.

    Args:
        case: the case.

    Raises:
        CaseError: if it names a number that no run of it measures.
    """
    known = measurable(case)
    named = [("expect", key) for key in case.expect]
    if case.study is not None:
        named.append(("study", case.study.error or case.study.quantity or ""))
    for table, key in named:
        if key not in known:
            raise CaseError(
                f"{case.path}: {table}: nothing measures '{one_line(key)}'{similar(key, known)}"
            )


def _bounds(expectation: Expectation) -> tuple[float, float]:
    if expectation.value is not None:
        room = (expectation.abs or 0.0) + (expectation.rel or 0.0) * abs(expectation.value)
        return expectation.value - room, expectation.value + room
    low = -math.inf if expectation.min is None else expectation.min
    return low, math.inf if expectation.max is None else expectation.max


def judge(case: Case, values: Mapping[str, float]) -> list[Verdict]:
    """Judge measured numbers against what the case expects.

    Args:
        case: the case.
        values: measured numbers [SI].

    Returns:
        A verdict per expectation; a number that could not be measured misses.

    Raises:
        CaseError: if it expects a number that no run of it measures.
    """
    check_names(case)
    units = measurable(case)
    verdicts = []
    for key, expectation in case.expect.items():
        low, high = _bounds(expectation)
        value = values.get(key, math.nan)
        verdicts.append(Verdict(key, units[key], value, low, high, low <= value <= high))
    return verdicts
