"""Report tables of errors, new meshes and the uniform alternative."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from contactfem.common.text import percent, report_table, shortened
from contactfem.common.unit_display import engineering

if TYPE_CHECKING:
    from rich.table import Table

PROBLEMS = ("mechanics", "heat", "time")
LARGEST = 1e9  # cells; a larger prediction says no more than that
SHOWN = 30  # of more new meshes, the first and the last are shown


def error_table(summary: Mapping[str, Any]) -> Table:
    """Table of the largest and the last errors, as ratios of norms and as (40) is printed.

    Args:
        summary: of one run.

    Returns:
        A row per problem; empty without adaptivity.
    """
    columns = ("largest", "last", "of squares (40),\nlargest", "last")
    table = report_table("Estimated errors", "of", *columns)
    found = [step["errors"] for step in summary["steps"] if step.get("errors")]
    for problem in PROBLEMS:
        rows = [errors for errors in found if errors[problem] is not None]
        if not rows:
            continue
        cells = [
            percent(value)
            for key in (problem, f"{problem}_printed")
            for value in (max(errors[key] for errors in rows), rows[-1][key])
        ]
        table.add_row(problem, *cells)
    return table


def remesh_table(summary: Mapping[str, Any]) -> Table:
    """Table of new meshes; the middle of many is left out.

    Args:
        summary: of one run.

    Returns:
        A row per mesh.
    """
    table = report_table("New meshes", "t", "problem", "body", "cells", "seconds", "error before")
    new = [one for s in summary["steps"] if s.get("errors") for one in s["errors"]["remeshes"]]
    for one in shortened(new, SHOWN):
        if one is None:
            table.add_row("...")
            continue
        cells = f"{one['cells_before']} to {one['cells_after']}"
        time, seconds = engineering(one["t"], "s", 4), f"{one['seconds']:.2f}"
        table.add_row(time, one["problem"], one["body"], cells, seconds, percent(one["eta"]))
    return table


def uniform_rows(summary: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """What the error of the last step would cost on the first mesh refined everywhere.

    Args:
        summary: of one run.

    Returns:
        Cells of a row per problem; empty where no mesh was replaced.
    """
    return [
        (
            cost["problem"],
            percent(cost["eta"]),
            str(cost["cells"]),
            percent(cost["first_eta"]),
            str(cost["first_cells"]),
            _rounded(cost["uniform_cells"]),
        )
        for cost in summary.get("uniform", ())
    ]


def _rounded(count: float | None) -> str:
    """A predicted count to two digits; a prediction that no computer could hold is cut short."""
    if count is None or count > LARGEST:
        return f"> {LARGEST:.0e}".replace("e+0", "e")
    places = max(len(f"{count:.0f}") - 2, 0)
    return f"{round(count, -places):.0f}"


def uniform_table(summary: Mapping[str, Any]) -> Table:
    """Table of what the error of the last step would cost on the first mesh refined everywhere.

    Args:
        summary: of one run.

    Returns:
        A row per problem; empty where no mesh was replaced.
    """
    columns = ("error reached", "cells", "first error", "first cells", "uniform cells\n(predicted)")
    table = report_table("The same error on a uniform mesh", "of", *columns)
    for row in uniform_rows(summary):
        table.add_row(*row)
    return table
