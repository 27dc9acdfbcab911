"""HTML elements, tables and small curves."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from html import escape

NONE: Mapping[str, str] = {}
WIDTH, HEIGHT, MARGIN = 120, 28, 3  # of a small curve


class Markup(str):
    """A piece of a page that stands in it as it is; all other text is escaped."""

    __slots__ = ()


def element(name: str, attributes: Mapping[str, str], *content: str) -> Markup:
    """An element.

    Args:
        name: its tag.
        attributes: by name.
        content: markup, or text that is escaped.

    Returns:
        The element.
    """
    given = "".join(f' {key}="{escape(value)}"' for key, value in attributes.items())
    return Markup(f"<{name}{given}>{join(content)}</{name}>")


def join(parts: Iterable[str]) -> Markup:
    """Pieces one after the other; what is not markup is escaped."""
    return Markup("".join(p if isinstance(p, Markup) else escape(p) for p in parts))


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> Markup:
    """A table that scrolls sideways where it is too wide; its first column is to the left.

    Args:
        head: titles of the columns; empty for none.
        rows: cells of each row.

    Returns:
        The table.
    """
    body = [
        element("tr", NONE, *(element("td", NONE, cell) for cell in row), Markup("\n"))
        for row in rows
    ]
    titles = [element("th", {"scope": "col"}, title) for title in head]
    top = [element("thead", NONE, element("tr", NONE, *titles))] if head else []
    inner = element("table", NONE, *top, element("tbody", NONE, *body))
    return element("div", {"class": "scroll"}, inner)


def section(name: str, title: str, *content: str) -> Markup:
    """A section with its title; nothing without content."""
    if not any(content):
        return Markup()
    return element("section", {"id": name}, element("h2", NONE, title), *content, Markup("\n"))


def folded(title: str, *content: str) -> Markup:
    """Something that is shown when its title is clicked on."""
    return element("details", NONE, element("summary", NONE, title), *content)


def curve(values: Sequence[float | None], low: float, high: float, level: float) -> Markup:
    """A small curve over its number in the row, on a logarithmic scale.

    Args:
        values: what is drawn; what is not positive lies at the bottom.
        low: value at the bottom, > 0.
        high: value at the top, > low.
        level: value of a thin line across, such as a tolerance.

    Returns:
        The picture.
    """
    depth = math.log(high / low)

    def y(value: float | None) -> float:
        inside = min(max(value or low, low), high)
        return MARGIN + (HEIGHT - 2 * MARGIN) * math.log(high / inside) / depth

    pace = (WIDTH - 2 * MARGIN) / max(len(values) - 1, 1)
    points = [(MARGIN + pace * k, y(value)) for k, value in enumerate(values)]
    line = " ".join(f"{x:.1f},{height:.1f}" for x, height in points)
    size = {"viewBox": f"0 0 {WIDTH} {HEIGHT}", "width": str(WIDTH), "height": str(HEIGHT)}
    where = f"{y(level):.1f}"
    across = {"x1": "0", "x2": str(WIDTH), "y1": where, "y2": where, "class": "level"}
    said = ", ".join("not finite" if value is None else f"{value:.1e}" for value in values)
    return element(
        "svg",
        size | {"class": "curve", "role": "img"},
        element("title", NONE, said),
        element("line", across),
        element("polyline", {"points": line}),
        *(element("circle", {"cx": f"{x:.1f}", "cy": f"{h:.1f}", "r": "1.6"}) for x, h in points),
    )
