"""The cost of the solve phase in units of what one plain iteration must cost.

    ./run python3 tests/benchmarks/solve_phase.py [NAME ...]        (all of RUNS if none is given)

Every run is done three times with reused factors and three times without, by turns, in processes of
their own after one run that fills the caches; rows are medians. A unit is one assembly and one
factorisation of the run without; contact's share is that of the solve phase without.
"""

import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

CASES = Path(__file__).parents[2] / "cases"
REPEATS = 3
QUIET = ["output.figures=false", "output.fields=false"]
PLAIN = ["solver.reuse=false"]


def block(n: int) -> tuple[str, list[str]]:
    """The block with n by n cells."""
    return "block", [f"bodies.block.mesh.nx={n}", f"bodies.block.mesh.ny={n}"]


def hertz(cylinder: str, growth: str, size: str) -> tuple[str, list[str]]:
    """Hertz's contact with facets of these sizes."""
    changes = [f"bodies.cylinder.mesh.size='{cylinder}'", f"bodies.block.mesh.size='{size}'"]
    return "hertz", changes + [f"bodies.{b}.mesh.growth={growth}" for b in ("cylinder", "block")]


def ironing(factor: float) -> tuple[str, list[str]]:
    """The ironing with cells that are finer by a factor; pressed down and drawn a little."""
    counts = {"slab.mesh.nx": 120, "slab.mesh.ny": 20, "die.mesh.n_arc": 12, "die.mesh.n_side": 8}
    changes = [f"bodies.{key}={round(factor * n)}" for key, n in counts.items()]
    return "ironing", [*changes, "time.end='1.1 s'", "time.step='0.02 s'"]


RUNS = {
    "block-2e4": block(100),
    "block-1e5": block(223),
    "hertz-2e4": hertz("0.066 mm", "0.051", "0.08 mm"),
    "hertz-1e5": hertz("0.0295 mm", "0.0232", "0.0355 mm"),
    "ironing-2e4": ironing(2.0),
    "ironing-1e5": ironing(4.5),
}


def run(case: str, changes: list[str], ranks: int = 1) -> dict[str, Any]:
    """Summary of one run in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        words = ["contactfem", "run", str(CASES / f"{case}.toml"), "--out", folder]
        words += [word for change in changes for word in ("--set", change)]
        start = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
        done = subprocess.run([*start, *words], capture_output=True, text=True, check=False)
        if done.returncode not in (0, 1):  # 1: it expects what finer meshes do not give
            raise SystemExit(done.stderr)
        summary: dict[str, Any] = json.loads((Path(folder) / "summary.json").read_text())
        return summary


def numbers(reused: dict[str, Any], plain: dict[str, Any]) -> dict[str, float]:
    """What one pair of runs says."""
    cost, bare = reused["timings"], plain["timings"]
    factors = plain["sizes"]["factorisations"]
    factorisation, assembly = bare["factorisation"] / factors, bare["assembly"] / factors
    steps, unit = len(reused["steps"]), factorisation + assembly
    return {
        "unknowns": reused["sizes"]["unknowns"],
        "steps": steps,
        "iterations": reused["newton_iterations"] / steps,
        "iterations plain": plain["newton_iterations"] / len(plain["steps"]),
        "factorisations": reused["sizes"]["factorisations"],
        "solve phase / factorisations": cost["newton"] / factorisation,
        "step / units": cost["newton"] / steps / unit,
        "step / units plain": bare["newton"] / len(plain["steps"]) / unit,
        "contact's share plain": bare["contact"] / bare["newton"],
        "seconds to first iteration": sum(cost[k] for k in ("import", "mesh", "jit", "setup")),
    }


def main(names: list[str]) -> None:
    """Print the medians of some runs."""
    for name in names or RUNS:
        case, changes = RUNS[name]
        run(case, [*changes, *QUIET, "time.end='0.02 s'"] if case == "ironing" else changes + QUIET)
        found = [
            numbers(run(case, changes + QUIET), run(case, changes + QUIET + PLAIN))
            for _ in range(REPEATS)
        ]
        print(name)
        for key in found[0]:
            values = [row[key] for row in found]
            print(f"    {key:30s} {statistics.median(values):10.4g}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
