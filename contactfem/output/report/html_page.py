"""One self-contained HTML page about a run, from jinja2 templates."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contactfem.common.files import write_whole
from contactfem.common.unit_display import engineering
from contactfem.output.report.adaptivity import uniform_rows
from contactfem.output.report.html_steps import decisions, steps_table
from contactfem.output.report.report import (
    cost_rows,
    heat_rows,
    ringing_steps,
    share_of_floor,
    verdict_rows,
)
from contactfem.output.tables import FIGURES, number, read_summary

if TYPE_CHECKING:
    from jinja2 import Environment

PAGE = "report.html"
ORDER = ("interface", "stress", "temperature", "heat", "history")  # of figures; the rest follow
BAR = 8.0  # length of the longest bar [rem]
Summary = Mapping[str, Any]
Content = dict[str, Any]  # what the template shows, by the names it uses


def write_page(directory: Path) -> Path:
    """Write the page of a finished run into its directory.

    Args:
        directory: directory of the run.

    Returns:
        The file; figures are inside it.

    Raises:
        CaseError: if there is no such run, or it has not finished.
        OSError: if it cannot be written.
    """
    summary = read_summary(directory)
    pictures = sorted((directory / FIGURES).glob("[!.]*.png"))
    path = directory / PAGE
    write_whole(path, page(summary, {picture.stem: picture.read_bytes() for picture in pictures}))
    return path


def page(summary: Summary, figures: Mapping[str, bytes]) -> str:
    """The page of a run.

    Args:
        summary: of the run.
        figures: PNG pictures by name.

    Returns:
        The text of the page; all text of the case and the run is escaped in it.
    """
    content = {
        **_top(summary),
        "scene": summary.get("scene", ()),
        "references": summary.get("references", ()),
        "verdicts": _verdicts(summary),
        "figures": _figures(figures),
        **steps_table(summary),
        "reactions": _reactions(summary),
        **_heat(summary),
        "decisions": decisions(summary),
        "uniform": uniform_rows(summary),
        "cost": _cost(summary),
        **_numbers(summary),
        "command": summary["command"],
        "versions": ", ".join(f"{name} {text}" for name, text in summary["versions"].items()),
    }
    return environment().get_template("page.html").render(content).lstrip()


def environment() -> Environment:
    """Templates of the report: text is escaped, and a name that is not given is an error."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    return Environment(
        loader=PackageLoader("contactfem.output.report"),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=_printable,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def _printable(value: object) -> object:
    """Show control characters, which HTML forbids, by their codes; templates' own text is kept."""
    if type(value) is not str:
        return value
    return "".join(c if c.isprintable() or c in "\n\t" else _code(c) for c in value)


def _code(character: str) -> str:
    if character.isspace():
        return " "
    return character.encode("unicode_escape").decode()


def _top(summary: Summary) -> Content:
    """Title, how the run ended, and its most important numbers."""
    verdicts, steps = summary["verdicts"], summary["steps"]
    met = sum(bool(verdict["passed"]) for verdict in verdicts)
    said = f"{met} of {len(verdicts)} expectations met" if verdicts else "nothing was expected"
    ended = "reached its end" if summary["converged"] else "stopped early"
    facts = {
        "reached": engineering(steps[-1]["t"] if steps else 0.0, "s", 4),
        "steps": str(len(steps)),
        "Newton iterations": str(summary["newton_iterations"]),
        "cut-backs": str(sum(step["cutbacks"] for step in steps)),
        "seconds": f"{number(summary['timings'].get('total')):.4g}",
    }
    facts |= {name.replace("_", " "): str(value) for name, value in summary["sizes"].items()}
    return {
        "title": summary["title"],
        "passed": bool(summary["passed"]),
        "ending": f"{ended}, {said}",
        "message": summary["message"],
        "warnings": summary.get("warnings", ()),
        "facts": list(facts.items()),
    }


def _verdicts(summary: Summary) -> list[Content]:
    names = ("name", "found", "allowed", "passed")
    return [dict(zip(names, row, strict=True)) for row in verdict_rows(summary)]


def _figures(figures: Mapping[str, bytes]) -> list[Content]:
    return [
        {
            "name": name.replace("_", " "),
            "kind": "png",
            "data": base64.b64encode(figures[name]).decode(),
        }
        for name in sorted(figures, key=_place)
    ]


def _place(name: str) -> tuple[int, str]:
    """Where a figure stands among the others."""
    places = (k for k, start in enumerate(ORDER) if name.startswith(start))
    return next(places, len(ORDER)), name


def _reactions(summary: Summary) -> list[tuple[str, str]]:
    """Forces at supports and grips at the end of the run."""
    unit = summary.get("force_unit", "N/m")
    return [
        (name, ", ".join(engineering(number(part), unit, 6) for part in force))
        for name, force in summary.get("reactions", {}).items()
    ]


def _heat(summary: Summary) -> Content:
    unit = summary.get("force_unit", "N/m").replace("N", "J")
    rings = ringing_steps(summary)
    return {
        "heat": [(name, engineering(value, unit, 6)) for name, value in heat_rows(summary)],
        "rings": f"{rings} step{'s' if rings > 1 else ''}" if rings else "",
    }


def _cost(summary: Summary) -> list[Content]:
    rows = cost_rows(summary)
    longest = max((seconds for _, seconds in rows), default=0.0) or 1.0
    return [
        {
            "name": name.strip(),
            "part": name.startswith(" "),
            "seconds": f"{seconds:.3f}",
            "share": share_of_floor(name, seconds, summary),
            "width": BAR * seconds / longest,
        }
        for name, seconds in rows
    ]


def _numbers(summary: Summary) -> Content:
    """What was measured, and every value of the case."""
    resolved: Sequence[tuple[str, str, bool]] = summary.get("resolved", ())
    return {
        "measured": [(key, f"{number(value):.8g}") for key, value in summary["values"].items()],
        "resolved": [
            (key, f"{value}  (default)" if default else value) for key, value, default in resolved
        ],
    }
