"""Check that what adaptivity asks for fits the rest of a case."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from contactfem.common.text import nearest
from contactfem.errors import MeshError
from contactfem.meshes import MeshFile

if TYPE_CHECKING:
    from contactfem.case.schema import Case
    from contactfem.case.settings import Adaptivity


def broken_adaptivity(case: Case) -> Iterator[str]:
    """Everything about adaptivity that its table alone cannot tell.

    Args:
        case: the case, each table of which is right by itself.

    Yields:
        One line "dotted.key = found: what is wrong" per mistake.
    """
    settings = case.adaptivity
    if settings is None:
        return
    if case.axes == 3:
        yield "adaptivity: only plane bodies have adapted meshes; dimension = 3d"
        return
    yield from _problems(case, settings)
    for name in settings.bodies or ():
        if name not in case.bodies:
            yield f"adaptivity.bodies = {name}: there is no body '{name}'" + nearest(
                name, list(case.bodies)
            )
    low, high = settings.size_min, settings.size_max
    if low is not None and high is not None and low > high:
        yield f"adaptivity.size_min = {low:g} m: is larger than size_max = {high:g} m"
    yield from _meshes(case)


def _problems(case: Case, settings: Adaptivity) -> Iterator[str]:
    """Check that the problems are solved for whose errors are asked for."""
    if case.heat is None:
        for key in ("heat", "time"):
            if getattr(settings, key) is not None:
                yield f"adaptivity.{key}: heat is not solved for; add [heat]"
        if settings.aspect != 1.0:
            yield f"adaptivity.aspect = {settings.aspect:g}: heat is not solved for; add [heat]"
    elif settings.time is not None and case.heat.scheme == "steady":
        yield "adaptivity.time: a steady temperature has no error in time"
    if settings.aspect != 1.0 and not case.interfaces:
        yield f"adaptivity.aspect = {settings.aspect:g}: there are no interfaces"
    if not case.mechanics and settings.mechanics is not None:
        yield "adaptivity.mechanics: bodies do not move (mechanics = false)"


def adapting(case: Case) -> list[str]:
    """Bodies that may get new meshes."""
    named = case.adaptivity.bodies if case.adaptivity is not None else ()
    return list(case.bodies) if named is None else [name for name in named if name in case.bodies]


def _meshes(case: Case) -> Iterator[str]:
    """Check that meshes from files have a boundary that can be walked."""
    for name in adapting(case):
        mesh = case.bodies[name].mesh
        if not isinstance(mesh, MeshFile):
            continue
        try:
            mesh.curves()
        except MeshError as error:
            others = ", ".join(f'"{other}"' for other in case.bodies if other != name)
            hint = f"; name the others: adaptivity.bodies = [{others}]" if others else ""
            yield f"bodies.{name}.mesh: adaptivity needs its geometry: {error}{hint}"
