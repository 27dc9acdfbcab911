"""A film of a run from its snapshots: deformed bodies coloured by temperature or by stress."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from contactfem.charts import INK, STYLE
from contactfem.engineering import Scale, scale_for
from contactfem.errors import CaseError
from contactfem.magnification import cell_edges, triangles
from contactfem.measure import von_mises
from contactfem.results import BodyPicture, FloatArray
from contactfem.snapshots import Snapshot, read_snapshot, snapshot_files

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from PIL.Image import Image

WIDTH, DPI = 8.0, 100  # of a frame [inch], [1/inch]
SECONDS = 6.0  # what a film takes
SHOWN = 99.9  # percentile of the hottest picture that the colours reach to
COLOURS = 128  # of a frame: smooth colours, and half the size of 256


@dataclass(frozen=True)
class _Look:
    """What all frames share: field, colours, their range, unit, and the part of the plane."""

    symbol: str
    colours: str
    high: float
    unit: Scale
    low_corner: FloatArray
    high_corner: FloatArray


def film(folder: Path, path: Path) -> Path:
    """Make an animated GIF of a run.

    Args:
        folder: of the run, with snapshots.
        path: GIF file to write.

    Returns:
        The path.

    Raises:
        CaseError: the run kept no snapshots, or none of a plane body.
    """
    files = snapshot_files(folder)
    if len(files) < 2:
        raise CaseError(
            f"{folder}: has no snapshots for a film; run the case with output.snapshots = 60"
        )
    look = _look([read_snapshot(file) for file in files])
    frames = [_frame(read_snapshot(file), look) for file in files]
    frames[0].save(
        path,
        save_all=True,
        append_images=frames[1:],
        duration=round(1000.0 * SECONDS / len(frames)),
        loop=0,
        optimize=True,
    )
    return path


def _parts(snapshot: Snapshot) -> Sequence[tuple[BodyPicture, FloatArray]]:
    """Bodies with what they are coloured by: temperature, or without heat von Mises stress."""
    if snapshot.heat:
        return [(body, body.fields["temperature"][:, 0]) for body in snapshot.heat]
    return [(body, von_mises(body.fields["stress"])) for body in snapshot.bodies]


def _look(snapshots: Sequence[Snapshot]) -> _Look:
    heats = bool(snapshots[0].heat)
    parts = [part for snapshot in snapshots for part in _parts(snapshot)]
    high = max(float(np.percentile(values, SHOWN)) for _, values in parts) or 1.0
    places = [body.points + body.displacement for body, _ in parts]
    if any(place.shape[1] != 2 for place in places):
        raise CaseError("films are made of plane bodies only")
    return _Look(
        r"$\vartheta$" if heats else r"$\sigma_v$",
        "inferno" if heats else "YlGnBu",
        high,
        scale_for(high, "K" if heats else "Pa"),
        np.min([place.min(axis=0) for place in places], axis=0),
        np.max([place.max(axis=0) for place in places], axis=0),
    )


def _frame(snapshot: Snapshot, look: _Look) -> Image:
    """One picture: colours, outlines, the meshes of mechanics, and the time."""
    import matplotlib as mpl
    from matplotlib.figure import Figure
    from PIL import Image

    wide, tall = look.high_corner - look.low_corner
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 0.25 + WIDTH * 0.92 * tall / wide), dpi=DPI)
        axes = figure.add_axes((0.01, 0.01, 0.88, 0.98))
        _paint(axes, figure, snapshot, look)
        text = io.BytesIO()
        figure.savefig(text, format="png", dpi=DPI)
    return Image.open(text).convert("RGB").quantize(COLOURS)


def _paint(axes: Axes, figure: Figure, snapshot: Snapshot, look: _Look) -> None:
    from matplotlib.collections import LineCollection, TriMesh
    from matplotlib.tri import Triangulation

    for body, values in _parts(snapshot):
        x = body.points + body.displacement
        image = TriMesh(Triangulation(x[:, 0], x[:, 1], triangles(body.cells)))
        image.set_array(values / look.unit.factor)
        image.set(cmap=look.colours, clim=(0.0, look.high / look.unit.factor))
        axes.add_collection(image, autolim=False)
    for body in snapshot.bodies:
        x = body.points + body.displacement
        edges, outline = cell_edges(body.cells)
        axes.add_collection(LineCollection(x[edges], colors="white", lw=0.25, alpha=0.35))
        axes.add_collection(LineCollection(x[outline], colors=INK, lw=0.8))
    margin = 0.01 * (look.high_corner - look.low_corner)
    low, high = look.low_corner - margin, look.high_corner + margin
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_axis_off()
    axes.text(0.01, 0.97, f"t = {snapshot.t:.4f} s", transform=axes.transAxes, va="top")
    bar = figure.colorbar(image, cax=figure.add_axes((0.91, 0.12, 0.015, 0.76)))
    bar.set_label(f"{look.symbol} [{look.unit.label}]")
    bar.outline.set_visible(False)
