"""Summary of what a case models of heat."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from contactfem.case.temperature_scale import (
    doubtful_temperatures,
    responds_to_temperature,
    temperature_words,
)
from contactfem.common.time_table import Table

if TYPE_CHECKING:
    from contactfem.case.interface_laws import InterfaceHeat
    from contactfem.case.schema import Case

MATERIAL = ("density", "conductivity", "heat_capacity")


def heat_words(case: Case) -> Iterator[tuple[str, str]]:
    """Rows of what is modelled: heat, its meshes and interfaces, and keys that are not used.

    Args:
        case: the case.

    Yields:
        Title and text.
    """
    if case.heat is None:
        given = [name for name, body in case.bodies.items() if body.temperature is not None]
        yield "heat", f"off; temperature given in {', '.join(given)}" if given else "off"
    else:
        yield "heat", f"on: {_scheme(case)}, {_passes(case)}"
        own = [name for name, body in case.bodies.items() if body.thermal_mesh is not None]
        yield "thermal meshes", f"own in {', '.join(own)}" if own else "those of mechanics"
        for name, interface in case.interfaces.items():
            has_friction = interface.friction is not None or interface.heat.dissipation is not None
            yield f"heat at {name}", _interface(interface.heat, has_friction=has_friction)
    if case.heat is not None or any(body.temperature for body in case.bodies.values()):
        yield "temperatures", temperature_words(case)
        for text in doubtful_temperatures(case):
            yield "doubtful", text
    if unused := sorted(_unused(case)):
        yield "not used", ", ".join(unused)


def _scheme(case: Case) -> str:
    assert case.heat is not None
    if case.heat.scheme == "steady":
        return "steady"
    return f"{case.heat.scheme} in time"


def _passes(case: Case) -> str:
    assert case.heat is not None
    if not case.mechanics:
        return "without mechanics"
    if case.heat.max_passes is None and responds_to_temperature(case):
        return "in turn with mechanics as often as a step needs"
    if case.heat.max_passes in (None, 1):
        return "after the mechanics of each step"
    return f"in turn with mechanics, up to {case.heat.max_passes} passes"


def _interface(heat: InterfaceHeat, *, has_friction: bool) -> str:
    """Conductance and the share of frictional heat, in words."""
    h = heat.conductance
    uniform = isinstance(h, Table) and not h.times
    coefficient = h.values[0] if h is not None and uniform else "h(x, t)"
    laws = {
        "insulated": "insulated",
        "constant": f"h = {coefficient} W/m²/K in contact",
        "pressure": f"h = {coefficient} W/m²/K (p / {heat.hardness} Pa)^{heat.exponent}",
        "gas": f"h = {heat.gas_conductivity} W/m/K / (gap + {heat.gas_distance} m)",
    }
    law = laws.get(heat.law, f"h by {heat.law}")
    share = (
        f"; {100 * heat.partition:g} % of frictional heat into nonmortar" if has_friction else ""
    )
    return law + share


def _unused(case: Case) -> Iterator[str]:
    """Keys that are given but not used."""
    if case.heat is None:
        for material in case.materials.values():
            yield from {key for key in MATERIAL if getattr(material, key) is not None}
        bodies = ("thermal_mesh", "initial_temperature")
        yield from {
            k for body in case.bodies.values() for k in bodies if k in body.model_fields_set
        }
        yield from {"interface heat" for i in case.interfaces.values() if i.heat.conducts}
        yield from {"obstacle temperature" for o in case.obstacles.values() if o.temperature}
    if not case.mechanics:
        yield from {c.kind for c in case.conditions if not c.is_thermal}
