"""Deformed bodies coloured by a nodal field."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.common.unit_display import Scale, scale_for
from contactfem.geometry.cells import cell_edges, triangles
from contactfem.output.figures.deformation import magnification
from contactfem.output.figures.style import INK, Frame, colour_bar, draw, quantity_label
from contactfem.results.data import BodyPicture, RunResult
from contactfem.results.measures import ACTIVE, COMPONENTS, von_mises
from contactfem.results.profiles import value_at, zone

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.figure import Figure

    from contactfem.case.schema import Case

CLOSE_UP = 0.2  # a contact smaller than this share of the scene gets a picture of its own
PANEL = (4.2, 4.2)  # largest width and height of a picture [inch]
MESH_LINES = 4000  # with more cells than this, lines would hide the colours
TEMPERATURE = r"$\vartheta$"
SYMBOLS = {"von_mises": r"$\sigma_v$"} | {c: rf"$\sigma_{{{c}}}$" for c in COMPONENTS}


@dataclass(frozen=True)
class Shown:
    """A nodal field of some bodies, and how it is called.

    Attributes:
        bodies: the bodies.
        values: nodal values of each, (n,) [unit].
        title: of the picture.
        symbol: of the colour bar.
        unit: SI unit of the values.
        signed: whether the colours show the sign even if there is one only.
        sequence: colour map of a field of one sign.
    """

    bodies: tuple[BodyPicture, ...]
    values: tuple[Floats, ...]
    title: str
    symbol: str
    unit: str
    signed: bool = False
    sequence: str = "YlGnBu"


@dataclass(frozen=True)
class _View:
    """What all pictures of a run share: magnification, lengths and colours."""

    magnification: float
    length: Scale
    value: Scale
    low: float
    high: float
    colours: str


def stress_of(body: BodyPicture, component: str) -> Floats:
    """Nodal values of a stress component.

    Args:
        body: the body.
        component: one of xx, yy, zz, xy, yz, xz, or von_mises.

    Returns:
        Values (n,) [Pa].
    """
    stress = body.fields["stress"]
    if component == "von_mises":
        return von_mises(stress)
    return stress[:, COMPONENTS.index(component)]


def _view(result: RunResult, shown: Shown) -> _View:
    points = np.concatenate([body.points for body in shown.bodies])
    low, high = (float(v) for v in np.percentile(np.concatenate(shown.values), [0.2, 99.8]))
    largest = max(abs(low), abs(high))
    both_signs = low < 0.0 < high and min(-low, high) > 0.05 * largest
    if both_signs or shown.signed:
        low, high, colours = -largest, largest, "RdBu_r"
    else:
        colours = shown.sequence if high > -low else f"{shown.sequence}_r"
    if high - low < 1e-6 * largest or largest == 0.0:
        pad = 0.01 * largest or 1.0
        low, high = low - pad, high + pad
    length = scale_for(float(np.ptp(points, axis=0).max()), "m")
    moved = magnification(result) if result.bodies else 1.0  # without mechanics none moves
    return _View(moved, length, scale_for(largest, shown.unit), low, high, colours)


def _positions(body: BodyPicture, view: _View) -> Floats:
    moved: Floats = body.points + view.magnification * body.displacement
    shown: Floats = np.divide(moved[:, :2], view.length.factor)
    return shown


def _polyline(x: Floats, edges: Ints) -> Floats:
    """Return one line through all edges, lifted between them, which is quick to draw (2, 3e)."""
    lifted = np.full((len(edges), 1, 2), np.nan)
    line: Floats = np.concatenate([x[edges], lifted], axis=1).reshape(-1, 2).T
    return line


def _paint_body(axes: Axes, body: BodyPicture, values: Floats, view: _View) -> ScalarMappable:
    from matplotlib.collections import TriMesh
    from matplotlib.tri import Triangulation

    x = _positions(body, view)
    image = TriMesh(Triangulation(x[:, 0], x[:, 1], triangles(body.cells)))
    factor = view.value.factor
    image.set_array(values / factor)
    image.set(cmap=view.colours, clim=(view.low / factor, view.high / factor))
    axes.add_collection(image, autolim=False)  # limits come from the outline, which is quicker
    edges, outline = cell_edges(body.cells)
    if len(body.cells) <= MESH_LINES:
        axes.plot(*_polyline(x, edges), color=INK, lw=0.2, alpha=0.3)
    axes.plot(*_polyline(x, outline), color=INK, lw=0.8, solid_capstyle="butt")
    return image


def _paint_obstacles(axes: Axes, case: Case, end: float, view: _View) -> None:
    """Draw rigid obstacles in grey where they stand at the end."""
    from matplotlib.patches import Circle, Polygon

    low, high = np.array([axes.get_xlim(), axes.get_ylim()]).T
    reach = 2.0 * float(np.linalg.norm(high - low))
    for obstacle in case.obstacles.values():
        tables = obstacle.motion(2)
        moved = np.array([table.at(end, case.time.step) for table in tables])
        if obstacle.shape == "circle":
            center = (np.array(obstacle.center) + moved) / view.length.factor
            radius = obstacle.radius / view.length.factor
            face = "none" if obstacle.inside else "#d0d0d0"
            axes.add_patch(Circle(tuple(center), radius, fc=face, ec=INK, lw=0.8, zorder=0))
            continue
        if obstacle.shape == "polyline":
            chain = (obstacle.chain + view.magnification * moved) / view.length.factor
            axes.plot(*chain.T, color=INK, lw=1.2, zorder=0)
            continue
        normal = np.array(obstacle.normal) / np.linalg.norm(obstacle.normal)
        along = reach * np.array([normal[1], -normal[0]])
        point = (np.array(obstacle.point) + view.magnification * moved) / view.length.factor
        depth = -0.035 * float((high - low).max()) * normal
        corners = [point - along, point + along, point + along + depth, point - along + depth]
        axes.add_patch(Polygon(corners, fc="#d0d0d0", ec="#777777", hatch="////", lw=0.6, zorder=0))
        band = np.abs(depth) * (np.abs(normal) > 0.99)
        low, high = low - band, high + band
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))


def _paint(axes: Axes, result: RunResult, shown: Shown, view: _View) -> ScalarMappable:
    pairs = zip(shown.bodies, shown.values, strict=True)
    images = [_paint_body(axes, body, values, view) for body, values in pairs]
    axes.set_aspect("equal")
    axes.autoscale_view()
    end = result.steps[-1].t if result.steps else 0.0
    _paint_obstacles(axes, result.case, end, view)
    axes.set_xlabel(quantity_label("x", view.length.label))
    axes.set_ylabel(quantity_label("y", view.length.label))
    return images[0]


def _close_up(result: RunResult, shown: Shown, view: _View) -> tuple[Floats, float] | None:
    """Return middle and half-width of the first small contact, in the unit that is shown."""
    points = np.concatenate([_positions(body, view) for body in shown.bodies])
    size = float(np.ptp(points, axis=0).max())
    for table in result.interfaces:
        ends = zone(table, ACTIVE)
        if ends is None:
            continue
        moved = table.X + view.magnification * (table.x - table.X)
        scaled: Floats = np.divide(moved, view.length.factor)
        x = np.array([[value_at(scaled[:, i], end) for i in (0, 1)] for end in ends])
        half = 1.1 * float(np.linalg.norm(x[1] - x[0]))
        if 0.0 < half < CLOSE_UP * size:
            inner = 0.95 * half  # keeps the picture from showing much of nothing
            return np.clip(x.mean(axis=0), points.min(0) + inner, points.max(0) - inner), half
    return None


def draw_stress(result: RunResult, component: str, path: Path) -> Path:
    """Draw all bodies, deformed and coloured by a stress.

    Args:
        result: the run, with bodies that have stress.
        component: one of xx, yy, zz, xy, yz, xz, or von_mises.
        path: PNG file to write.

    Returns:
        The path.
    """
    values = tuple(stress_of(body, component) for body in result.bodies)
    title = f"Cauchy stress {SYMBOLS[component]}"
    signed = component == "xy"
    return _draw(
        result, Shown(result.bodies, values, title, SYMBOLS[component], "Pa", signed), path
    )


def draw_temperature(result: RunResult, path: Path) -> Path:
    """Draw all thermal meshes, deformed and coloured by temperature.

    Args:
        result: the run, with heat.
        path: PNG file to write.

    Returns:
        The path.
    """
    values = tuple(body.fields["temperature"][:, 0] for body in result.heat)
    shown = Shown(result.heat, values, "Temperature", TEMPERATURE, "K", sequence="inferno")
    return _draw(result, shown, path)


def draw_heat_flux(result: RunResult, path: Path) -> Path:
    """Draw all thermal meshes, deformed and coloured by the size of the heat flux, sqrt(q·q).

    Args:
        result: the run, with heat.
        path: PNG file to write.

    Returns:
        The path.
    """
    values = tuple(np.linalg.norm(body.fields["heat_flux"], axis=1) for body in result.heat)
    title = r"Effective heat flux $\sqrt{q \cdot q}$"
    shown = Shown(result.heat, values, title, r"$|q|$", "W/m^2", sequence="viridis")
    return _draw(result, shown, path)


def _draw(result: RunResult, shown: Shown, path: Path) -> Path:
    view = _view(result, shown)
    close = _close_up(result, shown, view)
    points = np.concatenate([_positions(body, view) for body in shown.bodies])
    wide, tall = np.ptp(points, axis=0)
    scale = min(PANEL[0] / wide, PANEL[1] / tall)
    widths = [max(scale * wide, 2.0)] + ([] if close is None else [PANEL[0]])
    between = 0.9 * (len(widths) - 1)
    frame = Frame(sum(widths) + between, max(scale * tall, 1.5), right=1.2)

    def paint(figure: Figure) -> None:
        spacing = {"wspace": between / float(np.mean(widths)), "width_ratios": widths}
        row = figure.subplots(1, len(widths), squeeze=False, gridspec_kw=spacing)[0]
        for axes in row:
            image = _paint(axes, result, shown, view)
        row[0].set_title(shown.title)
        if close is not None:
            (x, y), half = close
            row[1].set(xlim=(x - half, x + half), ylim=(y - half, y + half))
            row[1].set_title("close to the contact")
        if view.magnification != 1.0:
            text = f"displacements × {view.magnification:g}"
            figure.text(0.99, 0.02, text, ha="right", fontsize=8.5)
        colour_bar(figure, frame, image, quantity_label(shown.symbol, view.value.label))

    return draw(path, frame, paint)
