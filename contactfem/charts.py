"""How figures look, and how they get to disk; matplotlib is imported when one is drawn."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
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


def draw(path: Path, size: tuple[float, float], paint: Callable[[Figure], None]) -> Path:
    """Draw one figure, which is on disk as a whole or not at all.

    Args:
        path: PNG file to write.
        size: width and height [inch].
        paint: fills the figure.

    Returns:
        The path.

    Raises:
        OSError: if it cannot be written.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=size, layout="constrained")
        paint(figure)
        draft = path.with_name(f".{path.name}.part")
        figure.savefig(draft, format="png", pil_kwargs={"compress_level": 3})
    os.replace(draft, path)
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
