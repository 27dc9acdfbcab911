"""Report tables of errors, new meshes and the uniform alternative."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from contactfem.common.report_table import new_table
from contactfem.common.unit_display import engineering

if TYPE_CHECKING:
    from rich.table import Table

PROBLEMS = ("mechanics", "heat", "time")
SHOWN = 30  # of more new meshes, the first and the last are shown


def error_table(summary: Mapping[str, Any]) -> Table:
    """Table of the largest and the last errors, as ratios of norms and as (40) is printed.

    Args:
        summary: of one run.

    Returns:
        A row per problem; empty without adaptivity.
    """
    columns = ("largest", "last", "of squares (40),\nlargest", "last")
    table = new_table("Estimated errors", "of", *columns)
    found = [step["errors"] for step in summary["steps"] if step.get("errors")]
    for problem in PROBLEMS:
        rows = [errors for errors in found if errors[problem] is not None]
        if not rows:
            continue
        cells = [
            _percent(value)
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
    table = new_table("New meshes", "t", "problem", "body", "cells", "seconds", "error before")
    new = [one for s in summary["steps"] if s.get("errors") for one in s["errors"]["remeshes"]]
    half = SHOWN // 2
    for one in new if len(new) <= SHOWN else [*new[:half], None, *new[-half:]]:
        if one is None:
            table.add_row("...")
            continue
        cells = f"{one['cells_before']} to {one['cells_after']}"
        time, seconds = engineering(one["t"], "s", 4), f"{one['seconds']:.2f}"
        table.add_row(time, one["problem"], one["body"], cells, seconds, _percent(one["eta"]))
    return table


def uniform_table(summary: Mapping[str, Any]) -> Table:
    """Table of what the error of the last step would cost on the first mesh refined everywhere.

    Args:
        summary: of one run.

    Returns:
        A row per problem; empty where no mesh was replaced.
    """
    columns = ("error reached", "cells", "first error", "first cells", "uniform cells\n(predicted)")
    table = new_table("The same error on a uniform mesh", "of", *columns)
    for cost in summary.get("uniform", ()):
        table.add_row(
            cost["problem"],
            _percent(cost["eta"]),
            str(cost["cells"]),
            _percent(cost["first_eta"]),
            str(cost["first_cells"]),
            f"{cost['uniform_cells']:.0f}",
        )
    return table


def _percent(value: float) -> str:
    return f"{100.0 * value:.3g} %"
