"""Segments per second of the kernels, and how search and segments grow with the surfaces.

    ./run python3 tests/benchmarks/throughput.py [FACETS]

Two wavy surfaces that nearly touch, of as many facets each but not at the same places, from 1e3
facets to 1e6 (or FACETS). The last column is the exponent p of time ~ facets^p from row to row.
"""

import math
import sys
import time
from collections.abc import Callable

import numpy as np

from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.normals import nodal_normals
from contactfem.mortar.segments import cut, find_pairs

RADIUS = 3.0  # of the search, in facets


def surfaces(n: int) -> InterfaceMesh:
    """Two waves of n and about n facets, the nonmortar one below."""
    s, t = np.linspace(0, 1, n + 1), np.linspace(-1e-3, 1.001, n + n // 7 + 2)
    lower = np.column_stack((s, 0.1 * np.sin(7 * s)))
    upper = np.column_stack((t, 0.1 * np.sin(7 * t) + 0.3 / n))
    ahead, back = np.arange(n)[:, None], np.arange(len(t) - 1)[:, None]
    mortar = n + 1 + np.hstack((back, back + 1))
    X = np.vstack((lower, upper))
    return InterfaceMesh(n + 1, np.hstack((ahead + 1, ahead)), mortar, X, np.ones(X.shape, bool))


def seconds[T](work: Callable[[], T]) -> tuple[float, T]:
    """The least of three times, and the result."""
    times = []
    for _ in range(3):
        start = time.perf_counter()
        result = work()
        times.append(time.perf_counter() - start)
    return min(times), result


def row(n: int) -> tuple[int, float, float, float]:
    """Segments, and seconds of search, of segments and of those with derivatives."""
    mesh = surfaces(n)
    normals, chosen = nodal_normals(mesh, mesh.X).n, np.arange(n)
    search, pairs = seconds(lambda: find_pairs(mesh, mesh.X, normals, chosen, RADIUS / n))
    plain, found = seconds(lambda: cut(mesh, mesh.X, normals, pairs, False))
    live, _ = seconds(lambda: cut(mesh, mesh.X, normals, pairs, True))
    return len(found.span), search, plain, live


def main(most: int) -> None:
    """Print one row per size."""
    print("  facets  segments    search    segments  with deriv.  segments/s  with deriv.      p")
    before = None
    for n in (10**k for k in range(3, int(math.log10(most) + 1e-9) + 1)):
        count, search, plain, live = row(n)
        growth = "" if before is None else f"{math.log10((search + plain) / before):7.2f}"
        print(
            f"{n:8d}  {count:8d}  {search:6.4f} s  {plain:8.4f} s   {live:8.4f} s"
            f"  {count / plain:10.3g}   {count / live:10.3g}{growth}",
            flush=True,
        )
        before = search + plain


if __name__ == "__main__":
    main(int(float(sys.argv[1])) if len(sys.argv) > 1 else 10**6)
