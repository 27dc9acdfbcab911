"""Animation of a run from its frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from contactfem.common.files import whole_file
from contactfem.common.typing import Floats
from contactfem.common.unit_display import Scale, scale_for
from contactfem.errors import CaseError
from contactfem.geometry.cells import cell_edges, triangles
from contactfem.output.figures.frames import Snapshot, read_snapshot, snapshot_files
from contactfem.output.figures.style import GREY, INK, STYLE
from contactfem.results.data import BodyPicture
from contactfem.results.measures import von_mises

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, DPI = 8.0, 100  # of a frame [inch], [1/inch]
SECONDS = 6.0  # what a film takes
SHOWN = 98.0  # percentile of stress that the colours reach to: corners have more
SHARE, MARGIN = 0.88, 0.1  # of the width that is not the colour bar; between pictures [inch]
CLOSE = 20.0  # half-width of the close-up, in cells where it is hottest (√(length x thickness))
ASPECT = 4.0  # width of the close-up over its height


@dataclass(frozen=True)
class _Look:
    """What all frames share.

    Attributes:
        low: lower left corner of what is shown [m].
        high: upper right one [m].
        stress: colours of the von Mises stress.
        heat: colours of temperature, and the close-up; None without heat.
    """

    low: Floats
    high: Floats
    stress: _Colours
    heat: _Hot | None

    @property
    def scene(self) -> float:
        """Height of the whole scene [inch]."""
        wide, tall = self.high - self.low
        return float(WIDTH * SHARE * tall / wide)

    @property
    def below(self) -> float:
        """Height of the close-up [inch]; 0 without one."""
        return WIDTH * SHARE / ASPECT + MARGIN if self.heat is not None else 0.0


@dataclass(frozen=True)
class _Colours:
    """Colour map from zero to `high` [unit], and how the bar is labelled."""

    name: str
    high: float
    unit: Scale
    symbol: str


@dataclass(frozen=True)
class _Hot:
    """Colours of temperature, and a close-up that follows a point X [m] of a body."""

    colours: _Colours
    body: str
    X: Floats
    half: float


def film(folder: Path, path: Path) -> Path:
    """Make an animated GIF of a run.

    Args:
        folder: of the run, with snapshots.
        path: GIF file to write.

    Returns:
        The path.

    Raises:
        CaseError: the run kept no snapshots, or none of a plane body.
        OSError: it cannot be written.
    """
    import matplotlib as mpl
    from matplotlib.animation import PillowWriter
    from matplotlib.figure import Figure

    files = snapshot_files(folder)
    if len(files) < 2:
        raise CaseError(
            f"{folder}: has no snapshots for a film; run the case with output.snapshots = 60"
        )
    look = _look([read_snapshot(file) for file in files])
    writer = PillowWriter(fps=len(files) / SECONDS)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, look.scene + look.below + MARGIN))
        with whole_file(path) as draft, writer.saving(figure, draft, DPI):
            for file in files:
                figure.clear()
                _paint_frame(figure, read_snapshot(file), look)
                writer.grab_frame()
    return path


def _look(snapshots: Sequence[Snapshot]) -> _Look:
    """Find ranges and corners over all snapshots.

    Raises:
        CaseError: the bodies are not plane.
    """
    bodies = [body for snapshot in snapshots for body in snapshot.bodies]
    places = [body.points + body.displacement for body in bodies]
    if any(place.shape[1] != 2 for place in places):
        raise CaseError("films are made of plane bodies only")
    stress = max(float(np.percentile(von_mises(b.fields["stress"]), SHOWN)) for b in bodies) or 1.0
    return _Look(
        np.min([place.min(axis=0) for place in places], axis=0),
        np.max([place.max(axis=0) for place in places], axis=0),
        _Colours("YlGnBu", stress, scale_for(stress, "Pa"), r"$\sigma_v$"),
        _hot([body for snapshot in snapshots for body in snapshot.heat]),
    )


def _hot(bodies: Sequence[BodyPicture]) -> _Hot | None:
    """Where it is hottest, and how far one has to go there to see cells."""
    if not bodies:
        return None
    hottest = max(bodies, key=lambda body: float(body.fields["temperature"].max()))
    theta = hottest.fields["temperature"][:, 0]
    at, high = int(np.argmax(theta)), float(theta.max())
    around = hottest.points[hottest.cells[(hottest.cells == at).any(axis=1)]]
    size = float(np.sqrt(np.ptp(around, axis=1).prod(axis=1)).mean())
    colours = _Colours("inferno", high or 1.0, scale_for(high or 1.0, "K"), r"$\vartheta$")
    return _Hot(colours, hottest.name, hottest.points[at], CLOSE * size)


def _paint_frame(figure: Figure, snapshot: Snapshot, look: _Look) -> None:
    """One picture: the whole scene, with heat a close-up below it, and the time."""
    height = look.scene + look.below + MARGIN
    axes = figure.add_axes((0.01, (look.below + 0.05) / height, SHARE, look.scene / height))
    _paint(axes, [(b, von_mises(b.fields["stress"])) for b in snapshot.bodies], look.stress)
    axes.set(xlim=(look.low[0], look.high[0]), ylim=(look.low[1], look.high[1]))
    axes.text(0.0, 1.0, f"t = {snapshot.t:.4f} s", transform=axes.transAxes, va="top")
    if look.heat is not None:
        close = figure.add_axes((0.01, 0.05 / height, SHARE, (look.below - MARGIN) / height))
        _paint_close(close, snapshot, look.heat)


def _paint_close(axes: Axes, snapshot: Snapshot, hot: _Hot) -> None:
    """The thermal meshes around a point that moves along."""
    _paint(axes, [(b, b.fields["temperature"][:, 0]) for b in snapshot.heat], hot.colours)
    body = next(body for body in snapshot.heat if body.name == hot.body)
    nearest = int(np.argmin(np.linalg.norm(body.points - hot.X, axis=1)))
    x, y = hot.X + body.displacement[nearest]
    half = hot.half
    axes.set(xlim=(x - half, x + half), ylim=(y - half / ASPECT, y + half / ASPECT))
    label = f"{1e3 * 2.0 * half:.2g} mm of the contact, where it gets hottest"
    box = {"facecolor": "white", "edgecolor": "none", "pad": 2.0}
    axes.text(0.005, 0.96, label, transform=axes.transAxes, va="top", bbox=box)


def _paint(axes: Axes, parts: Sequence[tuple[BodyPicture, Floats]], colours: _Colours) -> None:
    """Bodies with nodal values, their cells, outlines and a colour bar beside."""
    from matplotlib.collections import LineCollection, TriMesh
    from matplotlib.tri import Triangulation

    for body, values in parts:
        x = body.points + body.displacement
        image = TriMesh(Triangulation(x[:, 0], x[:, 1], triangles(body.cells)))
        image.set_array(values / colours.unit.factor)
        image.set(cmap=colours.name, clim=(0.0, colours.high / colours.unit.factor))
        axes.add_collection(image, autolim=False)
        edges, outline = cell_edges(body.cells)
        axes.add_collection(LineCollection(x[edges], colors=GREY, lw=0.25, alpha=0.7))
        axes.add_collection(LineCollection(x[outline], colors=INK, lw=0.8))
    axes.set_axis_off()
    axes.set_aspect("equal")
    bar = axes.figure.colorbar(image, cax=axes.inset_axes((1.02, 0.06, 0.015, 0.8)))
    bar.set_label(f"{colours.symbol} [{colours.unit.label}]")
    bar.outline.set_visible(False)
