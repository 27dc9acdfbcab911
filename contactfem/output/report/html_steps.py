"""Steps on the page of a run: convergence, forces, errors, decisions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from contactfem.common.text import percent
from contactfem.common.unit_display import engineering
from contactfem.output.report.report import force_columns
from contactfem.output.tables import number

Step = Mapping[str, Any]
WIDTH, HEIGHT, MARGIN = 120, 28, 3  # of a small curve [px]

LOWEST, HIGHEST, LEVEL = 1e-16, 10.0, 1e-10  # of residuals as they are drawn
# what has a place of its own on the page; all else of a step is told with the decisions
TOLD = {
    "step", "t", "dt", "iterations", "cutbacks", "residuals", "open", "stick", "slip", "forces",
    "dissipation", "wall", "moment_defects", "heat", "errors",
}  # fmt: skip


@dataclass(frozen=True)
class Curve:
    """A small curve over its number in the row, on a logarithmic scale.

    Attributes:
        points: places of the values in the picture [px], as text.
        level: height of a thin line across, such as a tolerance [px].
        text: the values, for who cannot see it.
        width: of the picture [px].
        height: of the picture [px].
    """

    points: tuple[tuple[str, str], ...]
    level: str
    text: str
    width: int = WIDTH
    height: int = HEIGHT


Column = tuple[str, Callable[[Step], str | Curve]]


def curve(values: Sequence[float | None], low: float, high: float, level: float) -> Curve:
    """Place the values of a small curve.

    Args:
        values: what is drawn; what is not positive lies at the bottom.
        low: value at the bottom, > 0.
        high: value at the top, > low.
        level: value of the line across.

    Returns:
        The curve.
    """
    depth = math.log(high / low)

    def y(value: float | None) -> str:
        inside = min(max(value or low, low), high)
        return f"{MARGIN + (HEIGHT - 2 * MARGIN) * math.log(high / inside) / depth:.1f}"

    pace = (WIDTH - 2 * MARGIN) / max(len(values) - 1, 1)
    points = tuple((f"{MARGIN + pace * k:.1f}", y(value)) for k, value in enumerate(values))
    said = ", ".join("not finite" if value is None else f"{value:.1e}" for value in values)
    return Curve(points, y(level), said)


def steps_table(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Table of all accepted steps.

    Args:
        summary: of one run.

    Returns:
        Titles of the columns, a row of cells per step, and a note on the curves.
    """
    steps = summary["steps"]
    columns = list(_columns(summary)) if steps else []
    note = (
        "The curves show the scaled residual before each Newton iteration and after the last, from "
        f"{HIGHEST:g} at the top to {LOWEST:g}; the dashed line is the tolerance."
    )
    return {
        "columns": [title for title, _ in columns],
        "steps": [[show(step) for _, show in columns] for step in steps],
        "curve_note": note if any(step["residuals"] for step in steps) else "",
    }


def _columns(summary: Mapping[str, Any]) -> Iterator[Column]:
    """Columns that say something about this run."""
    steps = summary["steps"]
    yield "step", lambda step: str(step["step"])
    yield "t", lambda step: engineering(step["t"], "s", 5)
    yield "dt", lambda step: engineering(step["dt"], "s", 3)
    if any(step["residuals"] for step in steps):
        level = _tolerance(summary)
        yield "iterations", lambda step: str(step["iterations"])
        yield "convergence", lambda step: curve(step["residuals"], LOWEST, HIGHEST, level)
        yield "residual", lambda step: f"{number((step['residuals'] or [None])[-1]):.1e}"
        yield "cut-backs", lambda step: str(step["cutbacks"] or "")
    if any(step[name] for step in steps for name in ("open", "stick", "slip")):
        yield "open", lambda step: str(step["open"])
        yield "stick", lambda step: str(step["stick"])
        yield "slip", lambda step: str(step["slip"])
    for name, unit, show in force_columns(summary):
        yield f"{name} [{unit}]", show
    if any(step.get("heat") for step in steps):
        yield "coldest [K]", lambda step: _heat(step, "temperature_min")
        yield "hottest [K]", lambda step: _heat(step, "temperature_max")
        yield "passes", lambda step: _heat(step, "passes")
    yield from _errors(steps)
    for name in _numbers(steps):
        yield name.replace("_", " "), lambda step, name=name: _value(step.get(name))  # type: ignore[misc]
    yield "seconds", lambda step: f"{number(step['wall']):.3g}"


def _errors(steps: Sequence[Step]) -> Iterator[Column]:
    """Estimated errors and counts of cells, where meshes and steps adapt."""
    found = [step["errors"] for step in steps if step.get("errors")]
    names = {"mechanics": "error of stress", "heat": "of heat flux", "time": "of rate"}
    for key, title in names.items():
        if any(errors[key] is not None for errors in found):
            yield title, lambda step, key=key: _percent((step.get("errors") or {}).get(key))  # type: ignore[misc]
    for key, title in {"cells": "cells", "thermal_cells": "thermal cells"}.items():
        if any(errors[key] for errors in found):
            yield title, lambda step, key=key: _total((step.get("errors") or {}).get(key))  # type: ignore[misc]


def _percent(value: float | None) -> str:
    return "" if value is None else percent(value)


def _total(counts: Mapping[str, int] | None) -> str:
    return str(sum(counts.values())) if counts else ""


def _tolerance(summary: Mapping[str, Any]) -> float:
    """Tolerance of the residual, out of the values of the case."""
    found = [v for key, v, _ in summary.get("resolved", ()) if key == "solver.tolerance"]
    return float(found[0]) if found else LEVEL


def _heat(step: Step, key: str) -> str:
    return _value((step.get("heat") or {}).get(key))


def _value(value: object) -> str:
    """A number, shortly; nothing for what is none."""
    return f"{value:.5g}" if isinstance(value, int | float) else ""


def _numbers(steps: Sequence[Step]) -> list[str]:
    """Names of further numbers that steps have, such as errors and counts of cells."""
    found = {
        name: None
        for step in steps
        for name, value in step.items()
        if name not in TOLD and isinstance(value, int | float) and not isinstance(value, bool)
    }
    return list(found)


def decisions(summary: Mapping[str, Any]) -> list[str]:
    """What the run decided on its way: failed steps, and what steps tell besides numbers.

    Args:
        summary: of one run.

    Returns:
        Sentences by time; none where nothing had to be decided.
    """
    return [text for _, text in sorted(_told(summary), key=lambda item: item[0])]


def _told(summary: Mapping[str, Any]) -> Iterator[tuple[float, str]]:
    """Times and sentences."""
    for failure in summary.get("failures", ()):
        t, dt = number(failure["t"]), number(failure["dt"])
        reached = engineering(t, "s", 5)
        again = engineering(dt, "s", 3)
        yield t, f"Step to t = {reached} failed: {failure['reason']}; tried again with {again}."
    for step in summary["steps"]:
        t = number(step["t"])
        head = f"Step {step['step']}, t = {engineering(t, 's', 5)}"
        if rings := (step.get("heat") or {}).get("rings"):
            yield t, f"{head}: {rings}"
        errors = step.get("errors") or {}
        for decision in errors.get("decisions", ()):
            yield t, f"{head}: {decision}"
        for new in errors.get("remeshes", ()):
            cells = f"{new['cells_before']} to {new['cells_after']} cells"
            yield t, f"{head}: new mesh of '{new['body']}' for {new['problem']}, {cells}"
        for name, value in step.items():
            if name in TOLD:
                continue
            told = value if isinstance(value, list) else [value]
            for one in told:
                if isinstance(one, str | Mapping) and one:
                    yield t, f"{head}, {name.replace('_', ' ')}: {_sentence(one)}"


def _sentence(value: object) -> str:
    """Words, numbers and tables of them as a text."""
    if isinstance(value, Mapping):
        return ", ".join(f"{k} {_sentence(v)}".replace("_", " ") for k, v in value.items())
    if isinstance(value, list | tuple):
        return " and ".join(_sentence(one) for one in value)
    return f"{value:.5g}" if isinstance(value, float) else str(value)
