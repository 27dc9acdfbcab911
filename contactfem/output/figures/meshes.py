"""Meshes before and after, coloured by the error."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.common.unit_display import Scale, engineering, scale_for
from contactfem.geometry.cells import cell_edges, triangles
from contactfem.output.figures.style import INK, Frame, colour_bar, draw, quantity_label
from contactfem.results.data import MeshErrors, RunResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import TriMesh
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

PANEL = (4.0, 4.2)  # largest width and height of a picture [inch]
FEW, LINES = 4000, 20_000  # cells up to which lines are drawn as such, or thin
DECADES = 4.0  # of densities that the colours tell apart
BETWEEN = 0.6  # two pictures [inch]


def draw_meshes(result: RunResult, problem: str, path: Path) -> Path:
    """Draw the first and the last meshes of one problem side by side.

    Args:
        result: a run with adaptivity that has errors of this problem.
        problem: "mechanics" or "heat".
        path: PNG file to write.

    Returns:
        The path.
    """
    both = [
        [mesh for mesh in meshes if mesh.problem == problem]
        for meshes in (result.first_meshes, result.last_meshes)
    ]
    shown = [meshes for meshes in both if meshes]
    points = np.concatenate([mesh.points for meshes in shown for mesh in meshes])
    wide, tall = np.ptp(points, axis=0)
    length = scale_for(float(max(wide, tall)), "m")
    scale = min(PANEL[0] / wide, PANEL[1] / tall)
    width, height = max(scale * wide, 1.5), max(scale * tall, 1.5)
    frame = Frame(len(shown) * width + (len(shown) - 1) * BETWEEN, height, right=1.2)
    largest = max(float(_nodal(mesh).max()) for meshes in shown for mesh in meshes)

    def paint(figure: Figure) -> None:
        from matplotlib.colors import Normalize

        norm = Normalize(largest - DECADES, largest)
        spacing = {"wspace": BETWEEN / width}
        row = figure.subplots(1, len(shown), squeeze=False, gridspec_kw=spacing)[0]
        for axes, meshes in zip(row, shown, strict=True):
            image = _paint(axes, meshes, length, norm)
        label = r"$\log_{10}$ (share in $\eta^2$ / share in area)"
        colour_bar(figure, frame, image, label)

    return draw(path, frame, paint)


def _paint(axes: Axes, meshes: Sequence[MeshErrors], length: Scale, norm: Normalize) -> TriMesh:
    from matplotlib.collections import TriMesh
    from matplotlib.tri import Triangulation

    count = sum(len(mesh.cells) for mesh in meshes)
    for mesh in meshes:
        x: Floats = np.divide(mesh.points, length.factor)
        image = TriMesh(Triangulation(x[:, 0], x[:, 1], triangles(mesh.cells)))
        image.set_array(_nodal(mesh))
        image.set(cmap="YlOrRd", norm=norm)
        axes.add_collection(image, autolim=False)
        edges, outline = cell_edges(mesh.cells)
        if count <= LINES:
            width = 0.25 if count <= FEW else 0.1
            axes.plot(*_polyline(x, edges), color=INK, lw=width, alpha=0.6)
        axes.plot(*_polyline(x, outline), color=INK, lw=0.8)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_title(f"t = {engineering(meshes[0].t, 's', 3)}: {count} cells")
    axes.set_xlabel(quantity_label("x", length.label))
    axes.set_ylabel(quantity_label("y", length.label))
    return image


def _nodal(mesh: MeshErrors) -> Floats:
    """Logarithm of the mean density of the cells around each vertex."""
    k = mesh.cells.shape[1]
    total = np.bincount(mesh.cells.ravel(), np.repeat(mesh.density, k), len(mesh.points))
    mean = total / np.bincount(mesh.cells.ravel(), minlength=len(mesh.points))
    return np.asarray(np.log10(np.maximum(mean, np.finfo(float).tiny)))


def _polyline(x: Floats, edges: Ints) -> Floats:
    """One line through all edges, lifted between them (2, 3e)."""
    lifted = np.full((len(edges), 1, 2), np.nan)
    return np.asarray(np.concatenate([x[edges], lifted], axis=1).reshape(-1, 2).T)
