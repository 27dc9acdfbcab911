"""Wall time of the block at 2e5 unknowns on two ranks and on one; for a machine that does no more.

    ./run python3 tests/benchmarks/ranks.py [CELLS]        (along each side, 316 if not given)

Every run is a process of its own and is done three times, by turns; rows are medians. On two ranks
every iteration has a factor of its own, so one rank is shown both with factors that serve on and
without. "solve" is Newton's method, "all" the whole run without imports, compilation and output.
"""

import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from contactfem.study.process import ASIDE, QUIET

CASE = Path(__file__).parents[2] / "cases" / "block.toml"
REPEATS = 3
RUNS = {  # ranks and settings
    "1 rank, reused": (1, []),
    "1 rank": (1, ["solver.reuse=false"]),
    "2 ranks": (2, []),
}


def seconds(ranks: int, settings: list[str]) -> tuple[float, float]:
    """Seconds of the solve phase and of all of a run."""
    words = [sys.executable, "-m", "contactfem", "run", str(CASE)]
    for setting in (*settings, *QUIET):
        words += ["--set", setting]
    if ranks > 1:
        words = ["mpirun", "-n", str(ranks), *words]
    with tempfile.TemporaryDirectory() as out:
        subprocess.run([*words, "--out", out], check=True, stdout=subprocess.DEVNULL)
        timings = json.loads((Path(out) / "summary.json").read_text())["timings"]
    aside = sum(timings.get(phase, 0.0) for phase in ASIDE)
    return timings["newton"], timings["total"] - aside


def main(cells: int) -> None:
    """Print the medians and how much faster two ranks are."""
    size = [f"bodies.block.mesh.{key}={cells}" for key in ("nx", "ny")]
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in RUNS}
    for _ in range(REPEATS):
        for name, (ranks, settings) in RUNS.items():
            found[name].append(seconds(ranks, [*settings, *size]))
    medians = {
        name: [statistics.median(column) for column in zip(*rows, strict=True)]
        for name, rows in found.items()
    }
    for name, (solve, everything) in medians.items():
        gain = [a / b for a, b in zip(medians[name], medians["2 ranks"], strict=True)]
        print(f"{name:16s} solve {solve:8.2f} s   all {everything:8.2f} s", end="")
        print(f"   over 2 ranks: {gain[0]:.2f}, {gain[1]:.2f}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 316)
