"""A run as one self-contained HTML page."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from contactfem.common.unit_display import engineering
from contactfem.output.report.html_markup import NONE, Markup, element, folded, join, section, table
from contactfem.output.report.html_steps import decisions, steps_section
from contactfem.output.report.html_style import STYLE
from contactfem.output.report.report import (
    allowed_text,
    cost_rows,
    heat_rows,
    number,
    read_summary,
    ringing_steps,
    share_of_floor,
)
from contactfem.output.tables import FIGURES, write_whole

PAGE = "report.html"
ORDER = ("interface", "stress", "temperature", "heat", "history")  # of figures; the rest follow
Summary = Mapping[str, Any]


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
    figures = {path.stem: path.read_bytes() for path in (directory / FIGURES).glob("*.png")}
    path = directory / PAGE
    write_whole(path, page(summary, figures))
    return path


def page(summary: Summary, figures: Mapping[str, bytes]) -> str:
    """The page of a run.

    Args:
        summary: of the run.
        figures: PNG pictures by name.

    Returns:
        The text of the page.
    """
    head = (
        Markup('<meta charset="utf-8">'),
        Markup('<meta name="viewport" content="width=device-width, initial-scale=1">'),
        element("title", NONE, summary["title"]),
        element("style", NONE, Markup(STYLE)),
    )
    body = (
        _top(summary),
        section("scene", "What it models", _scene(summary)),
        section("verdicts", "Expected and found", _verdicts(summary)),
        section("figures", "Figures", _figures(figures)),
        section("steps", "Steps and their convergence", steps_section(summary)),
        section("heat", "Where the heat came from", _heat(summary)),
        section("decisions", "Decisions taken", decisions(summary)),
        section("cost", "Cost", _cost(summary)),
        section("numbers", "All numbers", _numbers(summary)),
        section("repeat", "How to repeat it", _repeat(summary)),
    )
    parts = (element("head", NONE, *head), element("body", NONE, *body), Markup("\n"))
    return "<!doctype html>\n" + element("html", {"lang": "en"}, *parts)


def _mark(text: str, good: bool, kind: str = "") -> Markup:
    return element("span", {"class": f"{kind} {'good' if good else 'bad'}".strip()}, text)


def _top(summary: Summary) -> Markup:
    """Title, what became of the run, and the numbers that everyone asks for first."""
    verdicts, steps = summary["verdicts"], summary["steps"]
    held = sum(bool(verdict["passed"]) for verdict in verdicts)
    said = f"{held} of {len(verdicts)} expectations held" if verdicts else "nothing was expected"
    ended = "reached its end" if summary["converged"] else "stopped early"
    facts = {
        "reached": engineering(steps[-1]["t"] if steps else 0.0, "s", 4),
        "steps": str(len(steps)),
        "Newton iterations": str(summary["newton_iterations"]),
        "cut-backs": str(sum(step["cutbacks"] for step in steps)),
        "seconds": f"{number(summary['timings'].get('total')):.4g}",
    }
    facts |= {name.replace("_", " "): str(value) for name, value in summary["sizes"].items()}
    boxes = [
        element("div", NONE, element("dt", NONE, name), element("dd", NONE, value))
        for name, value in facts.items()
    ]
    parts = [
        element("h1", NONE, summary["title"]),
        _mark("passed" if summary["passed"] else "not passed", summary["passed"], "verdict"),
        element("span", {"class": "soft"}, f"  {ended}, {said}"),
    ]
    if summary["message"]:
        parts.append(element("p", {"class": "stop"}, f"The run stopped: {summary['message']}"))
    for warning in summary.get("warnings", ()):
        parts.append(element("p", {"class": "stop doubt"}, f"Warning: {warning}"))
    return element("header", NONE, *parts, element("dl", {"class": "facts"}, *boxes))


def _words(rows: Sequence[tuple[str, str]]) -> Markup:
    return element("div", {"class": "words"}, table((), rows)) if rows else Markup()


def _scene(summary: Summary) -> Markup:
    references = [element("li", NONE, text) for text in summary.get("references", ())]
    return join(
        (
            _words([(title, text) for title, text in summary.get("scene", ())]),
            element("ul", {"class": "soft"}, *references) if references else Markup(),
        )
    )


def _verdicts(summary: Summary) -> Markup:
    rows = []
    for verdict in summary["verdicts"]:
        unit, good = verdict["unit"], bool(verdict["passed"])
        rows.append(
            (
                verdict["key"],
                engineering(number(verdict["value"]), unit, 7),
                allowed_text(verdict["low"], verdict["high"], unit),
                _mark("held" if good else "missed", good),
            )
        )
    return table(("number", "found", "allowed", ""), rows) if rows else Markup()


def _figures(figures: Mapping[str, bytes]) -> Markup:
    if not figures:
        return Markup()
    shown = []
    for name in sorted(figures, key=_place):
        words = name.replace("_", " ")
        source = f"data:image/png;base64,{base64.b64encode(figures[name]).decode()}"
        image = Markup(element("img", {"src": source, "alt": words}).removesuffix("</img>"))
        shown.append(element("figure", NONE, image, element("figcaption", NONE, words)))
    return element("div", {"class": "figures"}, *shown)


def _place(name: str) -> tuple[int, str]:
    """Where a figure stands among the others."""
    places = (k for k, start in enumerate(ORDER) if name.startswith(start))
    return next(places, len(ORDER)), name


def _heat(summary: Summary) -> Markup:
    unit = summary.get("force_unit", "N/m").replace("N", "J")
    rows = [(name, engineering(value, unit, 6)) for name, value in heat_rows(summary)]
    if not rows:
        return Markup()
    rings = ringing_steps(summary)
    warning = f"The time scheme rings in {rings} steps; dG(1) would not."
    return join(
        (
            table(("", "since the start"), rows),
            element("p", {"class": "bad"}, warning) if rings else Markup(),
        )
    )


def _cost(summary: Summary) -> Markup:
    longest = max((seconds for _, seconds in cost_rows(summary)), default=0.0) or 1.0
    rows = [
        (
            name.replace("  ", "\u2003"),
            f"{seconds:.3f}",
            share_of_floor(seconds, summary),
            element("span", {"class": "bar", "style": f"width:{8 * seconds / longest:.2f}rem"}),
        )
        for name, seconds in cost_rows(summary)
    ]
    note = "The floor is what assembly, factorisation and solve of the same iterations cost alone."
    return join(
        (
            element("div", {"class": "cost"}, table(("phase", "seconds", "of floor", ""), rows)),
            element("p", {"class": "soft"}, note),
        )
    )


def _numbers(summary: Summary) -> Markup:
    """What was measured, and every value of the case; folded."""
    measured = [(key, f"{number(value):.8g}") for key, value in summary["values"].items()]
    resolved = [
        (key, f"{value}  (default)" if default else value)
        for key, value, default in summary.get("resolved", ())
    ]
    return join(
        (
            folded("What was measured, in SI", table((), measured)) if measured else Markup(),
            folded("Every value of the case, in SI", _words(resolved)) if resolved else Markup(),
        )
    )


def _repeat(summary: Summary) -> Markup:
    versions = ", ".join(f"{name} {version}" for name, version in summary["versions"].items())
    return join((element("pre", NONE, summary["command"]), element("p", NONE, f"With {versions}.")))
