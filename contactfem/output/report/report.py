"""Show finished runs from their directories: steps, verdicts and what they cost."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contactfem.common.text import one_line, report_table, shortened
from contactfem.common.unit_display import engineering, scale_for
from contactfem.errors import ExitCode
from contactfem.output.report.adaptivity import error_table, remesh_table, uniform_table
from contactfem.output.tables import number, read_summary
from contactfem.results.measures import FLOOR_PHASES

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

Step = Mapping[str, Any]
SHOWN_STEPS = 40  # of more steps, the first and the last are shown
OTHER_PHASES = ("import", "mesh", "setup", "jit", "output")


def allowed_text(low: float | None, high: float | None, unit: str) -> str:
    """Say what values an expectation allows.

    Args:
        low: smallest allowed, None or infinite if there is none [unit].
        high: largest allowed, None or infinite if there is none [unit].
        unit: SI unit.

    Returns:
        For instance "9.07 .. 9.63 MPa" or "<= 0.045".
    """
    if low is None or math.isinf(low):
        return f"<= {engineering(number(high), unit)}"
    if high is None or math.isinf(high):
        return f">= {engineering(low, unit)}"
    scale = scale_for(max(abs(low), abs(high)), unit)
    middle, room = 0.5 * (low + high), 0.5 * (high - low)
    return f"{middle / scale.factor:.6g} ± {room / scale.factor:.3g} {scale.label}".rstrip()


def verdict_rows(summary: Mapping[str, Any]) -> list[tuple[str, str, str, bool]]:
    """What was expected and what was found.

    Args:
        summary: of one run.

    Returns:
        Name, found and allowed values, and whether it was met, of each expectation.
    """
    return [
        (
            verdict["key"],
            engineering(number(verdict["value"]), verdict["unit"], 7),
            allowed_text(verdict["low"], verdict["high"], verdict["unit"]),
            bool(verdict["passed"]),
        )
        for verdict in summary["verdicts"]
    ]


def verdict_table(summary: Mapping[str, Any]) -> Table:
    """Table of what was expected and what was found.

    Args:
        summary: of one run.

    Returns:
        A row per expectation.
    """
    table = report_table("Expected", "number", "found", "allowed", "")
    for *cells, met in verdict_rows(summary):
        table.add_row(*cells, "[green]met[/]" if met else "[bold red]missed[/]")
    return table


def verdict_lines(summary: Mapping[str, Any], *, colour: bool) -> list[str]:
    """The same table as lines of text, without the library that draws others, slow to load.

    Args:
        summary: of one run.
        colour: whether to mark what is met in green and what is missed in red.

    Returns:
        The lines; none where nothing was expected.
    """
    found = verdict_rows(summary)
    if not found:
        return []
    rows = [("number", "found", "allowed"), *(row[:3] for row in found)]
    wide = [max(len(row[k]) for row in rows) for k in range(3)]
    texts = [f" {row[0]:{wide[0]}}  {row[1]:>{wide[1]}}  {row[2]:>{wide[2]}}" for row in rows]
    words = {True: ("met", "32"), False: ("missed", "1;31")}
    marks = [words[row[3]] for row in found]
    shown = [f"\033[{code}m{word}\033[0m" if colour else word for word, code in marks]
    lines = [f"{text}  {mark}" for text, mark in zip(texts[1:], shown, strict=True)]
    return ["", texts[0], " " + "─" * (len(texts[0]) + 7), *lines]


def force_columns(summary: Mapping[str, Any]) -> list[tuple[str, str, Callable[[Step], str]]]:
    """Columns of the forces of all interfaces, in one unit.

    Args:
        summary: of one run.

    Returns:
        Name of the component, its unit, and the cell of a step.
    """
    steps = summary["steps"]
    sizes = [abs(number(f)) for step in steps for force in step["forces"].values() for f in force]
    unit = scale_for(max(sizes, default=0.0), summary.get("force_unit", "N/m"))

    def column(name: str, axis: int) -> tuple[str, str, Callable[[Step], str]]:
        def show(step: Step) -> str:
            return f"{number(step['forces'][name][axis]) / unit.factor:.5g}"

        return f"{name} F{'xyz'[axis]}", unit.label, show

    first = steps[0]["forces"] if steps else {}
    return [column(name, axis) for name, force in first.items() for axis in range(len(force))]


def step_table(summary: Mapping[str, Any]) -> Table:
    """Table of the accepted steps; the middle of many is left out.

    Args:
        summary: of one run.

    Returns:
        A row per step.
    """
    forces = force_columns(summary)
    titles = [f"{name}\n[{unit}]" for name, unit, _ in forces]
    counts = ("iter", "cuts", "residual", "open", "stick", "slip")
    table = report_table("Steps", "step", "t", *counts, *titles)
    for step in shortened(summary["steps"], SHOWN_STEPS):
        if step is None:
            table.add_row("...")
            continue
        residual = number(step["residuals"][-1] if step["residuals"] else None)
        table.add_row(
            str(step["step"]),
            engineering(step["t"], "s", 4),
            str(step["iterations"]),
            str(step["cutbacks"]),
            f"{residual:.1e}",
            *(str(step[name]) for name in ("open", "stick", "slip")),
            *(show(step) for _, _, show in forces),
        )
    return table


def heat_rows(summary: Mapping[str, Any]) -> list[tuple[str, float]]:
    """Where the heat of a run came from and went to.

    Args:
        summary: of one run.

    Returns:
        Name and heat since the start [J/m or J]; empty where heat was not solved for.
    """
    heat = [step["heat"] for step in summary["steps"] if step.get("heat")]
    if not heat:
        return []
    held: dict[str, float] = {}
    for step in heat:
        for name, value in step["held"].items():
            held[name] = held.get(name, 0.0) + value
    rows = [(f"through {name}", value) for name, value in held.items()]
    for key in ("friction", "loads", "obstacles", "strained", "stored", "defect"):
        rows.append((key, sum(number(step[key]) for step in heat)))
    return rows


def ringing_steps(summary: Mapping[str, Any]) -> int:
    """Number of steps in which the time scheme of heat rings.

    Args:
        summary: of one run.

    Returns:
        Their number.
    """
    return sum(bool((step.get("heat") or {}).get("rings")) for step in summary["steps"])


def heat_table(summary: Mapping[str, Any]) -> Table:
    """Table of where the heat of the run came from.

    Args:
        summary: of one run.

    Returns:
        A row per source; empty where heat was not solved for.
    """
    unit_name = summary.get("force_unit", "N/m").replace("N", "J")
    table = report_table("Heat", "", f"since the start [{unit_name}]")
    for name, value in heat_rows(summary):
        table.add_row(name, f"{value:.6g}")
    if rings := ringing_steps(summary):
        table.add_row("[bold red]steps in which the time scheme rings[/]", str(rings))
    return table


def cost_rows(summary: Mapping[str, Any]) -> list[tuple[str, float]]:
    """Seconds spent per phase, in the order in which they are told.

    Args:
        summary: of one run.

    Returns:
        Name, indented where it is a part of the one above, and seconds [s].
    """
    timings = summary["timings"]
    contact = [key for key in timings if key.startswith("contact.")]
    names = {phase: phase for phase in FLOOR_PHASES}
    names |= {"contact": "contact"} | {key: f"  {key.partition('.')[2]}" for key in contact}
    names |= {"newton": "whole solve phase"}
    names |= {key: key for key in timings if key.startswith("heat.")}
    names |= {phase: phase for phase in ("transfer", "estimate", "remesh", *OTHER_PHASES, "total")}
    rows = [(name, timings[key]) for key, name in names.items() if key in timings]
    floor = sum(key in timings for key in FLOOR_PHASES)
    return [*rows[:floor], ("= floor", summary["floor"]), *rows[floor:]]


def share_of_floor(name: str, seconds: float, summary: Mapping[str, Any]) -> str:
    """Seconds of a phase in percent of the floor; nothing where they do not compare.

    Args:
        name: of the phase, from `cost_rows`.
        seconds: spent in it [s].
        summary: of one run.

    Returns:
        The text; empty for phases outside of the solve, and where the floor is zero.
    """
    floor = summary["floor"]
    compares = floor and name not in (*OTHER_PHASES, "total")
    return f"{100.0 * seconds / floor:.0f} %" if compares else ""


def cost_table(summary: Mapping[str, Any]) -> Table:
    """Table of the seconds spent per phase, and their share of the floor.

    Args:
        summary: of one run.

    Returns:
        A row per phase.
    """
    table = report_table("Cost", "phase", "seconds", "of floor")
    for name, seconds in cost_rows(summary):
        table.add_row(name, f"{seconds:.3f}", share_of_floor(name, seconds, summary))
    return table


def _print_run(directory: Path, summary: Mapping[str, Any], console: Console) -> None:
    from rich.text import Text

    sizes = ", ".join(f"{value} {name}" for name, value in summary["sizes"].items())
    title = Text(one_line(summary["title"]), style="bold")
    console.print(title.append(f"  ({directory})", style="not bold"), highlight=False)
    console.print(f"{summary['command']}   [{sizes}]", markup=False, highlight=False)
    tables = (
        step_table(summary),
        heat_table(summary),
        error_table(summary),
        remesh_table(summary),
        uniform_table(summary),
        verdict_table(summary),
        cost_table(summary),
    )
    for table in tables:
        if table.row_count:
            console.print(table)
    if not summary["converged"]:
        console.print(f"The run stopped: {summary['message']}", markup=False, style="bold red")
    for warning in summary.get("warnings", ()):
        console.print(f"WARNING: {warning}", markup=False, style="yellow")


def _print_overview(rows: Sequence[tuple[Path, Mapping[str, Any]]], console: Console) -> None:
    from rich.markup import escape

    table = report_table("Runs", "directory", "steps", "iterations", "seconds", "met", "")
    for directory, summary in rows:
        verdicts = summary["verdicts"]
        met = sum(bool(verdict["passed"]) for verdict in verdicts)
        mark = "[green]passed[/]" if summary["passed"] else "[bold red]missed[/]"
        table.add_row(
            escape(str(directory)),
            str(len(summary["steps"])),
            str(summary["newton_iterations"]),
            f"{number(summary['timings'].get('total')):.2f}",
            f"{met} of {len(verdicts)}",
            mark,
        )
    console.print(table)


def report(directories: Sequence[Path], console: Console | None = None) -> int:
    """Print one run in full, or an overview and the misses of several.

    Args:
        directories: directories of finished runs.
        console: where to print, standard output by default.

    Returns:
        Exit code: 0 if every run came to its end and met what was expected of it, else 1.

    Raises:
        CaseError: if one of them is not a finished run.
    """
    from rich.console import Console
    from rich.text import Text

    console = Console() if console is None else console
    rows = [(directory, read_summary(directory)) for directory in directories]
    if len(rows) == 1:
        _print_run(*rows[0], console)
    else:
        _print_overview(rows, console)
        for directory, summary in rows:
            if not summary["passed"]:
                text = Text(str(directory), style="bold")
                console.print(text.append(f" {summary['message']}", style="not bold"))
                console.print(verdict_table(summary))
    passed = all(summary["passed"] for _, summary in rows)
    return ExitCode.DONE if passed else ExitCode.MISSED
