"""The cost of the solve phase in units of what one plain iteration must cost, in CPU seconds.

    ./run python3 tests/benchmarks/solve_phase.py [NAME ...]        (all of RUNS if none is given)

Every run is done three times with reused factors and three times without, by turns; rows are
medians. A unit is one assembly and one factorisation of the run without. Steps count from the first
one in contact; the last ten, in which the ironing's die is drawn, are shown as well. Seconds are
those of the processor, so that others on the machine count little; they are those of one thread, so
this is for one rank.
"""

import statistics
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.results.data import RunResult, StepReport
from contactfem.run.driver import run_case


class Clock:
    """CPU seconds of this thread without those of looking at the clock, which may be 0.1 ms."""

    def __init__(self) -> None:
        looks = [time.thread_time() for _ in range(2001)]
        self._cost, self._looks = (looks[-1] - looks[0]) / 2000, 0

    def __call__(self) -> float:
        """Seconds."""
        self._looks += 1
        return time.thread_time() - self._looks * self._cost


time.perf_counter = Clock()  # what all timers look at
CASES = Path(__file__).parents[2] / "cases"
REPEATS = 3


def block(n: int) -> tuple[str, list[str]]:
    """The block with n by n cells."""
    return "block", [f"bodies.block.mesh.nx={n}", f"bodies.block.mesh.ny={n}"]


def hertz(cylinder: str, growth: str, size: str) -> tuple[str, list[str]]:
    """Hertz's contact with facets of these sizes."""
    changes = [f"bodies.cylinder.mesh.size='{cylinder}'", f"bodies.block.mesh.size='{size}'"]
    return "hertz", changes + [f"bodies.{b}.mesh.growth={growth}" for b in ("cylinder", "block")]


def ironing(factor: float, end: float) -> tuple[str, list[str]]:
    """The ironing in its own steps, with cells that are finer by a factor; drawn from 1 s on."""
    counts = {"slab.mesh.nx": 120, "slab.mesh.ny": 20, "die.mesh.n_arc": 12, "die.mesh.n_side": 8}
    changes = [f"bodies.{key}={round(factor * n)}" for key, n in counts.items()]
    return "ironing", [*changes, f"time.end='{end} s'"]


RUNS = {
    "block-2e4": block(100),
    "block-1e5": block(223),
    "hertz-2e4": hertz("0.066 mm", "0.051", "0.08 mm"),
    "hertz-1e5": hertz("0.0295 mm", "0.0232", "0.0355 mm"),
    "ironing-2e4": ironing(2.0, 1.05),
    "ironing-1e5": ironing(4.5, 0.3),
}


def run(case: str, changes: list[str]) -> RunResult:
    """One run without output."""
    return run_case(read_case(CASES / f"{case}.toml", changes), MPI.COMM_SELF, None)


def in_contact(result: RunResult) -> Sequence[StepReport]:
    """Steps from the first one in contact."""
    first = next(k for k, step in enumerate(result.steps) if step.stick + step.slip > 0)
    return result.steps[first:]


def iterations(steps: Sequence[StepReport]) -> float:
    """Their mean."""
    return statistics.fmean(step.iterations for step in steps)


def seconds(steps: Sequence[StepReport]) -> float:
    """Their mean."""
    return statistics.fmean(step.wall for step in steps)


def numbers(reused: RunResult, plain: RunResult) -> dict[str, float]:
    """What one pair of runs says."""
    bare, count = plain.timings, plain.sizes["factorisations"]
    factorisation, assembly = bare["factorisation"] / count, bare["assembly"] / count
    unit = factorisation + assembly
    steps, plain_steps = in_contact(reused), in_contact(plain)
    return {
        "unknowns": reused.sizes["unknowns"],
        "unit [s]": unit,
        "steps in contact": len(steps),
        "iterations": iterations(steps),
        "iterations, plain": iterations(plain_steps),
        "factorisations": reused.sizes["factorisations"],
        "factorisations, plain": count,
        "solve phase / factorisations": reused.timings["newton"] / factorisation,
        "step / units": seconds(steps) / unit,
        "step / units, plain": seconds(plain_steps) / unit,
        "last ten / units": seconds(steps[-10:]) / unit,
        "last ten / units, plain": seconds(plain_steps[-10:]) / unit,
        "contact's share, plain": bare["contact"] / bare["newton"],
    }


def main(names: list[str]) -> None:
    """Print the medians of some runs."""
    for name in names or RUNS:
        case, changes = RUNS[name]
        found = [
            numbers(run(case, changes), run(case, [*changes, "solver.reuse=false"]))
            for _ in range(REPEATS)
        ]
        print(name)
        for key in found[0]:
            values = [row[key] for row in found]
            spread = f"{min(values):.4g} to {max(values):.4g}"
            print(f"    {key:30s} {statistics.median(values):10.4g}   ({spread})", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
