"""Scale of the temperatures of a case: absolute, or rises."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from contactfem.common.time_table import Table, constant
from contactfem.common.unit_parser import UnitError, has_zero, split
from contactfem.common.user_function import is_reference

if TYPE_CHECKING:
    from contactfem.case.materials import Material
    from contactfem.case.schema import Case
    from contactfem.common.units import Given

ROOM = (250.0, 400.0)  # [K] rises of this size are more likely absolute temperatures
COLD = 100.0  # [K] absolute temperatures below are more likely rises


def is_absolute(case: Case) -> bool:
    """Whether temperatures are absolute: a material has a reference, or one is on a scale."""
    return bool(_references(case)) or next(_on_scale(case.contents), None) is not None


def reference_temperature(material: Material) -> float:
    """Temperature that expansion counts from [K]; 0 where temperatures are rises."""
    return material.reference_temperature or 0.0


def initial_temperature(case: Case, body: str) -> Given:
    """Temperature that a body starts from: given, or that of its stress-free state [K]."""
    given = case.bodies[body].initial_temperature
    return _stress_free(case, body) if given is None else given


def given_temperature(case: Case, body: str) -> Table:
    """Temperature of a body over time where heat is not solved for [K]."""
    given = case.bodies[body].temperature
    return _stress_free(case, body) if given is None else given


def _stress_free(case: Case, body: str) -> Table:
    return constant(reference_temperature(case.materials[case.bodies[body].main_material]))


def responds_to_temperature(case: Case) -> bool:
    """Whether mechanics depends on temperatures: by expansion, friction or a user's law."""
    materials = [case.materials[m] for body in case.bodies.values() for m in body.all_materials]
    frictions = [i.friction for i in case.interfaces.values() if i.friction is not None]
    tables = [friction.coefficient_table for friction in frictions]
    return (
        any(material.expansion or material.model != "neo-hooke" for material in materials)
        or any(is_reference(friction.law) for friction in frictions)
        or any(table is not None and table.variable == "temperature" for table in tables)
    )


def broken_temperatures(case: Case) -> Iterator[str]:
    """What mixes absolute temperatures with rises.

    Args:
        case: the case, each table of which is right by itself.

    Yields:
        One line "dotted.key = found: what is wrong" per mistake.
    """
    if not is_absolute(case):
        return
    why = f"temperatures of this case are absolute ({_why(case)})"
    used = {m for body in case.bodies.values() for m in body.all_materials} & case.materials.keys()
    for name in sorted(used):
        material = case.materials[name]
        if case.mechanics and material.expansion and material.reference_temperature is None:
            yield (
                f"materials.{name}: {why}; give its reference_temperature, that expansion counts "
                "from"
            )
    for name, body in case.bodies.items() if case.heat is not None else ():
        unknown = body.main_material in used and (
            case.materials[body.main_material].reference_temperature is None
        )
        if unknown and body.initial_temperature is None:
            yield f"bodies.{name}: {why}; give its initial_temperature, or its material a reference"
    for number, condition in enumerate(case.conditions):
        convection = condition.convection
        if convection is not None and "ambient" not in convection.model_fields_set:
            yield f"conditions.{number}.convection: {why}; give the ambient temperature"
    for key, value in _temperatures(case):
        if value <= 0.0:
            yield f"{key} = {value:g} K: {why}, and this is not above absolute zero"


def doubtful_temperatures(case: Case) -> Iterator[str]:
    """Temperatures that are more likely meant on the other scale; a sentence about each."""
    absolute = is_absolute(case)
    expands = case.mechanics and any(
        case.materials[m].expansion for body in case.bodies.values() for m in body.all_materials
    )
    for key, value in _temperatures(case) if expands else ():
        if absolute and 0.0 < value < COLD:
            yield f"{key}: {value:g} K is read as absolute, as a reference_temperature is given"
        if not absolute and ROOM[0] <= value <= ROOM[1]:
            yield (
                f"{key}: {value:g} K is read as a rise above the stress-free state; "
                "is it absolute? then give materials a reference_temperature"
            )


def temperature_words(case: Case) -> str:
    """What temperatures are, in a few words."""
    if not is_absolute(case):
        return "rises above the stress-free state (no reference_temperature)"
    found = sorted(set(_references(case).values()))
    counts = ", ".join(f"{value:g} K ({value - 273.15:.4g} °C)" for value in found)
    return f"absolute; expansion counts from {counts}" if found else "absolute"


def _references(case: Case) -> dict[str, float]:
    """Reference temperatures of the materials that bodies are made of [K]."""
    used = {m for body in case.bodies.values() for m in body.all_materials}
    return {
        name: material.reference_temperature
        for name, material in case.materials.items()
        if name in used and material.reference_temperature is not None
    }


def _why(case: Case) -> str:
    for name, value in _references(case).items():
        return f"materials.{name}.reference_temperature = {value:g} K"
    return f"as {next(_on_scale(case.contents))}"


def _on_scale(contents: object, key: str = "") -> Iterator[str]:
    """Keys and texts of a file's contents that are on a scale with its own zero, as "20 degC"."""
    if isinstance(contents, dict):
        for name, value in contents.items():
            if name not in ("variants", "abs", "least_temperature", "title"):
                yield from _on_scale(value, f"{key}.{name}" if key else str(name))
    elif isinstance(contents, list | tuple):
        for number, value in enumerate(contents):
            yield from _on_scale(value, f"{key}.{number}")
    elif isinstance(contents, str):
        try:
            if has_zero(split(contents)[1]):
                yield f"{key} = {contents}"
        except UnitError:
            return


def _temperatures(case: Case) -> Iterator[tuple[str, float]]:
    """All given temperatures with their keys: the lowest and highest of each table [K]."""
    given: list[tuple[str, object]] = []
    for name, body in case.bodies.items():
        kind = "temperature" if case.heat is None else "initial_temperature"
        given.append((f"bodies.{name}.{kind}", getattr(body, kind)))
    if case.heat is not None:
        for number, condition in enumerate(case.conditions):
            key = f"conditions.{number}"
            given.append((f"{key}.temperature", condition.temperature))
            if condition.convection is not None:
                given.append((f"{key}.convection.ambient", condition.convection.ambient))
        given += [(f"obstacles.{k}.temperature", o.temperature) for k, o in case.obstacles.items()]
    for key, value in given:
        if isinstance(value, Table):
            yield from {(key, min(value.values)): None, (key, max(value.values)): None}
