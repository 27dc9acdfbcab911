"""Named numbers of a finished run, which a case can expect."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from contactfem.common.typing import Floats
from contactfem.results.data import BodyPicture, InterfaceTable, RunResult, Status, StepReport
from contactfem.results.error_measures import errors_of_costs, errors_of_steps, measurable_errors
from contactfem.results.heat_measures import (
    heat_of_body,
    heat_of_costs,
    heat_of_interface,
    heat_of_steps,
    measurable_heat,
)
from contactfem.results.profiles import carriers, error_l2, linearised, position_of, value_at, zone
from contactfem.verification.contact import ContactSolution, closed_form

if TYPE_CHECKING:
    from contactfem.case.schema import Case

COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "xz")
ACTIVE = (Status.STICK, Status.SLIP)
FLOOR_PHASES = ("residual", "assembly", "factorisation", "solve")
CORE = 0.9  # share of the contact half-width away from the singular slope at its edge

INTERFACE_UNITS = {
    "pressure_max": "Pa",
    "pressure_min": "Pa",
    "pressure_at_center": "Pa",
    "traction_max": "Pa",
    "mortar_pressure_max": "Pa",
    "mortar_pressure_at_center": "Pa",
    "normal_force": "N/m",
    "tangential_force": "N/m",
    "force_x": "N/m",
    "force_y": "N/m",
    "contact_half_width": "m",
    "contact_edge_min": "m",
    "contact_edge_max": "m",
    "stick_half_width": "m",
    "stick_edge_min": "m",
    "stick_edge_max": "m",
    "gap_min": "m",
    "slip_max": "m",
    "moment_defect": "",
    "active": "",
    "stick": "",
    "slip": "",
}
# Measured in the plane only
ALONG_A_LINE = ("contact_", "stick_", "pressure_at_", "mortar_pressure_at_")
CLOSED_FORM_UNITS = {
    "pressure_error_l2": "",
    "pressure_error_l2_core": "",
    "pressure_error_max": "",
    "traction_error_l2": "",
    "traction_error_max": "",
    "mortar_pressure_error_l2": "",
}
BODY_UNITS = {f"stress_{c}": "Pa" for c in (*COMPONENTS, "von_mises")} | {
    f"displacement_{c}": "m" for c in "xy"
}
RUN_UNITS = {
    "steps": "",
    "cutbacks": "",
    "converged": "",
    "iterations.max": "",
    "iterations.mean": "",
    "dissipation": "J/m",
    "cost.solve_to_floor": "",
    "cost.contact_share": "",
}


def measurable(case: Case) -> dict[str, str]:
    """List the names of all numbers that a run of the case can measure.

    Args:
        case: the case.

    Returns:
        SI unit of each name, "" where it has none or it is not known.
    """
    names = dict(RUN_UNITS)
    by_length = {unit: case.force_unit.replace("N", unit[0]) for unit in ("N/m", "J/m", "W/m")}
    of_interface = INTERFACE_UNITS
    if case.axes == 3:
        of_interface = {k: u for k, u in of_interface.items() if not k.startswith(ALONG_A_LINE)}
        of_interface = of_interface | {"force_z": "N/m", "contact_area": "m^2", "stick_area": "m^2"}
    for interface in case.interfaces:
        units = of_interface | (CLOSED_FORM_UNITS if interface in case.closed_form else {})
        names |= {f"{interface}.{key}": unit for key, unit in units.items()}
    for body in case.bodies if case.mechanics else ():
        for end in ("min", "max"):
            names |= {f"{body}.{key}.{end}": unit for key, unit in BODY_UNITS.items()}
    for name, probe in case.probes.items():
        kind = str(probe.value).split(".")[0]
        units = {"displacement": "m", "stress": "Pa", "temperature": "K"}
        names[f"probe.{name}"] = units.get(kind, "")
    names |= measurable_heat(case) | measurable_errors(case)
    return {name: by_length.get(unit, unit) for name, unit in names.items()}


def floor_seconds(timings: Mapping[str, float]) -> float:
    """Add up what the iterations would cost without contact: `FLOOR_PHASES`.

    Args:
        timings: seconds per phase [s].

    Returns:
        The floor of the run [s].
    """
    return sum(timings.get(phase, 0.0) for phase in FLOOR_PHASES)


def _of_steps(steps: Sequence[StepReport]) -> dict[str, float]:
    iterations = [float(step.iterations) for step in steps] or [math.nan]
    return {
        "steps": float(len(steps)),
        "cutbacks": float(sum(step.cutbacks for step in steps)),
        "iterations.max": max(iterations),
        "iterations.mean": float(np.mean(iterations)),
        "dissipation": float(sum(step.dissipation for step in steps)),
    }


def _of_costs(timings: Mapping[str, float]) -> dict[str, float]:
    floor, contact = floor_seconds(timings), timings.get("contact", 0.0)
    if floor == 0.0:
        return {}
    whole = timings.get("newton", floor + contact)
    return {"cost.solve_to_floor": whole / floor, "cost.contact_share": contact / floor}


def _edges(table: InterfaceTable, name: str, members: Sequence[Status]) -> dict[str, float]:
    ends = zone(table, members)
    if ends is None:
        return {
            f"{name}_half_width": 0.0,
            f"{name}_edge_min": math.nan,
            f"{name}_edge_max": math.nan,
        }
    x = sorted(value_at(table.X[:, 0], end) for end in ends)
    arcs = [value_at(table.arc, end) for end in ends]
    return {
        f"{name}_half_width": 0.5 * (arcs[1] - arcs[0]),
        f"{name}_edge_min": x[0],
        f"{name}_edge_max": x[1],
    }


def _at_center(
    table: InterfaceTable, pressure: Floats, solution: ContactSolution | None
) -> dict[str, float]:
    """Pressures in the middle: of the closed form if there is one, else of the contact."""
    if solution is not None:
        where = position_of(table.X[:, 0], solution.center)
    else:
        ends = zone(table, ACTIVE)
        where = math.nan if ends is None else 0.5 * sum(ends)
    found = {"pressure_at_center": value_at(pressure, where)}
    if len(table.mortar_x) and not math.isnan(where):
        order = np.argsort(table.mortar_x[:, 0])
        there = value_at(table.x[:, 0], where)
        values = np.interp(there, table.mortar_x[order, 0], table.mortar_pressure[order])
        found["mortar_pressure_at_center"] = float(values)
    return found


def _of_interface(
    table: InterfaceTable, solution: ContactSolution | None, small_strain: bool
) -> dict[str, float]:
    active = np.isin(table.status, ACTIVE)
    carrier = carriers(table)
    pressure = table.pressure[carrier]
    weights = table.coverage * table.facet_length * table.depth
    faced = np.isfinite(table.gap)
    values = {
        "pressure_max": float(np.max(table.pressure, where=active, initial=0.0)),
        "pressure_min": float(table.pressure[active].min()) if active.any() else math.nan,
        "traction_max": float(np.max(np.abs(table.traction), where=active, initial=0.0)),
        "normal_force": float(weights @ table.pressure),
        "tangential_force": _tangential_force(table, weights),
        "gap_min": float(table.gap[faced].min()) if faced.any() else math.nan,
        "slip_max": float(np.abs(table.slip).max()),
        "active": float(active.sum()),
        "stick": float((table.status == Status.STICK).sum()),
        "slip": float((table.status == Status.SLIP).sum()),
    }
    if len(table.mortar_pressure):
        values["mortar_pressure_max"] = float(table.mortar_pressure.max())
    if table.X.shape[1] == 3:
        return values | {
            "contact_area": float(weights[active].sum()),
            "stick_area": float(weights[table.status == Status.STICK].sum()),
        }
    values |= _edges(table, "contact", ACTIVE) | _edges(table, "stick", (Status.STICK,))
    values |= _at_center(table, pressure, solution)
    if solution is not None:
        along_x = math.isfinite(solution.half_width)  # not so a uniform pressure on any surface
        values |= _errors(
            linearised(table) if small_strain and along_x else table, active, solution
        )
    return values


def _tangential_force(table: InterfaceTable, weights: Floats) -> float:
    """Resultant of the tangential multipliers along the surface, in space its size [N/m]."""
    if table.traction_vector is None:
        return float(weights @ table.traction)
    return float(np.linalg.norm(weights @ table.traction_vector))


def _errors(
    table: InterfaceTable,
    active: np.ndarray[tuple[int, ...], np.dtype[np.bool_]],
    solution: ContactSolution,
) -> dict[str, float]:
    """Distances from the closed form; nodal ones are relative to its largest nodal value."""
    X, carrier = table.X, carriers(table)
    pressure, traction = table.pressure[carrier], table.traction[carrier]
    core = CORE * solution.half_width
    values = {
        "pressure_error_l2": error_l2(X, pressure, solution.pressure, solution),
        "pressure_error_l2_core": error_l2(X, pressure, solution.pressure, solution, core),
        "traction_error_l2": error_l2(X, traction, solution.traction, solution),
    }
    for name, found, profile in (
        ("pressure", table.pressure, solution.pressure),
        ("traction", table.traction, solution.traction),
    ):
        exact = profile(X[:, 0])
        largest = float(np.abs(exact).max())
        distance = float(np.max(np.abs(found - exact), where=active, initial=0.0))
        values[f"{name}_error_max"] = distance / largest if largest else math.nan
    if len(table.mortar_x) > 1:
        order = np.argsort(table.mortar_x[:, 0])
        values["mortar_pressure_error_l2"] = error_l2(
            table.mortar_x[order], table.mortar_pressure[order], solution.pressure, solution
        )
    return values


def von_mises(stress: Floats) -> Floats:
    """Von Mises stress, σ_v² = 3/2 s:s with the deviator s.

    Args:
        stress: xx, yy, zz, xy, yz, xz (n, 6) [Pa].

    Returns:
        σ_v (n,) [Pa].
    """
    normal = stress[:, :3]
    differences = np.sum((normal - np.roll(normal, 1, axis=1)) ** 2, axis=1)
    result: Floats = np.sqrt(0.5 * differences + 3.0 * np.sum(stress[:, 3:] ** 2, axis=1))
    return result


def _of_body(body: BodyPicture) -> dict[str, float]:
    fields = {f"displacement_{c}": body.displacement[:, i] for i, c in enumerate("xy")}
    if "stress" in body.fields:
        stress = body.fields["stress"]
        fields |= {f"stress_{c}": stress[:, i] for i, c in enumerate(COMPONENTS)}
        fields["stress_von_mises"] = von_mises(stress)
    ends = {f"{key}.min": float(field.min()) for key, field in fields.items()}
    return ends | {f"{key}.max": float(field.max()) for key, field in fields.items()}


def measure(result: RunResult) -> dict[str, float]:
    """Measure every number that can be expected of a run.

    Args:
        result: the run.

    Returns:
        Values by name [SI]; names as listed by `measurable`.
    """
    values = _of_steps(result.steps) | _of_costs(result.timings)
    values |= heat_of_steps(result.steps) | heat_of_costs(result.timings, result.steps)
    values |= errors_of_steps(result.steps) | errors_of_costs(result.timings, result.steps)
    values["converged"] = float(result.converged)
    for table in result.interfaces:
        entry = result.case.closed_form.get(table.name)
        solution = closed_form(entry.solution, entry.parameters) if entry else None
        found = _of_interface(table, solution, result.case.strain == "small")
        if result.steps and table.name in result.steps[-1].forces:
            force = result.steps[-1].forces[table.name]
            found |= {f"force_{a}": part for a, part in zip("xyz", force, strict=False)}
            found["moment_defect"] = result.steps[-1].moment_defects.get(table.name, math.nan)
        found |= heat_of_interface(table)
        values |= {f"{table.name}.{key}": value for key, value in found.items()}
    if result.steps and result.steps[-1].heat is not None:
        flows = result.steps[-1].heat.flow
        values |= {f"{name}.heat_flow": flow for name, flow in flows.items()}
    for body in result.heat:
        values |= {f"{body.name}.{key}": value for key, value in heat_of_body(body).items()}
    for body in result.bodies:
        values |= {f"{body.name}.{key}": value for key, value in _of_body(body).items()}
    return values | {f"probe.{name}": value for name, value in result.probes.items()}
