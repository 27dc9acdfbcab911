"""Every difficult scene ends as it should: right, or in an error where there is no answer."""

from pathlib import Path

import pytest

from contactfem.case.read import read_case
from contactfem.study.suite import judged

HARD = Path(__file__).parents[2] / "cases" / "hard"
SLOW = {("long_steps", "usual")}  # more than 10 s


def marks(key: tuple[str, str | None]) -> list[pytest.MarkDecorator]:
    """Mark what takes long."""
    return [pytest.mark.slow] if key in SLOW else []


RUNS = [
    pytest.param(path.stem, name, marks=marks((path.stem, name)))
    for path in sorted(HARD.glob("*.toml"))
    for name in (None, *read_case(path).variants)
]


@pytest.mark.parametrize(("stem", "variant"), RUNS)
def test_hard_case(stem: str, variant: str | None) -> None:
    row = judged(read_case(HARD / f"{stem}.toml", variant=variant), stem)
    assert row.passed, "\n".join(row.missed)
