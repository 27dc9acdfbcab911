"""Pictures and a window by pyvista, in a process of their own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from contactfem.errors import CaseError
from contactfem.output.view.reader import FieldReader

HINT = "pip install 'contactfem[view]' brings it; without it, the page of 'contactfem view' shows"
FIELDS = ("von_mises", "temperature")
UNITS = {"von_mises": (1e-6, "MPa"), "temperature": (1.0, "K"), "pressure": (1e-6, "MPa")}
NAMES = {"von_mises": "von Mises stress", "temperature": "temperature", "pressure": "pressure"}
LINE, ARROW = 2, 0.12  # corners of a line; longest arrow over the size of the scene


def has_pyvista() -> bool:
    """Whether pyvista is installed; it is not loaded."""
    return find_spec("pyvista") is not None


def has_display() -> bool:
    """Whether a window could be seen."""
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def draw(folder: Path, *, window: bool) -> list[Path]:
    """Draw the fields of a run at its end, in a process of their own: VTK may end it.

    Args:
        folder: of the run.
        window: open a window instead of writing files.

    Returns:
        The pictures; none of a window.

    Raises:
        CaseError: the run has no fields, pyvista is not there or cannot draw here.
    """
    FieldReader(folder)
    if not has_pyvista():
        raise CaseError(f"pyvista, which draws this, is not installed: {HINT}")
    job = json.dumps({"folder": str(folder), "window": window})
    words = [sys.executable, "-P", "-m", "contactfem.output.view.pictures", job]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or ["it ended without a word"])[-1]
        raise CaseError(
            f"pyvista cannot draw here: {last}; without a display it needs EGL or OSMesa "
            "(Debian: libegl1 and libgl1-mesa-dri), or use the page of 'contactfem view'"
        )
    return [Path(line) for line in done.stdout.splitlines()]


def _grid(reader: FieldReader, name: str, step: int) -> Any:
    """Deformed mesh of a block with its fields."""
    import pyvista as pv

    frame = reader.frame(name, step)
    size = np.full((len(frame.cells), 1), frame.cells.shape[1])
    kinds = np.full(len(frame.cells), frame.kind, np.uint8)
    shift = frame.fields.get("displacement", np.zeros_like(frame.points))
    grid = pv.UnstructuredGrid(np.hstack((size, frame.cells)), kinds, frame.points + shift)
    for key, values in frame.fields.items():
        grid.point_data[key] = values
    grid.point_data["reference"] = frame.points
    return grid


def _label(plotter: Any, grids: dict[str, Any], key: str) -> None:
    """Mark the largest value and say where it is."""
    name = max(grids, key=lambda n: float(np.nanmax(grids[n][key])))
    grid = grids[name]
    at = int(np.nanargmax(grid[key]))
    flat = not np.ptp(grid["reference"][:, LINE])
    place = ", ".join(f"{1e3 * x:.4g}" for x in grid["reference"][at][: LINE if flat else None])
    factor, unit = UNITS[key]
    text = f"{factor * grid[key][at]:.4g} {unit} in {name}\nat ({place}) mm"
    plotter.add_point_labels(
        grid.points[at : at + 1], [text], font_size=13, point_size=9, always_visible=True,
        point_color="red", shape_color="white", shape_opacity=0.85,
    )  # fmt: skip


def _scene(reader: FieldReader, key: str, *, window: bool) -> Any:
    """A plotter with all that carries a field, solids cut open through its largest value."""
    import pyvista as pv

    step = len(reader.times) - 1
    grids = {name: _grid(reader, name, step) for name in reader.names}
    with_field = {name: g for name, g in grids.items() if key in g.point_data}
    bodies = {name: g for name, g in grids.items() if "pressure" not in g.point_data}
    flat = np.ptp(np.vstack([g.points for g in bodies.values()])[:, 2]) == 0.0
    plotter = pv.Plotter(off_screen=not window, window_size=(1400, 1000))
    factor, unit = UNITS[key]
    shown = with_field
    if key == "pressure":
        for name, grid in bodies.items():
            if not name.endswith(" heat"):
                plotter.add_mesh(grid, color="lightgrey", opacity=1.0 if flat else 0.2)
    elif not flat:
        best = max(shown.values(), key=lambda g: float(np.nanmax(g[key])))
        origin = best.points[int(np.nanargmax(best[key]))]
        shown = {
            n: g.clip("z", origin=origin + np.array([0.0, 0.0, 1e-9])) for n, g in shown.items()
        }
    limits = [factor * f([f(g[key]) for g in with_field.values()]) for f in (np.nanmin, np.nanmax)]
    for grid in shown.values():
        grid.point_data["shown"] = factor * np.asarray(grid[key])
        actor = plotter.add_mesh(
            grid, scalars="shown", clim=limits, cmap="viridis", show_edges=not flat,
            edge_opacity=0.3, line_width=6 if grid.GetCell(0).GetCellDimension() < LINE else 1,
            nan_color="grey", show_scalar_bar=False,
        )  # fmt: skip
        if key == "pressure":
            _arrows(plotter, grid, bodies)
    _label(plotter, with_field, key)
    title = f"{NAMES[key]} [{unit}]"
    plotter.add_scalar_bar(
        title, mapper=actor.mapper, width=0.5, height=0.06, position_x=0.25, position_y=0.02,
        fmt="%.4g",
    )  # fmt: skip
    plotter.enable_parallel_projection()
    plotter.view_xy() if flat else plotter.view_vector((0.6, 0.55, 1.0), viewup=(0.0, 1.0, 0.0))
    plotter.reset_camera()
    plotter.camera.zoom(1.25 if flat else 0.9)
    plotter.show_axes()
    return plotter


def _arrows(plotter: Any, grid: Any, bodies: dict[str, Any]) -> None:
    """Traction vectors on a contact surface, as far as it has them."""
    traction = np.asarray(grid["traction"]) if "traction" in grid.point_data else np.empty(0)
    if traction.ndim != LINE or not np.abs(traction).max(initial=0.0):
        return
    size = max(float(np.linalg.norm(np.ptp(body.points, axis=0))) for body in bodies.values())
    factor = ARROW * size / float(np.linalg.norm(traction, axis=1).max())
    plotter.add_mesh(grid.glyph(orient="traction", scale="traction", factor=factor), color="black")


def main() -> None:
    """Draw what the first argument says, and print the files."""
    job = json.loads(sys.argv[1])
    folder = Path(job["folder"])
    reader = FieldReader(folder)
    last = len(reader.times) - 1
    there = {key for name in reader.names for key in reader.frame(name, last).fields}
    keys = [key for key in (*FIELDS, "pressure") if key in there]
    for key in keys[: 1 if job["window"] else None]:
        plotter = _scene(reader, key, window=job["window"])
        if job["window"]:
            plotter.show(title=f"{folder}: {NAMES[key]}")
            return
        (folder / "figures").mkdir(exist_ok=True)
        path = folder / "figures" / f"view_{key}.png"
        plotter.screenshot(str(path))
        plotter.close()
        sys.stdout.write(f"{path}\n")


if __name__ == "__main__":
    main()
