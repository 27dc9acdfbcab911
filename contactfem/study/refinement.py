"""Changes of a case file from level to level."""

import json
from collections.abc import Collection, Iterator
from typing import Any, Literal

from contactfem.case.schema import Case
from contactfem.case.settings import Adaptivity
from contactfem.errors import CaseError, MeshError

What = Literal["space", "time"]
TOLERANCES: dict[What, tuple[str, ...]] = {"space": ("mechanics", "heat"), "time": ("time",)}


def refinement(case: Case, factor: float, what: Collection[What]) -> list[str]:
    """Changes that make a case finer.

    Cells or steps become `factor` times smaller. Where meshes or steps adapt themselves it is their
    tolerance that does, and they start from the same ones.

    Args:
        case: the case.
        factor: how many times finer.
        what: space, time or both.

    Returns:
        "a.b.c=value" each, as `--set` takes them.

    Raises:
        CaseError: a mesh from a file, which has no sizes.
    """
    changes: dict[str, Any] = {}
    tolerances = _tolerances(case)
    if "space" in what:
        changes |= dict(_cells(case, factor, tolerances))
    if "time" in what and "time" not in tolerances:
        steps = ("step", "step_min", "step_max")
        changes |= {f"time.{name}": f"{getattr(case.time, name) / factor!r} s" for name in steps}
    finer = {name for each in what for name in TOLERANCES[each]}
    for name, tolerance in tolerances.items():
        changes[f"adaptivity.{name}"] = tolerance / factor if name in finer else tolerance
    return [f"{key}={json.dumps(value)}" for key, value in changes.items()]


def _tolerances(case: Case) -> dict[str, float]:
    """The errors asked for, by the names that they may each have in the case file."""
    asked = case.adaptivity
    if asked is None:
        return {}
    given = {"mechanics": asked.for_mechanics() if case.mechanics else None}
    if case.heat is not None:
        given |= {"heat": asked.for_heat(), "time": asked.for_time()}
    return {name: tolerance for name, tolerance in given.items() if tolerance is not None}


def _cells(case: Case, factor: float, tolerances: Collection[str]) -> Iterator[tuple[str, Any]]:
    """Changes of the meshes that do not adapt themselves."""
    for name, body in case.bodies.items():
        adapts = case.adaptivity is not None and _named(case.adaptivity, name)
        meshes = {"mesh": body.mesh}
        if body.thermal_mesh is not None:
            meshes["thermal_mesh"] = body.thermal_mesh
        for key, mesh in meshes.items():
            problem = "mechanics" if key == "mesh" else "heat"
            if adapts and problem in tolerances:
                continue
            try:
                changes = mesh.refinement(factor)
            except MeshError as error:
                raise CaseError(f"{case.path}: bodies.{name}.{key}: {error}") from None
            yield from ((f"bodies.{name}.{key}.{k}", value) for k, value in changes.items())


def _named(asked: Adaptivity, body: str) -> bool:
    """Whether a body may get new meshes."""
    return asked.bodies is None or body in asked.bodies
