"""Checks of names and dimensions across the tables of a case."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from contactfem.case.adaptivity_checks import broken_adaptivity
from contactfem.case.base import AXES
from contactfem.case.cell_materials import broken_cell_materials
from contactfem.case.conflicting_conditions import contradictions
from contactfem.case.element_choice import SIMPLICES
from contactfem.case.heat_checks import broken_heat
from contactfem.case.material_library import LIBRARY
from contactfem.case.obstacles import Plane
from contactfem.case.scene import IN_VOLUME
from contactfem.common.text import nearest
from contactfem.meshes import MeshFile

if TYPE_CHECKING:
    from contactfem.case.scene import Condition, Interface
    from contactfem.case.schema import Case


SHAPES = {2: ("plane", "circle", "polyline"), 3: ("plane", "sphere", "cylinder", "surface")}
NEAR = 1e-6  # relative to the body's size


def broken_links(case: Case) -> list[str]:
    """Everything about a case that one table alone cannot tell.

    Args:
        case: the case, each table of which is right by itself.

    Returns:
        One line "dotted.key = found: what is wrong" per mistake.
    """
    lines = [
        *_bodies(case),
        *_obstacles(case),
        *_interfaces(case),
        *_conditions(case),
        *_probes(case),
        *_names(case),
        *broken_heat(case),
    ]
    lines += [] if lines else broken_adaptivity(case)
    return lines or list(contradictions(case))


def groups(case: Case, body: str) -> list[str] | None:
    """Surfaces of a body; None if only its mesh file knows."""
    mesh = case.bodies[body].mesh
    return None if isinstance(mesh, MeshFile) else list(mesh.outline())


def _unknown(key: str, found: str, what: str, known: Iterable[str]) -> str:
    return f"{key} = {found}: there is no {what} '{found}'{nearest(found, list(known))}"


def _surface(case: Case, key: str, on: str) -> Iterator[str]:
    """Check "body.surface"."""
    body, dot, surface = on.partition(".")
    if body not in case.bodies:
        yield f"{key} = {on}: there is no body '{body}'{nearest(body, list(case.bodies))}"
    elif not dot:
        yield f"{key} = {on}: must be 'body.surface'"
    elif (known := groups(case, body)) is not None and surface not in known:
        yield f"{key} = {on}: '{body}' has no surface '{surface}'{nearest(surface, known)}"


def _bodies(case: Case) -> Iterator[str]:
    for name, body in case.bodies.items():
        key = f"bodies.{name}"
        named = {"material": body.material} if body.material is not None else {}
        named |= {f"materials.{group}": material for group, material in body.materials.items()}
        unknown = [(at, found) for at, found in named.items() if found not in case.materials]
        for at, found in unknown:
            known = [*case.materials, *LIBRARY]
            yield _unknown(f"{key}.{at}", found, "material", known)
        if not isinstance(body.mesh, MeshFile):
            low = body.mesh.extent()[0]
            if len(low) != case.axes:
                yield f"{key}.mesh: is in {len(low)}D; dimension = {case.dimension}"
            elif case.axisymmetric and low[0] < 0.0:
                yield f"{key}.mesh: reaches to x = {low[0]:g} m; x is the distance from the axis"
        if not unknown:
            yield from broken_cell_materials(case, name)
            yield from _element(case, name)
    for name, material in case.materials.items():
        file = material.model.rpartition(":")[0]
        if file and not (case.path.parent / file).is_file():
            yield f"materials.{name}.model = {material.model}: there is no file '{file}'"


def _element(case: Case, name: str) -> Iterator[str]:
    """Check that a body's cells and law have the element that it asks for."""
    body = case.bodies[name]
    if body.element != "MINI":
        return
    if case.materials[body.main_material].model != "neo-hooke":
        yield f'bodies.{name}.element = MINI: needs the built-in law, model = "neo-hooke"'
    if (cell := body.mesh.cell_type()) not in SIMPLICES:
        yield f"bodies.{name}.element = MINI: needs triangles or tetrahedra; the mesh has {cell}s"


def _in_space(case: Case) -> Iterator[str]:
    """What contact in 3D cannot do yet."""
    for name in case.interfaces:
        if name in case.closed_form:
            yield f"closed_form.{name}: there are no closed forms of interfaces in 3D yet"
    if case.interfaces and case.heat is not None:
        yield "heat: does not pass through interfaces in 3D yet"


def _obstacles(case: Case) -> Iterator[str]:
    """Check that obstacles fit the dimension of the case."""
    allowed = SHAPES[case.axes]
    for name, obstacle in case.obstacles.items():
        key = f"obstacles.{name}"
        if obstacle.shape not in allowed:
            known = ", ".join(allowed)
            yield f"{key}.shape = {obstacle.shape}: dimension = {case.dimension} has {known}"
        for axis in sorted(obstacle.displacement.keys() - set(AXES[: case.axes])):
            yield f"{key}.displacement.{axis}: there is no {axis} in {case.dimension}"
        if isinstance(obstacle, Plane):
            for part in ("point", "normal"):
                if len(getattr(obstacle, part)) != case.axes:
                    yield f"{key}.{part}: must have {case.axes} coordinates"


def _interfaces(case: Case) -> Iterator[str]:
    if case.axes == 3:
        yield from _in_space(case)
    carriers: dict[str, str] = {}
    for name, sides in case.interfaces.items():
        key = f"interfaces.{name}"
        yield from _between(case, key, sides) if sides.between else _sides(case, key, sides)
        if sides.multiplier == "standard" and case.solver.system != "saddle":
            yield (
                f"{key}.multiplier = standard: cannot be eliminated; "
                f'set solver.system = "saddle" or multiplier = "dual"'
            )
        first = name if sides.between else carriers.setdefault(sides.nonmortar, name)
        if first != name:
            yield f"{key}.nonmortar = {sides.nonmortar}: is the nonmortar side of '{first}' already"


def _sides(case: Case, key: str, sides: Interface) -> Iterator[str]:
    """Check the two sides of an interface that says which one is nonmortar."""
    if sides.nonmortar in case.obstacles:
        yield f"{key}.nonmortar = {sides.nonmortar}: an obstacle can only be the mortar side"
    else:
        yield from _surface(case, f"{key}.nonmortar", sides.nonmortar)
    yield from _side(case, f"{key}.mortar", sides.mortar)
    if sides.mortar == sides.nonmortar:
        yield f"{key}.mortar = {sides.mortar}: is the nonmortar side too; give another surface"


def _between(case: Case, key: str, sides: Interface) -> Iterator[str]:
    """Check the two sides of an interface that leaves the choice to the program."""
    first, second = sides.between or ("", "")
    yield from _side(case, f"{key}.between.0", first)
    yield from _side(case, f"{key}.between.1", second)
    if first == second:
        yield f"{key}.between.1 = {second}: is the first side too; give another surface"
    obstacles = [side for side in (first, second) if side in case.obstacles]
    if len(obstacles) == 2:
        yield f"{key}.between: both sides are obstacles; one must be 'body.surface'"
    if "partition" in sides.heat.model_fields_set and not obstacles:
        yield (
            f"{key}.heat.partition = {sides.heat.partition:g}: is the share of the nonmortar side; "
            "give nonmortar and mortar in place of between"
        )


def _side(case: Case, key: str, on: str) -> Iterator[str]:
    """Check "body.surface" or the name of an obstacle."""
    if "." in on:
        yield from _surface(case, key, on)
    elif on in case.bodies:
        yield f"{key} = {on}: must be 'body.surface'"
    elif on not in case.obstacles:
        yield _unknown(key, on, "obstacle", case.obstacles)


def _conditions(case: Case) -> Iterator[str]:
    for number, condition in enumerate(case.conditions):
        key = f"conditions.{number}"
        if condition.kind in IN_VOLUME or condition.at is not None:
            if condition.on not in case.bodies:
                yield _unknown(f"{key}.on", condition.on, "body", case.bodies)
        else:
            yield from _surface(case, f"{key}.on", condition.on)
        yield from _components(case, key, condition)
        yield from _position(case, key, condition.body, condition.at)


def _components(case: Case, key: str, condition: Condition) -> Iterator[str]:
    axes: set[str] = set(AXES[: case.axes])
    grip = condition.grip
    parts: dict[str, set[str]] = {
        "displacement": set(condition.displacement or {}),
        "traction": set(condition.traction or {}),
        "body_force": set(condition.body_force or {}),
        "grip": set(grip.displacement) | set(grip.force) if grip is not None else set(),
    }
    for kind, given in parts.items():
        for axis in sorted(given - axes):
            yield f"{key}.{kind}.{axis}: there is no z in {case.dimension}"
    if grip is not None and case.axisymmetric and "x" in grip.force:
        yield f"{key}.grip.force.x: there is no radial force; prescribe displacement.x"
    if grip is not None:
        for axis in sorted(axes - parts["grip"]):
            yield f"{key}.grip: '{axis}' is neither a displacement nor a force"


def _position(case: Case, key: str, body: str, at: tuple[float, ...] | None) -> Iterator[str]:
    """Check that a position has the right number of coordinates and is not far from its body."""
    if at is None:
        return
    if len(at) != case.axes:
        yield f"{key}.at: must have {case.axes} coordinates"
    elif body in case.bodies and not isinstance(mesh := case.bodies[body].mesh, MeshFile):
        low, high = mesh.extent()
        room = NEAR * max(high - low)
        outside = [
            axis
            for axis, x, a, b in zip(AXES, at, low, high, strict=False)
            if not a - room <= x <= b + room
        ]
        if outside:
            yield f"{key}.at: lies outside of '{body}' in {outside[0]}"


def _probes(case: Case) -> Iterator[str]:
    for name, probe in case.probes.items():
        key = f"probes.{name}"
        if probe.on not in case.bodies:
            yield _unknown(f"{key}.on", probe.on, "body", case.bodies)
        yield from _position(case, key, probe.on, probe.at)
        if probe.value == "temperature" and case.heat is None:
            yield f"{key}.value = temperature: heat is not solved for; add [heat]"
        if case.axes == 2 and probe.value in ("displacement.z", "stress.yz", "stress.xz"):
            yield f"{key}.value = {probe.value}: is zero in {case.dimension}"


def _names(case: Case) -> Iterator[str]:
    for name in case.closed_form:
        if name not in case.interfaces:
            hint = nearest(name, list(case.interfaces))
            yield f"closed_form.{name}: there is no interface '{name}'{hint}"
    for name in case.obstacles.keys() & case.bodies.keys():
        yield f"obstacles.{name}: a body has this name"
    for time in case.output.times:
        if time > case.time.end:
            yield f"output.times: {time:g} s is after the end, {case.time.end:g} s"
