"""Work-precision picture of a study: its error against seconds, and against unknowns."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from contactfem.output.figures.style import BLUE, GREEN, GREY, INK, RED, Frame, draw, grid
from contactfem.study.convergence_orders import slope
from contactfem.study.table import Row, Target, by_curve

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

LOOKS = tuple(
    (color, marker, line)
    for line in ("-", "--")
    for color, marker in zip((BLUE, RED, GREEN, GREY, INK), "os^Dv", strict=True)
)

SHORT = 2.0  # decades


def seconds(row: Row) -> float:
    """Wall time without imports, compilation and output [s]."""
    return row.outcome.seconds


def unknowns(row: Row) -> float:
    """Unknowns at the end."""
    return float(row.outcome.unknowns)


def steps(row: Row) -> float:
    """Steps."""
    return float(row.outcome.steps)


def draw_study(path: Path, title: str, target: Target, rows: Sequence[Row]) -> Path | None:
    """Draw the errors of all runs over what they cost.

    Args:
        path: PNG file to write.
        title: of the case.
        target: what the error is.
        rows: the runs.

    Returns:
        The path; None if no run has a positive error, which is all that logarithms show.

    Raises:
        OSError: it cannot be written.
    """
    known = [row for row in rows if row.error > 0.0]
    if not known:
        return None
    frame = Frame(width=7.4, height=3.3, left=0.95, right=0.2, bottom=0.55, top=0.4)
    finer = any(unknowns(row) != unknowns(known[0]) for row in known)

    def paint(figure: Figure) -> None:
        left, right = figure.subplots(1, 2, sharey=True, gridspec_kw={"wspace": 0.08})
        _paint(left, known, seconds, "seconds", "t")
        if finer:
            _paint(right, known, unknowns, "unknowns", "N")
        else:
            _paint(right, known, steps, "steps", "n")
        left.set_ylabel(target.words())
        left.set_title(title)

    return draw(path, frame, paint)


def _paint(
    axes: Axes, rows: Sequence[Row], cost: Callable[[Row], float], label: str, symbol: str
) -> None:
    """One panel; the legend says how the error of each curve falls."""
    for k, (name, some) in enumerate(by_curve(rows).items()):
        color, marker, line = LOOKS[k % len(LOOKS)]
        costs, errors = [cost(row) for row in some], [row.error for row in some]
        exponent = slope(costs, errors)
        falls = "" if math.isnan(exponent) else f"${symbol}^{{{exponent:.2f}}}$"
        axes.plot(costs, errors, line, marker=marker, color=color, label=f"{name}  {falls}".strip())
    axes.set(xscale="log", yscale="log")
    _number(axes.xaxis, axes.get_xlim())
    _number(axes.yaxis, axes.get_ylim())
    axes.set_xlabel(f"{label} {symbol}")
    grid(axes)
    if axes.get_legend_handles_labels()[1]:
        axes.legend()


def _number(axis: Axis, ends: tuple[float, float]) -> None:
    """Plain numbers on a logarithmic scale: at 1, 2 and 5 where it is short, else at 1."""
    from matplotlib.ticker import LogLocator, NullFormatter

    short = math.log10(ends[1] / ends[0]) < SHORT
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if short else (1.0,), numticks=12))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())
