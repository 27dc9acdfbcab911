"""Doubtful input: loads far above the stiffness, meshes in pieces."""

from collections.abc import Iterator

from contactfem.case.scene import Condition
from contactfem.case.schema import Case
from contactfem.common.unit_display import engineering
from contactfem.common.units import Given

LEAST_MOTION, MOST_MOTION = 1e-5, 1e2  # prescribed displacement over the size of its body


def large_loads(case: Case) -> Iterator[str]:
    """Tractions and pressures above Young's modulus, which strain a body by more than one.

    Args:
        case: the case.

    Yields:
        A sentence about each.
    """
    for number, condition in enumerate(case.conditions if case.mechanics else ()):
        load = max((abs(v) for table in _loads(condition) for v in table.values), default=0.0)
        material = case.bodies[condition.body].main_material
        times = load / case.materials[material].E
        if times > 1.0:
            yield (
                f"conditions.{number}.{condition.kind}: {engineering(load, 'Pa')} is {times:.3g} "
                f"times Young's modulus of '{material}'; is the unit right?"
            )


def _loads(condition: Condition) -> list[Given]:
    """Loads per area [Pa]."""
    tables = list((condition.traction or {}).values())
    return tables + ([condition.pressure] if condition.pressure is not None else [])


def odd_motions(case: Case, body: str, size: float) -> Iterator[str]:
    """Prescribed displacements far below or above the size of a body, as of a wrong unit.

    Args:
        case: the case.
        body: name of the body.
        size: its extent [m].

    Yields:
        A sentence about each.
    """
    for number, condition in enumerate(case.conditions if case.mechanics else ()):
        if condition.body != body:
            continue
        tables = condition.components().values()
        motion = max((abs(v) for table in tables for v in table.values), default=0.0)
        if motion > 0.0 and not LEAST_MOTION * size < motion < MOST_MOTION * size:
            lengths = f"a body of {engineering(size, 'm')} by {engineering(motion, 'm')}"
            yield f"conditions.{number}.{condition.kind}: moves {lengths}; are the units right?"
