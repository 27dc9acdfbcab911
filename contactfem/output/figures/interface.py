"""Pressure, traction, gap and slip along one interface."""

from __future__ import annotations

from dataclasses import dataclass
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
    SLIP_SHADE,
    STICK_SHADE,
    Frame,
    draw,
    grid,
    quantity_label,
    stacked,
)
from contactfem.results.data import InterfaceTable, RunResult, Status
from contactfem.results.measures import ACTIVE
from contactfem.results.profiles import carriers, value_at, zone
from contactfem.verification.contact import closed_form

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from contactfem.case.interface_laws import Friction

SURROUNDINGS = 0.35  # drawn on either side of the contact, as a share of its width
FINE = 1200  # points on the curve of a closed form

ROUND_OFF_SHARE = 1e-6  # of a facet's length: gaps and slips below it are not drawn larger


@dataclass(frozen=True)
class _Strip:
    """An interface laid out along one coordinate.

    Attributes:
        table: the interface.
        s: coordinate of the nodes, as shown (n,) [unit].
        x: first reference coordinate of the nodes (n,) [m].
        label: label of the coordinate.
        window: from where to where to draw [unit].
        friction: the law; None without friction.
    """

    table: InterfaceTable
    s: Floats
    x: Floats
    label: str
    window: tuple[float, float]
    friction: Friction | None


def _strip(result: RunResult, table: InterfaceTable) -> _Strip:
    """Lay out an interface along X or Y if it follows one of them, else along its arc."""
    ways = {"X": table.X[:, 0], "Y": table.X[:, 1], "arc": table.arc}
    name = next(k for k, way in ways.items() if k == "arc" or _is_monotone(way))
    unit = scale_for(float(np.abs(ways[name]).max()), "m")
    s: Floats = np.divide(ways[name], unit.factor)
    low, high = float(s.min()), float(s.max())
    ends = zone(table, ACTIVE)
    if ends is not None:
        edges = sorted(value_at(s, end) for end in ends)
        around = SURROUNDINGS * (edges[1] - edges[0])
        low, high = max(low, edges[0] - around), min(high, edges[1] + around)
    friction = result.case.interfaces[table.name].friction
    label = quantity_label(name, unit.label)
    return _Strip(table, s, table.X[:, 0], label, (low, high), friction)


def _is_monotone(values: Floats) -> bool:
    """Whether values only rise or only fall."""
    steps = np.diff(values)
    return bool((steps > 0.0).all() or (steps < 0.0).all())


def _shade(axes: Axes, strip: _Strip) -> None:
    """Shade the zones of stick and slip, or of contact; what stays white is open."""
    has_friction = strip.friction is not None
    status = strip.table.status[carriers(strip.table)]
    starts = np.flatnonzero(np.diff(status, prepend=-2))
    for first, after in zip(starts, [*starts[1:], len(status)], strict=True):
        if status[first] in ACTIVE:
            ends = max(first - 0.5, 0.0), min(after - 0.5, len(status) - 1.0)
            shade = SLIP_SHADE if has_friction and status[first] == Status.SLIP else STICK_SHADE
            axes.axvspan(*(value_at(strip.s, end) for end in ends), color=shade, lw=0, zorder=0)


def _paint_closed_form(axes: Axes, strip: _Strip, result: RunResult, factor: float) -> None:
    entry = result.case.closed_form[strip.table.name]
    solution = closed_form(entry.solution, entry.parameters)
    nodes = np.arange(len(strip.s), dtype=np.float64)
    fine = np.unique(np.concatenate([nodes, np.linspace(0.0, nodes[-1], FINE)]))
    s, x = np.interp(fine, nodes, strip.s), np.interp(fine, nodes, strip.x)
    axes.plot(s, solution.pressure(x) / factor, color=INK, lw=1.1, zorder=4, label="closed form")
    if strip.friction is not None:
        axes.plot(s, solution.traction(x) / factor, color=INK, lw=1.1, zorder=4)


def _paint_mortar(axes: Axes, strip: _Strip, factor: float) -> None:
    """Add the pressure seen from the mortar side, at the nonmortar coordinate it faces."""
    table = strip.table
    order = np.argsort(table.x[:, 0])
    s = np.interp(table.mortar_x[:, 0], table.x[order, 0], strip.s[order])
    values = table.mortar_pressure / factor
    axes.plot(s, values, "+", color=GREEN, ms=5.0, zorder=2, label="p seen from mortar")


def _paint_stresses(axes: Axes, strip: _Strip, result: RunResult) -> None:
    table, s = strip.table, strip.s
    carrier = carriers(table)
    pressure, traction = table.pressure[carrier], table.traction[carrier]
    unit = scale_for(max(float(np.abs(v).max()) for v in (pressure, traction)), "Pa")
    curves = [("pressure p", pressure, BLUE, "o")]
    if strip.friction is not None:
        curves.append(("traction t", traction, RED, "s"))
        limit = strip.friction.largest_traction(pressure)
        if limit is not None:
            axes.plot(s, limit / unit.factor, ":", color=GREY, lw=1.0, label="limit of friction")
            axes.plot(s, -limit / unit.factor, ":", color=GREY, lw=1.0)
    elif len(table.mortar_x):
        _paint_mortar(axes, strip, unit.factor)
    known = table.name in result.case.closed_form
    for name, values, colour, marker in curves:
        line = "none" if known else "-"
        axes.plot(
            s, values / unit.factor, marker, ls=line, lw=1.0, color=colour,
            mfc="white", mec=colour, mew=0.9, zorder=3, label=name,
        )  # fmt: skip
    if known:
        _paint_closed_form(axes, strip, result, unit.factor)
    axes.set_ylabel(quantity_label("p" if len(curves) == 1 else "p, t", unit.label))


def _paint_length(axes: Axes, strip: _Strip, name: str, values: Floats, colour: str) -> None:
    """Draw a length along the strip, with its own unit and limits from what is in the window."""
    low, high = strip.window
    seen = values[(strip.s >= low) & (strip.s <= high) & np.isfinite(values)]
    # what is far below a facet's length is round-off, and an axis of it would only show noise
    floor = ROUND_OFF_SHARE * float(strip.table.facet_length.max(initial=0.0))
    unit = scale_for(float(np.abs(seen).max(initial=floor)), "m")
    axes.plot(strip.s, values / unit.factor, color=colour, zorder=3)
    bounds = np.array([float(seen.min(initial=0.0)), float(seen.max(initial=0.0))]) / unit.factor
    pad = max(0.1 * float(np.ptp(bounds)), floor / unit.factor) or 1.0
    axes.set_ylim(bounds[0] - pad, bounds[1] + pad)
    axes.set_ylabel(quantity_label(name, unit.label), color=colour)


def _paint_motion(axes: Axes, strip: _Strip) -> None:
    """Draw the gap and, to its own scale on the right, the slip."""
    _paint_length(axes, strip, "gap", strip.table.gap, GREEN)
    if strip.friction is not None:
        right = axes.twinx()
        right.spines["right"].set_visible(True)
        _paint_length(right, strip, "slip", strip.table.slip, RED)


def _paint_heat(axes: Axes, strip: _Strip) -> None:
    """Draw temperatures of both sides and, to its own scale on the right, the conducted heat."""
    heat = strip.table.heat
    assert heat is not None
    axes.plot(strip.s, heat.temperature, color=RED, label="nonmortar")
    axes.plot(strip.s, heat.mortar_temperature, "--", color=RED, label="mortar")
    axes.set_ylabel(quantity_label("temperature", "K"), color=RED)
    axes.legend(loc="best", fontsize=7.5)
    unit = scale_for(float(np.nanmax(np.abs(heat.flux), initial=0.0)), "W/m^2")
    right = axes.twinx()
    right.spines["right"].set_visible(True)
    flux = heat.flux / unit.factor
    right.plot(strip.s, flux, color=GREEN)
    low, high = np.nanmin(flux, initial=0.0), np.nanmax(flux, initial=0.0)
    pad = 0.1 * (high - low) or 1.0
    right.set_ylim(low - pad, high + pad)
    right.set_ylabel(quantity_label("q", unit.label), color=GREEN)


def draw_interface(result: RunResult, table: InterfaceTable, path: Path) -> Path:
    """Draw an interface at the end of a run.

    Args:
        result: the run.
        table: the interface.
        path: PNG file to write.

    Returns:
        The path.
    """
    strip = _strip(result, table)
    has_friction, hot = strip.friction is not None, table.heat is not None

    def paint(figure: Figure) -> None:
        from matplotlib.patches import Patch

        top, bottom, *heat_axes = stacked(figure, (2.6, 1.0, 1.3)[: 2 + hot])
        _paint_stresses(top, strip, result)
        _paint_motion(bottom, strip)
        for axes in heat_axes:
            _paint_heat(axes, strip)
        for axes in (top, bottom, *heat_axes):
            grid(axes)
            _shade(axes, strip)
        top.axhline(0.0, color="#555555", lw=0.8, zorder=1)
        bottom.set_xlim(*strip.window)
        (bottom, *heat_axes)[-1].set_xlabel(strip.label)
        top.set_title(f"Interface {table.name}")
        handles, _ = top.get_legend_handles_labels()
        handles += [Patch(color=STICK_SHADE, label="stick" if has_friction else "contact")]
        handles += [Patch(color=SLIP_SHADE, label="slip")] if has_friction else []
        top.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.0, 1.0))

    return draw(path, Frame(5.4, 4.0 + 1.2 * hot, bottom=0.5), paint)


def draw_interface_heat(result: RunResult, table: InterfaceTable, path: Path) -> Path:
    """Draw the heat along an interface of bodies that do not move.

    Args:
        result: the run, without mechanics.
        table: the interface, with heat.
        path: PNG file to write.

    Returns:
        The path.
    """
    strip = _strip(result, table)

    def paint(figure: Figure) -> None:
        (axes,) = stacked(figure, (1.0,))
        _paint_heat(axes, strip)
        grid(axes)
        axes.set_xlim(*strip.window)
        axes.set_xlabel(strip.label)
        axes.set_title(f"Interface {table.name}")

    return draw(path, Frame(5.4, 2.4, right=1.0), paint)
