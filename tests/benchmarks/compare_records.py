"""Compare the numbers of two sets of runs: the summaries below one folder with those below another.

    ./run python3 tests/benchmarks/compare_records.py BEFORE AFTER [--tolerance 1e-12] [--all]

Every BEFORE/**/summary.json is compared with the one at the same place below AFTER. Numbers that
count (iterations, cells, nodes of each status) and words must be equal. Others may differ by the
tolerance times their scale: the largest number of the same kind in the run, such as all components
of the stress of a body, as a component that is zero is only round-off of the others. Left out is
what measures time or the run itself. Prints one line per run, with the worst difference, and ends
with 1 if any run differs.
"""

import argparse
import json
import re
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

TOLERANCE = 1e-12
# times, costs and how the run was started; residuals are what round-off leaves over
LEFT_OUT = re.compile(
    r"(^|\.)(timings|versions|command|floor|wall|cost|residuals|title|references|case|import|"
    r"message|warnings|seconds|verdicts|reason|decisions|resolved|scene)(\.|$)"
)
ROUND_OFF = re.compile(r"(defect|balance|imbalance|error|eta)")
COMPONENT = re.compile(r"_(xx|yy|zz|xy|yz|xz|x|y|z|von_mises)(?=\.|$)|\.(x|y|z)$|[._](min|max)$")
LENGTH = re.compile(r"(gap|slip)")  # of an interface: compared with its displacements


def leaves(item: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """All values in a tree of dictionaries and lists, with the keys that lead there."""
    if isinstance(item, dict):
        for key, value in item.items():
            yield from leaves(value, f"{path}.{key}" if path else key)
    elif isinstance(item, list):
        for k, value in enumerate(item):
            yield from leaves(value, f"{path}.{k}")
    else:
        yield path, item


def numbers(path: Path) -> dict[str, Any]:
    """What is compared of a summary."""
    found = dict(leaves(json.loads(path.read_text())))
    return {key: value for key, value in found.items() if not LEFT_OUT.search(key)}


def kind(key: str) -> str:
    """Which numbers share a scale: without components, extremes, and numbers of steps."""
    previous, result = "", re.sub(r"\.\d+(?=\.|$)", "", key)
    while previous != result:
        previous, result = result, COMPONENT.sub("", result)
    if result.endswith("dissipation"):
        return "work"
    if key.startswith("reactions") or ".forces." in key or "force" in key:
        return "force"
    if LENGTH.search(result) or result.endswith("displacement"):
        return "length"
    if result.endswith(("pressure", "traction", "stress")):
        return "stress"
    return result


def scales(values: dict[str, Any]) -> dict[str, float]:
    """Largest number of each kind."""
    result: dict[str, float] = defaultdict(float)
    for key, value in values.items():
        if isinstance(value, float):
            result[kind(key)] = max(result[kind(key)], abs(value))
    result["work"] = max(result["work"], result["force"] * result["length"])
    return result


def differences(before: dict[str, Any], after: dict[str, Any]) -> list[tuple[float, str]]:
    """Difference over scale and a sentence for every value that is not the same, worst first."""
    result, scale = [], scales(before)
    for key in sorted(before.keys() | after.keys()):
        a, b = before.get(key, "nothing"), after.get(key, "nothing")
        if a == b or (a != a and b != b):
            continue
        if isinstance(a, float) and isinstance(b, float):
            size = 1.0 if ROUND_OFF.search(key) else max(scale[kind(key)], abs(b))
            error = abs(a - b) / size if size > 0.0 else 0.0
        else:
            error = float("inf")
        result.append((error, f"{key}: {a} -> {b}"))
    return sorted(result, reverse=True)


def main(argv: list[str]) -> int:
    """Compare two folders; 1 if a run differs or is missing."""
    parser = argparse.ArgumentParser(description="Compare the numbers of two sets of runs.")
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("--tolerance", type=float, default=TOLERANCE)
    parser.add_argument("--all", action="store_true", help="show every difference, not the worst 5")
    parser.add_argument("--skip-missing", action="store_true", help="runs that are only in BEFORE")
    options = parser.parse_args(argv)
    bad = 0
    for path in sorted(options.before.rglob("summary.json")):
        name = path.relative_to(options.before)
        other = options.after / name
        if not other.exists():
            if not options.skip_missing:
                print(f"{name.parent!s:60s} missing")
                bad += 1
            continue
        found = differences(numbers(path), numbers(other))
        over = [pair for pair in found if pair[0] > options.tolerance]
        worst = f"worst {found[0][0]:.1e} at {found[0][1]}" if found else "equal"
        word = f"DIFFERS in {len(over)}" if over else "ok"
        print(f"{name.parent!s:60s} {word}, {worst}", flush=True)
        for error, text in over[: None if options.all else 5]:
            print(f"    {error:.1e}  {text}")
        bad += bool(over)
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
