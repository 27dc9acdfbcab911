"""Python that a case runs: functions named "file.py:function"."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from contactfem.common.text import one_line
from contactfem.common.user_function import is_reference
from contactfem.errors import CaseError

if TYPE_CHECKING:
    from contactfem.case.schema import Case

WORDS = ("title", "references", "expect", "variants")  # keys whose texts name nothing


def python_code(case: Case) -> Iterator[tuple[str, str]]:
    """Key and name of every function of a file that a run of the case calls.

    Args:
        case: The case.
    """
    for key, value in case.contents.items():
        if key not in WORDS:
            yield from _references(key, value)


def refuse_code(case: Case) -> None:
    """Make sure that a case runs no Python of its own.

    Raises:
        CaseError: It does; a line for each function.
    """
    found = [
        f"{case.path}: {key} = {name}: runs Python; --no-code refuses it"
        for key, name in python_code(case)
    ]
    if found:
        raise CaseError("\n".join(one_line(line) for line in found))


def _references(key: str, value: Any) -> Iterator[tuple[str, str]]:
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from _references(f"{key}.{name}", inner)
    elif isinstance(value, list | tuple):
        for number, inner in enumerate(value):
            yield from _references(f"{key}.{number}", inner)
    elif is_reference(value):
        yield key, str(value)
