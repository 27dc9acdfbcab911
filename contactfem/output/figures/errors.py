"""Indicated errors, time step and cells over time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from contactfem.common.typing import Floats
from contactfem.common.unit_display import scale_for
from contactfem.output.figures.style import BLUE, GREEN, GREY, INK, RED, Frame, draw, grid, stacked
from contactfem.results.data import ErrorStep, RunResult
from contactfem.results.error_measures import remesh_events

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOGARITHMIC = 20.0  # ratio of the largest step to the smallest from which the axis is logarithmic
ERRORS = {"mechanics": ("stress", BLUE), "heat": ("heat flux", RED), "time": ("rate", GREEN)}


def draw_errors(result: RunResult, path: Path) -> Path:
    """Draw indicated errors, length of the steps and number of cells over time.

    Args:
        result: a run with adaptivity, of two steps at least.
        path: PNG file to write.

    Returns:
        The path.
    """
    steps = [(step.t, step.dt, step.errors) for step in result.steps if step.errors is not None]
    t = np.array([at for at, _, _ in steps])
    errors = [found for _, _, found in steps]

    def paint(figure: Figure) -> None:
        top, middle, bottom = stacked(figure, (2.0, 1.0, 1.0))
        _paint_errors(top, result, t, errors)
        lengths = np.array([dt for _, dt, _ in steps])
        unit = scale_for(float(lengths.max()), "s")
        middle.step(t, lengths / unit.factor, where="pre", color=INK)
        middle.set(ylabel=f"step [{unit.label}]")
        if lengths.max() > LOGARITHMIC * lengths.min():
            middle.set_yscale("log")
        for key, label in (("cells", "mechanics"), ("thermal_cells", "heat")):
            counts = [sum(getattr(found, key).values()) for found in errors]
            if any(counts) and (key == "thermal_cells" or result.case.mechanics):
                colour = ERRORS[label][1]
                bottom.step(t, counts, where="pre", color=colour, label=label)
        bottom.set(ylabel="cells", xlabel="t [s]")
        for axes in (top, middle, bottom):
            grid(axes)
        for axes in (top, bottom):
            axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.05))

    return draw(path, Frame(5.4, 5.0), paint)


def _paint_errors(axes: Axes, result: RunResult, t: Floats, errors: list[ErrorStep]) -> None:
    settings = result.case.adaptivity
    assert settings is not None
    asked = {
        "mechanics": settings.for_mechanics(),
        "heat": settings.for_heat(),
        "time": settings.for_time(),
    }
    drawn = set()
    for key, (label, colour) in ERRORS.items():
        found = [getattr(one, key) for one in errors]
        eta = np.array([np.nan if value is None else 100.0 * value for value in found])
        if np.isfinite(eta).any():
            axes.plot(t, eta, ".-", color=colour, lw=1.0, label=label)
            drawn.add(asked[key])
    for tolerance in drawn:
        axes.axhline(100.0 * (tolerance or 0.0), ls="--", lw=0.9, color=GREY, label="asked for")
    events = [at for at, _ in remesh_events(result.steps)]
    if events:
        foot = axes.get_xaxis_transform()
        axes.plot(
            events, np.full(len(events), 0.02), "^", color=INK, transform=foot, label="new meshes",
            clip_on=False,
        )  # fmt: skip
    axes.set_ylim(bottom=0.0)
    axes.set(ylabel="indicated error [%]", title="Errors, ratios of norms")
