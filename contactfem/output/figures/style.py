"""Style of figures, and how they are saved."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from contactfem.common.files import whole_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure

BLUE, RED, GREEN, GREY, INK = "#2166ac", "#b2182b", "#1b7837", "#8c8c8c", "#222222"
STICK_SHADE, SLIP_SHADE = "#d6e6f4", "#fce3cf"

STYLE: dict[str, object] = {
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": "#555555",
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "xtick.color": "#555555",
    "ytick.color": "#555555",
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.4,
    "lines.markersize": 3.6,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "figure.dpi": 100.0,
    "savefig.dpi": 160.0,
    "savefig.facecolor": "white",
}


@dataclass(frozen=True)
class Frame:
    """Size of a figure's panels and what is left free around them [inch].

    Fixed by hand: to let matplotlib find the margins doubles the time to draw.
    """

    width: float
    height: float
    left: float = 0.75
    right: float = 1.65
    bottom: float = 0.5
    top: float = 0.3

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the whole figure [inch]."""
        return self.left + self.width + self.right, self.bottom + self.height + self.top


def draw(path: Path, frame: Frame, paint: Callable[[Figure], None]) -> Path:
    """Draw one figure, which is on disk as a whole or not at all.

    Args:
        path: PNG file to write.
        frame: its size.
        paint: fills the figure.

    Returns:
        The path.

    Raises:
        OSError: if it cannot be written.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        wide, tall = frame.size
        figure = Figure(figsize=frame.size)
        figure.subplots_adjust(
            left=frame.left / wide,
            right=1.0 - frame.right / wide,
            bottom=frame.bottom / tall,
            top=1.0 - frame.top / tall,
        )
        paint(figure)
        with whole_file(path) as draft:
            figure.savefig(draft, format="png", pil_kwargs={"compress_level": 3})
    return path


def quantity_label(name: str, unit: str) -> str:
    """Axis label, such as "pressure [MPa]".

    Args:
        name: what is shown.
        unit: its unit, "" without.

    Returns:
        The label.
    """
    return f"{name} [{unit}]" if unit else name


def grid(axes: Axes, axis: str = "both") -> None:
    """Lay a light grid behind the data.

    Args:
        axes: where.
        axis: "x", "y" or "both".
    """
    axes.grid(True, axis=axis)


def colour_bar(figure: Figure, frame: Frame, image: ScalarMappable, label: str) -> None:
    """Put a colour bar into the right margin.

    Args:
        figure: where.
        frame: size of the figure.
        image: what has the colours.
        label: what they mean.
    """
    wide, tall = frame.size
    x = (frame.left + frame.width + 0.15) / wide
    place = (
        x,
        (frame.bottom + 0.06 * frame.height) / tall,
        0.14 / wide,
        0.88 * frame.height / tall,
    )
    bar = figure.colorbar(image, cax=figure.add_axes(place))
    bar.set_label(label)
    bar.locator.set_params(nbins=6)
    bar.update_ticks()
    bar.outline.set_visible(False)


def stacked(figure: Figure, heights: tuple[float, ...]) -> list[Axes]:
    """Panels over one another that share their abscissa.

    Args:
        figure: where.
        heights: their relative heights, from the top.

    Returns:
        The panels.
    """
    spacing = {"hspace": 0.12}
    panels = figure.subplots(
        len(heights), 1, sharex=True, squeeze=False, height_ratios=heights, gridspec_kw=spacing
    )
    return list(panels[:, 0])
