"""Factors that serve on: the same answers and the same iterations as without."""

from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.results.data import InterfaceTable, RunResult
from contactfem.run.driver import run_case
from contactfem.solvers import choice as linear_solver

CASES = Path(__file__).parents[2] / "cases"
AMPLIFIED = 100.0  # what a residual is worth in displacements where a body is slender or stiff
QUICK = {  # what runs without being asked for: one of each kind
    ("beam_on_stop", "free"), ("block", "coarse"), ("friction_bar", "pulled"),
    ("friction_states", None), ("friction_states", "exceeded"), ("hertz", None),
    ("patch", "held_ends"), ("patch", "stiff_mortar"), ("shrink_fit", "coarse"),
    ("spheres", "light"), ("westergaard", "coarser"),
}  # fmt: skip


def small_strain() -> list[object]:
    """All cases and variants of small strain with eliminated multipliers."""
    found = []
    for path in sorted(CASES.glob("*.toml")):
        for name in (None, *read_case(path).variants):
            case = read_case(path, variant=name)
            if case.mechanics and case.strain == "small" and case.solver.system == "condensed":
                marks = [] if (path.stem, name) in QUICK else [pytest.mark.slow]
                found.append(pytest.param(path.stem, name, marks=marks, id=f"{path.stem}-{name}"))
    return found


def solve(stem: str, variant: str | None, *overrides: str) -> RunResult:
    case = read_case(CASES / f"{stem}.toml", overrides, variant)
    return run_case(case, MPI.COMM_SELF, None)


@pytest.mark.parametrize(("stem", "variant"), small_strain())
@pytest.mark.timeout(900)
def test_a_linear_bulk_is_factorised_once(stem: str, variant: str | None) -> None:
    once, each = solve(stem, variant), solve(stem, variant, "solver.reuse=false")
    assert len(once.steps) == len(each.steps)
    for one, other in zip(once.steps, each.steps, strict=True):
        # a node without force may take one iteration for its status, which is round-off then
        assert abs(one.iterations - other.iterations) <= 1
    # where round-off stops Newton's method early, answers cannot agree better than residuals do
    reached = max(step.residuals[-1] for run in (once, each) for step in run.steps)
    assert_same(once, each, max(1e-10, AMPLIFIED * reached))


@pytest.mark.parametrize(
    ("stem", "variant", "overrides"),
    [
        ("ironing", "pressed", ["time.end='0.3 s'"]),
        ("ironing", None, ["time.end='1.05 s'", "time.step='0.025 s'"]),
    ],
    ids=["pressed", "drawn"],
)
def test_an_old_factor_leads_to_the_same(
    monkeypatch: pytest.MonkeyPatch, stem: str, variant: str | None, overrides: list[str]
) -> None:
    monkeypatch.setattr(linear_solver, "FEWEST", 0)
    old, each = (
        solve(stem, variant, *overrides),
        solve(stem, variant, "solver.reuse=false", *overrides),
    )
    assert old.timings["factorisation"] > 0.0
    assert "contact.pattern" not in old.timings  # it went the other way
    assert [s.dt for s in old.steps] == [s.dt for s in each.steps]
    assert_same(old, each, 1e-8)


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("stem", "variant", "overrides"),
    [("block", "coarse", []), ("hertz", None, []), ("ironing", "pressed", ["time.end='0.3 s'"])],
    ids=["block", "hertz", "ironing"],
)
def test_on_all_ranks(
    monkeypatch: pytest.MonkeyPatch, stem: str, variant: str | None, overrides: list[str]
) -> None:
    """Ranks condense their own cells and share what is between them."""
    monkeypatch.setattr(linear_solver, "FEWEST", 0)
    case = read_case(CASES / f"{stem}.toml", overrides, variant)
    plain = read_case(CASES / f"{stem}.toml", [*overrides, "solver.reuse=false"], variant)
    together, each = (run_case(c, MPI.COMM_WORLD, None) for c in (case, plain))
    alone = run_case(case, MPI.COMM_SELF, None)
    assert "contact.pattern" not in together.timings  # it went the other way
    assert "contact.pattern" in each.timings
    if MPI.COMM_WORLD.rank == 0:  # which has the pictures
        assert_same(together, each, 1e-8)
    for one, other in zip(together.steps, alone.steps, strict=True):
        assert one.iterations == other.iterations
        size = np.hypot(*other.forces["sole" if stem != "hertz" else "contact"])
        for name, force in other.forces.items():
            assert np.abs(np.subtract(one.forces[name], force)).max() <= 1e-9 * size


def assert_same(a: RunResult, b: RunResult, tolerance: float) -> None:
    """Displacements, contact forces of the nodes, resultants of all steps and reactions agree."""
    size = max(abs(body.displacement).max() for body in b.bodies)
    for one, other in zip(a.bodies, b.bodies, strict=True):
        assert abs(one.displacement - other.displacement).max() <= tolerance * size
    size = max(largest_force(run) for run in (a, b))
    for one, other in zip(a.interfaces, b.interfaces, strict=True):
        for forces in (nodal_forces(one, k) - nodal_forces(other, k) for k in (0, 1)):
            assert np.abs(forces).max() <= tolerance * size
    for one, other in zip(a.steps, b.steps, strict=True):
        for name, force in other.forces.items():
            assert np.abs(np.subtract(one.forces[name], force)).max() <= tolerance * size
    for name, value in b.reactions.items():
        assert abs(a.reactions[name][0] - value[0]) <= tolerance * size


def nodal_forces(table: InterfaceTable, component: int) -> np.ndarray:
    """Normal or tangential force of every nonmortar node."""
    stress = (table.pressure, table.traction)[component]
    return np.nan_to_num(stress) * table.coverage * table.facet_length * table.depth


def largest_force(run: RunResult) -> float:
    """Largest of the reactions and of the nodal contact forces summed without sign."""
    nodal = [float(np.abs(nodal_forces(table, 0)).sum()) for table in run.interfaces]
    return max([abs(value[0]) for value in run.reactions.values()] + nodal)
