"""Figures of docs/tire.md, in the manner of the paper's Figures 6 to 11, from a finished run.

./run python3 docs/tire_figures.py runs/tire runs/tire-as_printed docs/figures
"""

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, TriMesh
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from contactfem.case import Case, read_case
from contactfem.common.typing import Floats
from contactfem.geometry.cells import cell_edges, triangles
from contactfem.output.figures.frames import Snapshot, read_snapshot, snapshot_files
from contactfem.output.figures.style import BLUE, GREEN, GREY, INK, RED, STYLE
from contactfem.results.data import BodyPicture

MM, MS = 1e3, 1e3  # per metre, per second
CASE = Path(__file__).parents[1] / "cases" / "tire.toml"
SHOWN = (0.02, 0.045, 0.075)  # times of Figure 10 [s]
END_OF_SLIDING, SLOW_END = 0.075, 750.0  # of the case and of its variant [s]


def main(run: Path, as_printed: Path, out: Path) -> None:
    """Draw all figures of a run, and that of its variant, into a folder."""
    summary = json.loads((run / "summary.json").read_text())
    case = read_case(CASE)
    snapshots = [read_snapshot(file) for file in snapshot_files(run)]
    steps = summary["steps"]
    with mpl.rc_context(STYLE):
        figures = {
            "mesh_and_loads": mesh_and_loads(case),
            "load_path": load_path(case),
            "stress_error": error(steps, "mechanics", r"$\eta_u$", case),
            "flux_error": error(steps, "heat", r"$\eta_\vartheta$", case),
            "meshes": meshes([_at(snapshots, t) for t in SHOWN]),
            "heat": heat(_at(snapshots, END_OF_SLIDING)),
            "course": course(steps),
            "as_printed": whole(
                _at([read_snapshot(file) for file in snapshot_files(as_printed)], SLOW_END)
            ),
        }
        for name, figure in figures.items():
            figure.savefig(out / f"tire_{name}.png")


def _at(snapshots: Sequence[Snapshot], t: float) -> Snapshot:
    """The last snapshot up to a time [s]."""
    return max((s for s in snapshots if s.t <= t * (1.0 + 1e-9)), key=lambda s: s.t)


def mesh_and_loads(case: Case) -> Figure:
    """Figure 6: the first meshes, with pressure, forces and the motion of the rim."""
    figure = Figure(figsize=(7.0, 3.4))
    axes = figure.add_axes((0.02, 0.02, 0.96, 0.96))
    for body in case.bodies.values():
        data = body.mesh.build()
        _lines(axes, data.points, data.cells, 0.4)
        if "inner" in data.groups:
            _pressure_arrows(axes, data.points[data.groups["inner"]])
            for flange in ("left_flange", "right_flange"):
                _flange_arrows(axes, data.points[data.groups[flange]].reshape(-1, 2).mean(axis=0))
    axes.text(0.0, 60.0, "$p_i$", color=BLUE, ha="center", fontsize=12)
    axes.text(30.0, -70.0, "$u = 0$, $\\vartheta = 0$", ha="center", va="center")
    _frame(axes, (-175.0, 235.0), (-78.0, 140.0))
    return figure


def _pressure_arrows(axes: Axes, facets: Floats) -> None:
    middle, along = MM * facets.mean(axis=1), facets[:, 1] - facets[:, 0]
    inwards = np.stack((along[:, 1], -along[:, 0]), axis=1) / np.linalg.norm(
        along, axis=1, keepdims=True
    )
    inside = np.array([0.0, 50.0]) - middle
    inwards *= np.sign(np.sum(inwards * inside, axis=1, keepdims=True))
    for x, n in zip(middle[::3], inwards[::3], strict=True):
        _arrow(axes, x + 12.0 * n, x, BLUE)


def _flange_arrows(axes: Axes, at: Floats) -> None:
    x, y = MM * at
    _arrow(axes, np.array([x, y + 26.0]), np.array([x, y + 2.0]), RED)
    axes.text(x - 4.0, y + 18.0, "$F_v$", color=RED, ha="right")
    _arrow(axes, np.array([x + 6.0, y + 10.0]), np.array([x + 34.0, y + 10.0]), GREEN)
    axes.text(x + 20.0, y + 13.0, r"$\bar v$", color=GREEN, ha="center")


def _arrow(axes: Axes, tail: Floats, head: Floats, colour: str) -> None:
    style = {"arrowstyle": "-|>", "color": colour, "lw": 1.0, "shrinkA": 0.0, "shrinkB": 0.0}
    axes.annotate("", tuple(head), tuple(tail), arrowprops=style)


def load_path(case: Case) -> Figure:
    """Figure 7: pressure, force and way of the rim over time."""
    t = np.linspace(0.0, case.time.end, 401)
    pressure = next(c.pressure for c in case.conditions if c.pressure is not None)
    grip = next(c.grip for c in case.conditions if c.grip is not None)
    curves = (
        ("$p_i$ [N/mm²]", [1e-6 * pressure.at(s, 0.0) for s in t], BLUE),
        ("$2 F_v$ [N/mm]", [-2e-3 * grip.force["y"].at(s, 0.0) for s in t], RED),
        ("rim [mm]", [MM * grip.displacement["x"].at(s, 0.0) for s in t], GREEN),
    )
    figure = Figure(figsize=(6.4, 3.6))
    panels = figure.subplots(3, 1, sharex=True, gridspec_kw={"hspace": 0.18})
    for axes, (label, values, colour) in zip(panels, curves, strict=True):
        axes.plot(MS * t, values, color=colour)
        axes.set_ylabel(label)
        axes.grid(True)
    for when, name in ((10.0, "$t_1$"), (20.0, "$t_2$"), (75.0, "$t_3$"), (87.0, "$t_4$")):
        for axes in panels:
            axes.axvline(when, color=GREY, lw=0.8, ls=":")
        panels[0].text(when, 0.205, name, ha="center", va="bottom")
    panels[-1].set_xlabel("t [ms]")
    figure.align_ylabels()
    return figure


def error(steps: Sequence[dict[str, Any]], problem: str, symbol: str, case: Case) -> Figure:
    """Figures 8 and 9: the indicated error over time, and where meshes were replaced."""
    assert case.adaptivity is not None
    tolerance = case.adaptivity.for_mechanics()
    if problem == "heat":
        tolerance = case.adaptivity.for_heat()
    assert tolerance is not None
    known = [step for step in steps if step["errors"][problem] is not None]
    t = np.array([MS * step["t"] for step in known])
    eta = np.array([100.0 * step["errors"][problem] for step in known])
    new = np.array(
        [any(r["problem"] == problem for r in step["errors"]["remeshes"]) for step in known]
    )
    cells = "cells" if problem == "mechanics" else "thermal_cells"
    figure = Figure(figsize=(6.4, 3.8))
    top, bottom = figure.subplots(2, 1, sharex=True, gridspec_kw={"hspace": 0.12})
    top.plot(t, eta, color=BLUE, marker=".")
    top.plot(t[new], eta[new], "o", color=RED, ms=5.0, mfc="none", label="on a new mesh")
    top.axhline(100.0 * tolerance, color=GREY, ls="--", lw=0.9, label="tolerance")
    top.set(ylabel=f"{symbol} [%]", ylim=(0.0, None))
    for name, colour in (("tire", BLUE), ("ground", GREEN)):
        bottom.semilogy(t, [s["errors"][cells][name] for s in known], color=colour, label=name)
    bottom.set(ylabel="cells", xlabel="t [ms]")
    for axes in (top, bottom):
        axes.grid(True)
        axes.legend(loc="best")
    return figure


def meshes(snapshots: Sequence[Snapshot]) -> Figure:
    """Figure 10: adapted meshes, mechanical on the left and thermal on the right."""
    figure = Figure(figsize=(9.0, 1.85 * len(snapshots) + 0.3))
    panels = figure.subplots(
        len(snapshots), 2, gridspec_kw={"hspace": 0.06, "wspace": 0.02, "left": 0.01,
                                        "right": 0.99, "bottom": 0.01, "top": 0.94},
    )  # fmt: skip
    for row, snapshot in zip(panels, snapshots, strict=True):
        for axes, bodies in zip(row, (snapshot.bodies, snapshot.heat), strict=True):
            for body in bodies:
                _lines(axes, body.points + body.displacement, body.cells, 0.15)
            _frame(axes, (-175.0, 235.0), (-62.0, 135.0))
            count = ", ".join(f"{body.name} {len(body.cells)}" for body in bodies)
            axes.text(0.0, 0.98, f"{MS * snapshot.t:.0f} ms, {count}", transform=axes.transAxes,
                      va="top", fontsize=7.5)  # fmt: skip
    for axes, title in zip(panels[0], ("mechanical meshes", "thermal meshes"), strict=True):
        axes.set_title(title)
    return figure


def heat(snapshot: Snapshot) -> Figure:
    """Figure 11: temperature and heat flux at the hottest place, and along both surfaces."""
    tire = next(body for body in snapshot.heat if body.name == "tire")
    theta = tire.fields["temperature"][:, 0]
    x, y = (tire.points + tire.displacement)[int(np.argmax(theta))]
    figure = Figure(figsize=(7.4, 6.6))
    temperature = [body.fields["temperature"][:, 0] for body in snapshot.heat]
    flux = [1e-6 * np.linalg.norm(body.fields["heat_flux"], axis=1) for body in snapshot.heat]
    fields = (
        (0.71, temperature, "inferno", r"$\vartheta$ [K]"),
        (0.42, flux, "viridis", r"$\sqrt{q \cdot q}$ [W/mm²]"),
    )
    for bottom, values, colours, label in fields:
        axes = figure.add_axes((0.1, bottom, 0.76, 0.25))
        high = max(float(v.max()) for v in values)
        for body, v in zip(snapshot.heat, values, strict=True):
            image = _colours(axes, body, v, colours, high)
        _frame(axes, (MM * x - 1.6, MM * x + 1.6), (MM * y - 0.35, MM * y + 0.35))
        bar = figure.colorbar(image, cax=figure.add_axes((0.88, bottom + 0.02, 0.015, 0.2)))
        bar.set_label(label)
    figure.text(
        0.1, 0.965, f"{MS * snapshot.t:.1f} ms: 3.2 mm around the hottest place", weight="bold"
    )
    axes = figure.add_axes((0.1, 0.07, 0.76, 0.28))
    for body, colour in zip(snapshot.heat, (RED, GREEN), strict=True):
        place, surface = _surface(body)
        axes.plot(place, surface, color=colour, label=body.name)
    axes.set(xlabel="x [mm]", ylabel=r"$\vartheta$ of the surface [K]")
    axes.set_xlim(MM * x - 110.0, MM * x + 40.0)
    axes.grid(True)
    axes.legend()
    return figure


def whole(snapshot: Snapshot) -> Figure:
    """Figure 11 with heat capacities as printed: temperature and heat flux in the whole scene."""
    temperature = [body.fields["temperature"][:, 0] for body in snapshot.heat]
    flux = [np.linalg.norm(body.fields["heat_flux"], axis=1) for body in snapshot.heat]
    figure = Figure(figsize=(7.4, 6.2))
    fields = (
        (0.5, temperature, "inferno", r"$\vartheta$ [K]", 100.0),
        (0.0, flux, "viridis", r"$\sqrt{q \cdot q}$ [µW/mm²]", 98.0),
    )
    for bottom, values, colours, label, percentile in fields:
        axes = figure.add_axes((0.02, bottom + 0.01, 0.84, 0.48))
        high = float(np.percentile(np.concatenate(values), percentile))
        for body, v in zip(snapshot.heat, values, strict=True):
            image = _colours(axes, body, v, colours, high)
        _frame(axes, (-175.0, 235.0), (-62.0, 115.0))
        bar = figure.colorbar(image, cax=figure.add_axes((0.88, bottom + 0.06, 0.015, 0.38)))
        bar.set_label(label)
    return figure


def _surface(body: BodyPicture) -> tuple[Floats, Floats]:
    """Place x [mm] and temperature [K] along the part of a boundary that is near the contact."""
    outline = np.unique(cell_edges(body.cells)[1])
    x = MM * (body.points + body.displacement)[outline]
    near = outline[np.abs(x[:, 1]) < 8.0]
    place = MM * (body.points + body.displacement)[near, 0]
    order = np.argsort(place)
    return place[order], body.fields["temperature"][near[order], 0]


def course(steps: Sequence[dict[str, Any]]) -> Figure:
    """Friction force, hottest temperature, heat balance and step over time."""
    t = np.array([MS * step["t"] for step in steps])
    figure = Figure(figsize=(6.4, 7.0))
    panels = figure.subplots(4, 1, sharex=True, gridspec_kw={"hspace": 0.14})
    force = np.array([step["forces"]["patch"] for step in steps])
    panels[0].plot(t, 1e-3 * force[:, 0], color=RED, label="friction")
    panels[0].plot(t, -0.4e-3 * force[:, 1], color=GREY, ls="--", label=r"$\mu$ times pressing")
    panels[0].set_ylabel("force [N/mm]")
    panels[1].plot(t, [step["heat"]["temperature_max"] for step in steps], color=RED)
    panels[1].set_ylabel("hottest [K]")
    work = np.cumsum([step["dissipation"] for step in steps])
    stored = np.cumsum([step["heat"]["stored"] for step in steps])
    panels[2].plot(t, work, color=RED, lw=2.4, label="work of friction")
    panels[2].plot(t, stored, color=INK, ls="--", label="heat stored")
    panels[2].set_ylabel("[J/m]")
    panels[3].semilogy(t, [MS * step["dt"] for step in steps], color=BLUE, marker=".")
    panels[3].set(ylabel="step [ms]", xlabel="t [ms]")
    for axes in panels:
        axes.grid(True)
    for axes in (panels[0], panels[2]):
        axes.legend()
    figure.align_ylabels()
    return figure


def _lines(axes: Axes, points: Floats, cells: Floats, width: float) -> None:
    edges, outline = cell_edges(cells)
    axes.add_collection(LineCollection(MM * points[edges], colors=INK, lw=width))
    axes.add_collection(LineCollection(MM * points[outline], colors=INK, lw=0.8))


def _colours(axes: Axes, body: BodyPicture, values: Floats, colours: str, high: float) -> TriMesh:
    x = MM * (body.points + body.displacement)
    image = TriMesh(Triangulation(x[:, 0], x[:, 1], triangles(body.cells)))
    image.set_array(values)
    image.set(cmap=colours, clim=(0.0, high))
    axes.add_collection(image, autolim=False)
    edges, outline = cell_edges(body.cells)
    axes.add_collection(LineCollection(x[edges], colors=GREY, lw=0.2, alpha=0.6))
    axes.add_collection(LineCollection(x[outline], colors=INK, lw=0.8))
    return image


def _frame(axes: Axes, x: tuple[float, float], y: tuple[float, float]) -> None:
    axes.set(xlim=x, ylim=y, aspect="equal")
    axes.set_axis_off()


if __name__ == "__main__":
    main(*(Path(word) for word in sys.argv[1:4]))
