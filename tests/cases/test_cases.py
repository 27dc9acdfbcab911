"""Every case file and every variant of it meets what it expects."""

from pathlib import Path

import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.results.expectations import judge, measure
from contactfem.run.driver import run_case

CASES = Path(__file__).parents[2] / "cases"
SLOW = {  # variants that take long, None for the case itself; all where none is named
    "barber": (),
    "block": ("ten_steps",),
    "efficiency": (None,),
    "hertz": ("large",),
    "ironing": (),
    "sliding_block": ("large",),
    "sphere3d": ("fine",),
    "tire": (),
    "tire_small": (),  # verification/test_tire.py runs it
}


def marks(stem: str, variant: str | None) -> list[pytest.MarkDecorator]:
    """Mark what only runs when it is asked for."""
    slow = stem in SLOW and (not SLOW[stem] or variant in SLOW[stem])
    return [pytest.mark.slow] if slow else []


RUNS = [
    pytest.param(path.stem, name, marks=marks(path.stem, name))
    for path in sorted(CASES.glob("*.toml"))
    for name in (None, *read_case(path).variants)
]


@pytest.mark.parametrize(("stem", "variant"), RUNS)
def test_case(stem: str, variant: str | None) -> None:
    case = read_case(CASES / f"{stem}.toml", variant=variant)
    result = run_case(case, MPI.COMM_SELF, None)
    missed = [
        f"{verdict.key} = {verdict.value:.9g} {verdict.unit}, "
        f"allowed {verdict.low:.9g} to {verdict.high:.9g}"
        for verdict in judge(case, measure(result))
        # what a run cost belongs to benchmarks, not to tests
        if not verdict.passed and not verdict.key.startswith("cost.")
    ]
    assert not missed, "\n".join(missed)
    assert result.converged or "converged" in case.expect, result.message
