"""Checks of the keys that heat needs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from contactfem.case.temperature_scale import broken_temperatures
from contactfem.common.text import nearest
from contactfem.common.user_function import FunctionRef, is_reference, reference
from contactfem.meshes import MeshFile

if TYPE_CHECKING:
    from contactfem.case.schema import Case


def broken_heat(case: Case) -> Iterator[str]:
    """Everything about heat that one table alone cannot tell.

    Args:
        case: the case, each table of which is right by itself.

    Yields:
        One line "dotted.key = found: what is wrong" per mistake.
    """
    yield from broken_temperatures(case)
    yield from _functions(case)
    if case.heat is None:
        yield from _without(case)
        return
    for name, body in case.bodies.items():
        if "temperature" in body.model_fields_set:
            yield (
                f"bodies.{name}.temperature: is solved for; give initial_temperature, or leave "
                "[heat] out"
            )
        yield from _thermal_mesh(case, name)
    yield from _materials(case)
    yield from _interfaces(case)
    if case.heat.scheme == "steady":
        yield from _loose(case)
    yield from _probes(case)


def _without(case: Case) -> Iterator[str]:
    for number, condition in enumerate(case.conditions):
        if condition.is_thermal:
            yield f"conditions.{number}.{condition.kind}: heat is not solved for; add [heat]"
    if not case.mechanics:
        yield "mechanics = false: leaves nothing to solve; add [heat]"


def _materials(case: Case) -> Iterator[str]:
    assert case.heat is not None
    needed = ["conductivity"]
    if case.heat.scheme != "steady":
        needed += ["density", "heat_capacity"]
    if case.heat.thermoelastic:
        needed += ["reference_temperature"]
    for name in sorted({body.material for body in case.bodies.values()} & case.materials.keys()):
        missing = [key for key in needed if getattr(case.materials[name], key) is None]
        if missing:
            yield f"materials.{name}: heat needs {', '.join(missing)}"


def _interfaces(case: Case) -> Iterator[str]:
    for name, sides in case.interfaces.items():
        key = f"interfaces.{name}.heat"
        asks = sides.heat.law == "pressure" or is_reference(sides.heat.law)
        if not case.mechanics and asks and sides.heat.pressure is None:
            yield f"{key}: without mechanics law = '{sides.heat.law}' needs a pressure"


def _probes(case: Case) -> Iterator[str]:
    """What only bodies that move have."""
    for name, probe in case.probes.items():
        if not case.mechanics and probe.value != "temperature":
            yield f"probes.{name}.value = {probe.value}: bodies do not move (mechanics = false)"


def _loose(case: Case) -> Iterator[str]:
    """Bodies whose temperature nothing can hold, themselves or through a contact that conducts."""
    held = {c.body for c in case.conditions if c.kind in ("temperature", "convection")}
    pairs = []
    for sides in case.interfaces.values():
        ends = [side.partition(".")[0] for side in (sides.nonmortar, sides.mortar)]
        if sides.heat.conducts:
            if sides.mortar not in case.obstacles:
                pairs.append(ends)
            elif case.obstacles[sides.mortar].temperature is not None:
                held.add(ends[0])
    for _ in case.bodies:  # as long as a chain of bodies can be
        held |= {end for ends in pairs if not held.isdisjoint(ends) for end in ends}
    for name in sorted(case.bodies.keys() - held):
        yield (
            f"bodies.{name}: nothing holds its temperature, as scheme = 'steady' needs; give a "
            "temperature or convection, or a contact that conducts"
        )


def _thermal_mesh(case: Case, name: str) -> Iterator[str]:
    """Check a body's thermal mesh: dimension, and the surfaces that heat needs."""
    mesh = case.bodies[name].thermal_mesh
    if mesh is None or isinstance(mesh, MeshFile):
        return
    key = f"bodies.{name}.thermal_mesh"
    if (axes := len(mesh.extent()[0])) != case.axes:
        yield f"{key}: is in {axes}D; dimension = {case.dimension}"
    known = list(mesh.outline())
    named = [(f"conditions.{k}.on", c.on) for k, c in enumerate(case.conditions) if c.is_thermal]
    for interface, sides in case.interfaces.items():
        named += [(f"interfaces.{interface}", side) for side in (sides.nonmortar, sides.mortar)]
    for where, on in named:
        owner, dot, surface = on.partition(".")
        if owner == name and dot and surface not in known:
            yield f"{key}: has no surface '{surface}', which {where} names{nearest(surface, known)}"


def _conditions(case: Case) -> Iterator[tuple[str, object]]:
    """Values of all conditions with their keys."""
    for number, condition in enumerate(case.conditions):
        key = f"conditions.{number}.{condition.kind}"
        yield key, condition.field or condition.pressure
        for group in (condition.displacement, condition.traction, condition.body_force):
            yield from ((f"{key}.{axis}", value) for axis, value in (group or {}).items())


def _functions(case: Case) -> Iterator[str]:
    """Check that the files of functions exist."""
    named: list[tuple[str, object]] = [
        (f"bodies.{name}.initial_temperature", body.initial_temperature)
        for name, body in case.bodies.items()
    ]
    named += [
        (f"interfaces.{name}.heat.conductance", sides.heat.conductance)
        for name, sides in case.interfaces.items()
    ]
    named += [
        (f"interfaces.{name}.heat.law", reference(sides.heat.law))
        for name, sides in case.interfaces.items()
        if is_reference(sides.heat.law)
    ]
    for key, value in (*named, *_conditions(case)):
        if isinstance(value, FunctionRef) and not (case.path.parent / value.file).is_file():
            yield f"{key} = {value}: there is no file '{value.file}'"
