"""Draw heat over time: temperatures, and where the heat came from."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from contactfem.common.typing import Floats
from contactfem.common.unit_display import scale_for
from contactfem.output.figures.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    RED,
    Frame,
    draw,
    grid,
    quantity_label,
    stacked,
)
from contactfem.results.data import HeatStep, RunResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SOURCES = {
    "stored": ("stored", INK),
    "friction": ("friction", RED),
    "loads": ("loads", GREEN),
    "held": ("held boundaries", BLUE),
    "obstacles": ("obstacles", GREY),
    "strained": ("straining", "#8c510a"),
}


def draw_heat_history(result: RunResult, path: Path) -> Path:
    """Draw extreme temperatures, and heat that was stored and supplied since the start.

    Args:
        result: a run with heat, of two steps at least.
        path: PNG file to write.

    Returns:
        The path.
    """
    steps = [(step.t, step.heat) for step in result.steps if step.heat is not None]
    t = np.array([0.0, *(when for when, _ in steps)])
    heat = [step for _, step in steps]

    def paint(figure: Figure) -> None:
        top, bottom = stacked(figure, (1.0, 1.2))
        top.plot(t[1:], [step.temperature_max for step in heat], color=RED, label="largest")
        top.plot(t[1:], [step.temperature_min for step in heat], color=BLUE, label="smallest")
        rings = np.array([bool(step.rings) for step in heat])
        if rings.any():
            at = [step.temperature_max for step in heat]
            top.plot(t[1:][rings], np.array(at)[rings], "x", color=INK, label="rings")
        top.set_ylabel(quantity_label("temperature", "K"))
        top.set_title("Heat")
        _paint_sources(bottom, t, heat, result.case.force_unit.replace("N", "J"))
        for axes in (top, bottom):
            grid(axes)
            axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.05))
        bottom.set_xlabel("t [s]")

    return draw(path, Frame(5.4, 4.4), paint)


def _paint_sources(axes: Axes, t: Floats, heat: list[HeatStep], unit_name: str) -> None:
    """Draw the sums since the start of what is there."""
    curves = {key: np.cumsum([0.0, *(_part(step, key) for step in heat)]) for key in SOURCES}
    largest = max(float(np.abs(curve).max()) for curve in curves.values())
    unit = scale_for(largest, unit_name)
    for key, (label, colour) in SOURCES.items():
        if np.abs(curves[key]).max() > 1e-9 * largest:
            axes.plot(t, curves[key] / unit.factor, color=colour, label=label)
    axes.axhline(0.0, color="#555555", lw=0.8, zorder=1)
    axes.set_ylabel(quantity_label("heat", unit.label))


def _part(step: HeatStep, key: str) -> float:
    return sum(step.held.values()) if key == "held" else float(getattr(step, key))
