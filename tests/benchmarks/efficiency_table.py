"""Tables of docs/adaptivity.md: efficiency indices over tolerances, and uniform meshes beside.

./run python3 tests/benchmarks/efficiency_table.py [tolerances in percent]
"""

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from verification.efficiency import Efficiency
from verification.watched import watch

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.run.driver import run_case
from contactfem.verification.manufactured import MovingGaussian

CASE = Path(__file__).parents[2] / "cases" / "efficiency.toml"
END = 0.1  # s, a tenth of a turn
SPOT = MovingGaussian(0.2, 2.0)
STEP = 0.1  # s, that an error of 100 % in time would belong to, about


def case_of(tolerance, *overrides):
    given = [f'time.end="{END} s"', f"adaptivity.tolerance={tolerance}", "expect={}"]
    return read_case(CASE, [*given, *overrides])


def constant_steps(tolerance):
    """Overrides that leave the steps, whose error is then about the tolerance."""
    step = STEP * tolerance
    steps = [f'time.{key}="{step} s"' for key in ("step", "step_min", "step_max")]
    return [*steps, "adaptivity.time=0.999"]


def indices(case):
    """Indicated over true errors in space and time, of the whole run, and the extremes."""
    seen = Efficiency(SPOT, 2.0)
    watch(case, seen)
    result = []
    for pairs in (seen.space, seen.time):
        indicated, true = np.array(pairs).T
        known = np.isfinite(indicated)
        ratio = indicated[known] / true[known]
        whole = np.sqrt(np.sum(indicated[known] ** 2) / np.sum(true[known] ** 2))
        result.append((whole, ratio.min(), ratio.max(), indicated[known].max(), true[known].max()))
    return result, seen


def timed(case):
    start = time.perf_counter()
    result = run_case(case, MPI.COMM_SELF, None)
    assert result.converged
    return time.perf_counter() - start


def uniform(tolerance, aim):
    """Case with a uniform mesh and steps that reach the errors `aim` in space and time."""

    def given(n, step):
        steps = [f'time.{key}="{step} s"' for key in ("step", "step_min", "step_max")]
        mesh = [f"bodies.plate.mesh.n{axis}={n}" for axis in "xy"]
        shape = ['bodies.plate.mesh.cell="triangle"', 'bodies.plate.mesh.pattern="alternating"']
        return case_of(tolerance, "adaptivity=false", *steps, *mesh, *shape)

    trial = Efficiency(SPOT, 2.0)
    watch(given(60, END / 50), trial)  # with little error in time
    n = int(np.ceil(60 * max(pair[1] for pair in trial.space) / aim[0]))
    step = END / np.ceil(END / (STEP * aim[1] / 0.8))
    return given(n, step)


def main(tolerances):
    for tolerance in tolerances:
        for name, overrides in (("constant", constant_steps(tolerance)), ("adaptive", [])):
            (space, rate), seen = indices(case_of(tolerance, *overrides))
            print(
                f"{100 * tolerance:4.0f} % {name:8s} steps {len(seen.t):4d}, "
                f"cells {min(seen.cells)} to {max(seen.cells)}, "
                f"space {space[0]:.3f} ({space[1]:.3f} to {space[2]:.3f}; true {space[4]:.4f}), "
                f"time {rate[0]:.3f} ({rate[1]:.3f} to {rate[2]:.3f}; true {rate[4]:.4f}), "
                f"space-time unknowns {sum(seen.vertices)}",
                flush=True,
            )
        even = uniform(tolerance, (space[4], rate[4]))
        there = Efficiency(SPOT, 2.0)
        watch(even, there)
        seconds = [timed(case) for case in (case_of(tolerance), even)]
        print(
            f"{100 * tolerance:4.0f} % uniform  steps {len(there.t):4d}, cells {there.cells[0]}, "
            f"true {max(pair[1] for pair in there.space):.4f} and "
            f"{max(pair[1] for pair in there.time):.4f}, "
            f"space-time unknowns {sum(there.vertices)}, "
            f"{sum(there.vertices) / sum(seen.vertices):.2f} times the adaptive ones; "
            f"{seconds[1]:.1f} s, adaptive {seconds[0]:.1f} s",
            flush=True,
        )


if __name__ == "__main__":
    main([float(text) / 100.0 for text in sys.argv[1:]] or [0.2, 0.1, 0.05, 0.02, 0.01])
