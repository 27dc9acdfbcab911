"""Text for people: lines, hints at similar names, percent, tables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING

from contactfem.errors import CaseError

if TYPE_CHECKING:
    from rich.table import Table

LISTED = 12  # names that a hint lists where none is similar


def one_line(text: str) -> str:
    """A text in one line that a terminal shows as it is: line breaks and the like are escaped."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


@contextmanager
def about(path: Path) -> Iterator[None]:
    """Put the name of a case file before every line of an error raised inside."""
    try:
        yield
    except CaseError as error:
        start = f"{path}: "
        lines = [one_line(line.removeprefix(start)) for line in str(error).split("\n")]
        raise type(error)("\n".join(start + line for line in lines)) from error


def similar(name: str, names: Iterable[str]) -> str:
    """Hint at the most similar of some names; empty where none is similar."""
    near = get_close_matches(name, list(names), n=1)
    return f"; did you mean '{near[0]}'?" if near else ""


def nearest(name: str, names: Iterable[str]) -> str:
    """Hint at the most similar of some names, or list them where none is similar."""
    known = list(names)
    listed = f"; known: {', '.join(known[:LISTED])}" if known else ""
    return similar(name, known) or listed


def percent(value: float, digits: int = 3) -> str:
    """A ratio in percent, such as "12.3 %"."""
    return f"{100.0 * value:.{digits}g} %"


def shortened[T](items: Sequence[T], most: int) -> list[T | None]:
    """All items, or of more than `most` the first and the last, with None between them."""
    half = most // 2
    return list(items) if len(items) <= most else [*items[:half], None, *items[-half:]]


def report_table(title: str, *columns: str) -> Table:
    """An empty table for the terminal: the first column to the left, the others to the right.

    Titles are shown as they are; in cells rich reads markup such as "[bold]".
    """
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(
        title=Text(one_line(title)),
        title_justify="left",
        title_style="bold",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
        collapse_padding=True,
    )
    for number, column in enumerate(columns):
        table.add_column(Text(column), justify="left" if number == 0 else "right", no_wrap=True)
    return table
