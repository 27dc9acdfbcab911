"""Wall time from the shell to the first Newton iteration of the block, forms compiled before.

    python3 tests/benchmarks/start_up.py        (not through ./run, which is part of what is timed)

The medians of five runs. What the shell waits for and the program does not book is counted, so it
is an upper bound: leaving takes some time too.
"""

import json
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]
BEFORE = ("import", "mesh", "jit", "setup")  # the phases before the first iteration
REPEATS = 5


def seconds() -> dict[str, float]:
    """Seconds of one run."""
    with tempfile.TemporaryDirectory(dir=ROOT) as out:
        words = [str(ROOT / "run"), "contactfem", "run", "cases/block.toml", "--out", out]
        start = time.perf_counter()
        subprocess.run(words, check=True, cwd=ROOT, stdout=subprocess.DEVNULL)
        wall = time.perf_counter() - start
        timings = json.loads((Path(out) / "summary.json").read_text())["timings"]
    phases = {"shell and leaving": wall - timings["total"]} | {k: timings[k] for k in BEFORE}
    return phases | {"in all": sum(phases.values()), "whole run": wall}


def main() -> None:
    """Print the medians."""
    seconds()  # compiles what is not compiled yet
    runs = [seconds() for _ in range(REPEATS)]
    for name in runs[0]:
        print(f"{name:18s} {statistics.median(run[name] for run in runs):6.2f} s")


if __name__ == "__main__":
    main()
