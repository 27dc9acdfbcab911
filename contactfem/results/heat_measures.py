"""Measure heat on a finished run: temperatures, flows and the balance."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from contactfem.common.typing import Floats
from contactfem.geometry.cells import cell_areas
from contactfem.results.data import BodyPicture, HeatStep, InterfaceTable, StepReport

if TYPE_CHECKING:
    from contactfem.case.schema import Case

BODY_UNITS = {
    "temperature.min": "K",
    "temperature.max": "K",
    "temperature.mean": "K",
    "heat_flux.max": "W/m^2",
}
INTERFACE_UNITS = {
    "temperature_max": "K",
    "temperature_min": "K",
    "mortar_temperature_max": "K",
    "mortar_temperature_min": "K",
    "heat_flux_max": "W/m^2",
    "heat_flux_min": "W/m^2",
    "dissipation_max": "W/m^2",
    "heat_flow": "W/m",
}
RUN_UNITS = {
    "heat.stored": "J/m",
    "heat.loads": "J/m",
    "heat.friction": "J/m",
    "heat.obstacles": "J/m",
    "heat.strained": "J/m",
    "heat.temperature_max": "K",
    "heat.temperature_min": "K",
    "heat.balance_defect": "",
    "heat.friction_defect": "",
    "heat.passes.max": "",
    "heat.outside": "",
    "heat.ringing_steps": "",
    "cost.heat_to_newton": "",
    "cost.transfer_share": "",
}


def measurable_heat(case: Case) -> dict[str, str]:
    """Names of all numbers about heat that a run of the case can measure, with their SI units."""
    if case.heat is None:
        return {}
    names = dict(RUN_UNITS)
    for body in case.bodies:
        names |= {f"{body}.{key}": unit for key, unit in BODY_UNITS.items()}
    for interface in case.interfaces:
        names |= {f"{interface}.{key}": unit for key, unit in INTERFACE_UNITS.items()}
    for condition in case.conditions:
        if condition.temperature is not None:
            names[f"heat.held.{condition.on}"] = "J/m"
    return names


def heat_of_steps(steps: Sequence[StepReport]) -> dict[str, float]:
    """Sums and extremes over the steps."""
    found = [step.heat for step in steps if step.heat is not None]
    if not found:
        return {}
    sums = ("stored", "loads", "friction", "obstacles", "strained")
    values = {f"heat.{key}": float(sum(getattr(step, key) for step in found)) for key in sums}
    for step in found:
        for name, heat in step.held.items():
            values[f"heat.held.{name}"] = values.get(f"heat.held.{name}", 0.0) + heat
    return values | {
        "heat.temperature_max": max(step.temperature_max for step in found),
        "heat.temperature_min": min(step.temperature_min for step in found),
        "heat.balance_defect": balance_defect(found),
        "heat.friction_defect": max(step.friction_defect for step in found),
        "heat.outside": max(step.outside for step in found),
        "heat.passes.max": float(max(step.passes for step in found)),
        "heat.ringing_steps": float(sum(bool(step.rings) for step in found)),
    }


def balance_defect(steps: Sequence[HeatStep]) -> float:
    """Largest of what steps stored but came from nowhere, over the most heat moved until then [-].

    A step in which next to nothing moves any more has a defect of round-off of all that is stored.
    """
    largest = most = 0.0
    for step in steps:
        most = max(most, moved(step))
        largest = max(largest, abs(step.defect) / most if most > 0.0 else 0.0)
    return largest


def moved(step: HeatStep) -> float:
    """Heat that moved in a step: that came in or out, or went from one place to another [J/m]."""
    parts = (step.moved, step.stored, step.loads, step.friction, step.obstacles, step.strained)
    return max(abs(part) for part in (*parts, *step.held.values()))


def heat_of_costs(timings: dict[str, float], steps: Sequence[StepReport]) -> dict[str, float]:
    """Cost of the thermal phase against one Newton solve, and of transfers against a step."""
    passes = sum(step.heat.passes for step in steps if step.heat is not None)
    newton, total = timings.get("newton", 0.0), sum(step.wall for step in steps)
    if not passes or total == 0.0:
        return {}
    heat = sum(seconds for phase, seconds in timings.items() if is_thermal(phase))
    values = {"cost.transfer_share": timings.get("transfer", 0.0) / total}
    return values | ({"cost.heat_to_newton": heat / newton} if newton > 0.0 else {})


def is_thermal(phase: str) -> bool:
    """Whether a phase belongs to the solution of the heat problem."""
    return phase.startswith("heat.") and phase != "heat.setup"


def heat_of_interface(table: InterfaceTable) -> dict[str, float]:
    """Extremes along an interface, where something is opposite."""
    if table.heat is None:
        return {}
    columns = {
        "temperature": table.heat.temperature,
        "mortar_temperature": table.heat.mortar_temperature,
        "heat_flux": table.heat.flux,
    }
    values = {}
    for name, column in columns.items():
        seen = column[np.isfinite(column)]
        values[f"{name}_max"] = float(seen.max()) if len(seen) else math.nan
        values[f"{name}_min"] = float(seen.min()) if len(seen) else math.nan
    values["dissipation_max"] = float(np.nanmax(table.heat.dissipation, initial=0.0))
    return values


def heat_of_body(body: BodyPicture) -> dict[str, float]:
    """Extremes of a body's temperature and flux, and its mean temperature over the nodes."""
    theta = body.fields["temperature"][:, 0]
    flux = np.linalg.norm(body.fields["heat_flux"], axis=1)
    return {
        "temperature.min": float(theta.min()),
        "temperature.max": float(theta.max()),
        "temperature.mean": mean_over_area(body, theta),
        "heat_flux.max": float(flux.max()),
    }


def mean_over_area(body: BodyPicture, values: Floats) -> float:
    """Mean of a nodal field over the reference area of a plane body, exact for parallelograms."""
    area = cell_areas(body.points, body.cells)
    return float(area @ values[body.cells].mean(axis=1) / area.sum())
