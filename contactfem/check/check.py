"""Summary of a case before it runs: model, constraints, hints."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from contactfem.case.body_meshes import built_mesh, mesh_files, mesh_remarks
from contactfem.case.element_choice import describe_element
from contactfem.case.materials import Material
from contactfem.case.python_code import python_code
from contactfem.case.scene import Interface
from contactfem.case.schema import Case
from contactfem.check.adaptivity_summary import adaptivity_words
from contactfem.check.heat_summary import heat_words
from contactfem.check.initial_gaps import nearest_place, obstacle_gap, plane_figure
from contactfem.check.interface_summary import gap_in_space, interface_facts, outlines_of
from contactfem.check.plausibility import large_loads, odd_motions
from contactfem.check.resolved_values import listing
from contactfem.check.side_summary import chosen_sides
from contactfem.common.text import nearest, one_line
from contactfem.common.typing import Floats
from contactfem.common.unit_display import engineering
from contactfem.errors import CaseError, MeshError
from contactfem.geometry.rigid_motions import free_rigid_modes, name_modes
from contactfem.meshes import MeshFile

Outlines = dict[str, dict[str, Floats]]

LOOSE = "nothing holds it"
TOUCHING = 1e-9  # relative to the size of the nonmortar surface


@dataclass(frozen=True)
class Account:
    """What a case says, as the summary of a run keeps it.

    Attributes:
        scene: what it models and leaves out, title and text of each row.
        resolved: its keys, their values in SI with unit, and whether they are defaults.
    """

    scene: tuple[tuple[str, str], ...] = ()
    resolved: tuple[tuple[str, str, bool], ...] = ()


def account(case: Case) -> Account:
    """Take down what a case models and every value that it relies on; reads no mesh."""
    return Account(tuple(_scene(case)), tuple(_values(case)))


def check_case(case: Case) -> str:
    """Describe a case, for people to read before they run it.

    Args:
        case: the case.

    Returns:
        Text of several lines.

    Raises:
        CaseError: a mesh file that is not a mesh, or that lacks a surface that the case names.
    """
    lines = outlines(case)
    sections = [
        describe(case),
        _section("bodies", _bodies(case, lines)),
        _section("interfaces", _interfaces(case, lines)),
        _section("values in SI, * where the case file does not give them", _marked(case)),
    ]
    text = "\n\n".join(section for section in sections if section)
    return "\n".join(one_line(line) for line in text.split("\n"))


def describe(case: Case) -> str:
    """Title of a case, what it models and what it leaves out, as a text of a few lines."""
    return f"{one_line(case.title)}\n{_section(str(case.path), _scene(case))}"


def _section(title: str, rows: Iterable[tuple[str, str]]) -> str:
    """Title over aligned rows; nothing without rows."""
    table = list(rows)
    width = max((len(key) for key, _ in table), default=0)
    lines = [f"  {key:<{width}}  {value}".rstrip() for key, value in table]
    return "\n".join([title, *lines]) if lines else ""


def outlines(case: Case) -> Outlines:
    """Polylines of all surfaces of all bodies; reads mesh files.

    Args:
        case: the case.

    Returns:
        Points (k, 2) or (k, 3) [m] by body and surface.

    Raises:
        CaseError: not a mesh, or a surface that is missing or empty.
    """
    for name, key, _ in mesh_files(case):
        built_mesh(case, name, key)
    lines: Outlines = {}
    for name, body in case.bodies.items():
        try:
            lines[name] = body.mesh.outline()
        except MeshError as error:
            why = one_line(str(error))
            raise CaseError(f"{case.path}: bodies.{name}.mesh: {why}") from None
        if isinstance(body.mesh, MeshFile):
            _check_file(case, name, body.mesh, lines[name])
    return lines


def check_bodies(case: Case) -> None:
    """Make sure that mesh files have the surfaces that a case names, and that all bodies are held.

    Args:
        case: the case; what needs no mesh was checked when it was read.

    Raises:
        CaseError: not a mesh, a surface that is missing or empty, or a body that moves freely.
    """
    for name, lines in outlines(case).items():
        found = held(case, name, lines)
        if case.mechanics and found.endswith(LOOSE):
            words = found.removeprefix("WARNING: ")
            raise CaseError(
                f"{case.path}: bodies.{name}: {words}; prescribe a displacement, or make it touch "
                "something in an interface"
            )


def _check_file(case: Case, body: str, mesh: MeshFile, lines: dict[str, Floats]) -> None:
    """Make sure that a mesh file has the surfaces that the case names."""
    doubts = "".join(f"; {text}" for text in mesh.read.doubts)
    named = [(f"conditions.{k}.on", c.on) for k, c in enumerate(case.conditions)]
    for name, sides in case.interfaces.items():
        for key, on in (("nonmortar", sides.nonmortar), ("mortar", sides.mortar)):
            named.append((f"interfaces.{name}.{'between' if sides.between else key}", on))
    for key, on in named:
        owner, dot, surface = on.partition(".")
        if owner == body and dot and surface not in lines:
            raise CaseError(
                f"{case.path}: {key} = {on}: '{body}' has no surface '{surface}' with facets"
                f"{nearest(surface, list(lines)) or '; it has no named surfaces'}{doubts}"
            )


def _scene(case: Case) -> Iterator[tuple[str, str]]:
    strain = "small strain" if case.strain == "small" else "finite strain"
    motion = f"{strain}, without inertia" if case.mechanics else "bodies do not move (heat alone)"
    yield "mechanics", f"{case.dimension}, {motion}"
    count = len(case.interfaces)
    yield "contact", f"on: {count} interface{'s' if count > 1 else ''}" if count else "off"
    for text in chosen_sides(case):
        yield "sides", text
    if case.interfaces:
        yield "system", _system(case)
    friction = [
        f"{sides.friction.words()} ({name})"
        for name, sides in case.interfaces.items()
        if sides.friction is not None
    ]
    yield "friction", f"on: {', '.join(friction)}" if friction else "off"
    yield from heat_words(case)
    yield from adaptivity_words(case)
    if code := [f"{name} ({key})" for key, name in python_code(case)]:
        yield "python", f"runs code: {', '.join(code)}; --no-code refuses that"
    yield "time", f"0 to {case.time.end:g} s, first step {case.time.step:g} s"
    for text in large_loads(case):
        yield "doubtful", text
    count = len(case.expect)
    yield "expected", f"{count} number{'s' if count > 1 else ''}" if count else "nothing"
    if case.variants:
        yield "variants", ", ".join(case.variants)


def _system(case: Case) -> str:
    """Which system is solved and which multipliers it has."""
    standard = [n for n, sides in case.interfaces.items() if sides.multiplier == "standard"]
    kinds = ["dual"] if len(standard) < len(case.interfaces) else []
    kinds += [f"standard ({', '.join(standard)})"] if standard else []
    of = {"condensed": "condensed: eliminated", "saddle": "saddle point: unknown"}
    return f"{of[case.solver.system]} multipliers, {', '.join(kinds)}"


def _bodies(case: Case, lines: Outlines) -> Iterator[tuple[str, str]]:
    for name, body in case.bodies.items():
        shown = name
        for each in body.all_materials:
            own = [group for group, material in body.materials.items() if material == each]
            cells = f" ({', '.join(own)})" if own else ""
            words = _material(case.materials[each], small=case.strain == "small")
            yield shown, f"{each}{cells}: {words}"
            shown = ""
        low, high = body.mesh.extent()
        size = " x ".join(engineering(length, "m") for length in high - low)
        yield "", f"{size}, lower corner ({', '.join(f'{x:.4g}' for x in low)}) m"
        yield "", "surfaces " + (", ".join(lines[name]) or "without names")
        for where, text, doubtful in mesh_remarks(case):
            if where.startswith(f"bodies.{name}."):
                yield "", f"WARNING: {text}" if doubtful else text
        for text in odd_motions(case, name, float((high - low).max())):
            yield "", f"WARNING: {text}"
        softest = max(
            (case.materials[each] for each in body.all_materials), key=lambda m: m.K / m.mu
        )
        yield "", describe_element(body, softest, body.mesh.cell_type())
        yield "", held(case, name, lines[name])


def _material(material: Material, *, small: bool) -> str:
    """Law and moduli, both pairs."""
    law = "Hooke" if small and material.model == "neo-hooke" else material.model
    E, K, mu = (engineering(value, "Pa") for value in (material.E, material.K, material.mu))
    return f"{law}, E = {E}, nu = {material.nu:.4g}, K = {K}, mu = {mu}"


def held(case: Case, body: str, lines: dict[str, Floats]) -> str:
    """Which rigid motions of a body its conditions leave free, and what else may hold them.

    Args:
        case: the case.
        body: name of the body.
        lines: points (k, dim) [m] of its surfaces.

    Returns:
        One sentence.
    """
    if not case.mechanics:
        return "does not move"
    low, high = case.bodies[body].mesh.extent()
    points: list[Floats] = [np.empty((0, len(low)))]
    prescribed: list[npt.NDArray[np.bool_]] = [np.empty((0, len(low)), dtype=bool)]
    conditions = [condition for condition in case.conditions if condition.body == body]
    for condition in conditions:
        if condition.kind in ("displacement", "grip"):
            at = condition.at
            place = np.array([at] if at is not None else lines[condition.surface or ""])
            place = place[~np.isnan(place[:, 0])]  # rows of NaN keep chains apart
            mask = [axis in condition.components() for axis in "xyz"[: len(low)]]
            points.append(place)
            prescribed.append(np.broadcast_to(mask, place.shape))
    center, size = (low + high) / 2, float(np.linalg.norm(high - low))
    if case.axisymmetric:  # bodies of revolution can only move along their axis
        points.append(center[None])
        prescribed.append(np.array([[True, False]]))
    modes = free_rigid_modes(
        np.concatenate(points),
        np.concatenate(prescribed),
        center,
        size,
        rotation_held=case.axisymmetric or any(c.kind == "grip" for c in conditions),
    )
    if not len(modes):
        return "held by its conditions"
    free = ", ".join(name_modes(modes, center, size))
    touching = [f"'{name}'" for name, sides in case.interfaces.items() if _takes_part(body, sides)]
    if touching:
        return f"free in {free}: held only by contact through {', '.join(touching)}"
    return f"WARNING: free in {free}: {LOOSE}"


def _takes_part(body: str, sides: Interface) -> bool:
    return any(side.startswith(f"{body}.") for side in (sides.nonmortar, sides.mortar))


def _extent(lines: dict[str, Floats]) -> Floats:
    """Smallest and largest coordinates (2, dim) [m]."""
    points = np.concatenate(list(lines.values()))
    return np.array([np.nanmin(points, axis=0), np.nanmax(points, axis=0)])


def _interfaces(case: Case, lines: Outlines) -> Iterator[tuple[str, str]]:
    for name, sides in case.interfaces.items():
        body, _, surface = sides.nonmortar.partition(".")
        line = lines[body][surface]
        gap: float | None
        place: Floats | None = None
        if case.axes == 3:
            gap = gap_in_space(case, sides)
        elif sides.mortar in case.obstacles:
            gap = obstacle_gap(line, plane_figure(case, sides.mortar))
        else:
            other, _, face = sides.mortar.partition(".")
            around = outlines_of(case, sides)
            gap, place = nearest_place(line, lines[other][face], around) or (None, None)
        low, high = _extent({surface: line})
        size = float(np.linalg.norm(high - low))
        words = _gap(gap, size, place)
        yield name, f"{sides.nonmortar} (nonmortar) on {sides.mortar} (mortar): {words}"
        for text in interface_facts(case, sides):
            yield "", text


def _gap(gap: float | None, size: float, place: Floats | None) -> str:
    """Words for a gap, with the place of an overlap: contact drives that apart."""
    if gap is None:
        return "WARNING: the surfaces nowhere face each other, so nothing touches"
    if abs(gap) <= TOUCHING * size:
        return "touching"
    words = f"{'gap' if gap > 0 else 'overlap'} {engineering(abs(gap), 'm')}"
    if gap > 0 or place is None:
        return words
    return f"{words} at ({', '.join(f'{x:.4g}' for x in place)}) m, which contact pushes apart"


def _values(case: Case) -> Iterator[tuple[str, str, bool]]:
    """Keys with their values, and whether they are defaults."""
    for key, value, default in listing(case):
        if not key.startswith(("title", "references", "variants", "expect", "path", "contents")):
            yield key, value, default


def _marked(case: Case) -> Iterator[tuple[str, str]]:
    for key, value, default in _values(case):
        yield key, f"{value} *" if default else value
