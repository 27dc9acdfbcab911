"""All figures of a finished run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from contactfem.common.unit_display import scale_for
from contactfem.output.figures.bodies import draw_heat_flux, draw_stress, draw_temperature
from contactfem.output.figures.errors import draw_errors
from contactfem.output.figures.heat import draw_heat_history
from contactfem.output.figures.interface import draw_interface, draw_interface_heat
from contactfem.output.figures.meshes import draw_meshes
from contactfem.output.figures.style import (
    BLUE,
    GREY,
    RED,
    Frame,
    colour_bar,
    draw,
    grid,
    quantity_label,
    stacked,
)
from contactfem.results.data import RunResult, StepReport

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Painter = Callable[["Axes", Sequence[StepReport]], None]
MANY_STEPS = 8  # with more, single steps are told by colour instead of by name
DASHES = ("-", "--", ":", "-.")


def _paint_forces(axes: Axes, steps: Sequence[StepReport], force_unit: str) -> None:
    t = [0.0, *(step.t for step in steps)]
    names = list(steps[0].forces)
    largest = max(abs(value) for step in steps for force in step.forces.values() for value in force)
    unit = scale_for(largest, force_unit)
    for name, dashes in zip(names, DASHES * len(names), strict=False):
        for component, colour in ((0, RED), (1, BLUE)):
            force = [0.0, *(step.forces[name][component] / unit.factor for step in steps)]
            label = f"{name} F{'xy'[component]}"
            axes.plot(t, force, dashes, marker=".", color=colour, label=label)
    axes.set_ylabel(quantity_label("force on mortar", unit.label))
    axes.axhline(0.0, color="#555555", lw=0.8, zorder=1)


def _paint_status(axes: Axes, steps: Sequence[StepReport]) -> None:
    t = [step.t for step in steps]
    counts = [[getattr(step, name) for step in steps] for name in ("stick", "slip", "open")]
    colours = ("#9ec5e6", "#f6b88a", "#eeeeee")
    axes.stackplot(t, *counts, labels=("stick", "slip", "open"), colors=colours)
    axes.set_ylabel("nodes")


def _paint_iterations(axes: Axes, steps: Sequence[StepReport]) -> None:
    t = np.array([step.t for step in steps])
    dt = np.array([step.dt for step in steps])
    iterations = np.array([step.iterations for step in steps])
    axes.bar(t - 0.5 * dt, iterations, 0.9 * dt, color=BLUE, alpha=0.65)
    cut = np.array([step.cutbacks > 0 for step in steps])
    if cut.any():
        middle = t[cut] - 0.5 * dt[cut]
        axes.plot(middle, iterations[cut], "v", color=RED, ms=5.0, label="after a cut-back")
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.05))
    axes.set_ylabel("iterations")
    axes.yaxis.get_major_locator().set_params(integer=True)


def draw_history(result: RunResult, path: Path) -> Path:
    """Draw forces, status of the nodes and iterations over time.

    Args:
        result: a run of two steps at least, with an interface.
        path: PNG file to write.

    Returns:
        The path.
    """

    def paint(figure: Figure) -> None:
        panels = stacked(figure, (2.2, 1.2, 1.0))
        forces = partial(_paint_forces, force_unit=result.case.force_unit)
        painters: tuple[Painter, ...] = (forces, _paint_status, _paint_iterations)
        for axes, painter in zip(panels, painters, strict=True):
            painter(axes, result.steps)
            grid(axes)
        for axes in panels[:2]:
            axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.05))
        panels[0].set_title("Course of the run")
        panels[-1].set_xlabel("t [s]")

    return draw(path, Frame(5.4, 4.8), paint)


def draw_convergence(result: RunResult, path: Path) -> Path:
    """Draw the residuals of Newton's method, a line per step.

    Args:
        result: a run with residuals.
        path: PNG file to write.

    Returns:
        The path.
    """
    steps = [step for step in result.steps if len(step.residuals) > 1]
    frame = Frame(4.8, 3.0, right=0.25 if len(steps) == 1 else 1.0)

    def paint(figure: Figure) -> None:
        import matplotlib as mpl
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import Normalize

        axes = figure.subplots()
        colours = mpl.colormaps["viridis"]
        norm = Normalize(steps[0].step, max(steps[-1].step, steps[0].step + 1))
        many = len(steps) > MANY_STEPS
        for step in steps:
            residuals = np.maximum(step.residuals, np.finfo(float).tiny)
            colour = colours(0.92 * norm(step.step)) if len(steps) > 1 else BLUE
            style = {"lw": 0.8, "ms": 2.4} if many else {"lw": 1.3, "ms": 4.0}
            axes.semilogy(residuals, "o-", color=colour, label=f"step {step.step}", **style)
        axes.axhline(result.case.solver.tolerance, ls="--", lw=0.9, color=GREY)
        axes.annotate(
            "tolerance", (0.01, result.case.solver.tolerance), (0, 3), textcoords="offset points",
            xycoords=("axes fraction", "data"), color=GREY, fontsize=8.0,
        )  # fmt: skip
        if many:
            colour_bar(figure, frame, ScalarMappable(norm, "viridis"), "step")
        elif len(steps) > 1:
            axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:.0e}")
        axes.xaxis.get_major_locator().set_params(integer=True)
        axes.set(xlabel="iteration", ylabel="scaled residual", title="Convergence of Newton")
        grid(axes)

    return draw(path, frame, paint)


def draw_all(result: RunResult, directory: Path) -> list[Path]:
    """Draw every figure that the run has something to show in.

    Args:
        result: the run.
        directory: where the PNG files go; it exists.

    Returns:
        The files.
    """
    painter = draw_interface if result.case.mechanics else draw_interface_heat
    paths = [
        painter(result, table, directory / f"interface_{table.name}.png")
        for table in result.interfaces
        if table.X.shape[1] == 2
        and len(table.arc) > 1
        and (result.case.mechanics or table.heat is not None)
    ]
    bodies = result.bodies
    moves = result.case.mechanics
    if moves and bodies and all(b.points.shape[1] == 2 and "stress" in b.fields for b in bodies):
        has_friction = any(side.friction is not None for side in result.case.interfaces.values())
        for component in ("yy", "xy") if has_friction else ("yy",):
            paths.append(draw_stress(result, component, directory / f"stress_{component}.png"))
    if result.heat and all(body.points.shape[1] == 2 for body in result.heat):
        paths.append(draw_temperature(result, directory / "temperature.png"))
        paths.append(draw_heat_flux(result, directory / "heat_flux.png"))
        if len(result.steps) > 1:
            paths.append(draw_heat_history(result, directory / "heat.png"))
    paths += _adaptivity(result, directory)
    if moves and len(result.steps) > 1 and result.interfaces:
        paths.append(draw_history(result, directory / "history.png"))
    if any(len(step.residuals) > 1 for step in result.steps):
        paths.append(draw_convergence(result, directory / "convergence.png"))
    return paths


def _adaptivity(result: RunResult, directory: Path) -> list[Path]:
    """Errors over time, and meshes before and after."""
    paths = []
    if sum(step.errors is not None for step in result.steps) > 1:
        paths.append(draw_errors(result, directory / "errors.png"))
    for problem in ("mechanics", "heat"):
        if any(mesh.problem == problem for mesh in result.last_meshes):
            paths.append(draw_meshes(result, problem, directory / f"meshes_{problem}.png"))
    return paths
