"""Every difficult scene ends as it should: right, or in an error where there is no answer."""

from pathlib import Path

import pytest

from contactfem.case import read_case
from contactfem.suite import judged

HARD = Path(__file__).parents[2] / "cases" / "hard"
SLOW = {("long_steps", "usual")}  # more than 10 s
ONE_SIDED = "normals of one side break the symmetry"
OPEN = {  # what the solver does not do yet; the expectation is the right answer all the same
    ("mortar_finer", "nonmortar_finer"): "corners of a coarse mortar side press into a fine one",
    ("self_contact", None): ONE_SIDED,
    ("self_contact", "lower_nonmortar"): ONE_SIDED,
}


def marks(key: tuple[str, str | None]) -> list[pytest.MarkDecorator]:
    """Mark what takes long, and what is known to miss."""
    slow = [pytest.mark.slow] if key in SLOW else []
    return slow + ([pytest.mark.xfail(reason=OPEN[key], strict=True)] if key in OPEN else [])


RUNS = [
    pytest.param(path.stem, name, marks=marks((path.stem, name)))
    for path in sorted(HARD.glob("*.toml"))
    for name in (None, *read_case(path).variants)
]


@pytest.mark.parametrize(("stem", "variant"), RUNS)
def test_hard_case(stem: str, variant: str | None) -> None:
    row = judged(read_case(HARD / f"{stem}.toml", variant=variant), stem)
    assert row.passed, "\n".join(row.missed)
