"""Times of a case that steps do not pass over."""

from contactfem.case.scene import Condition
from contactfem.case.schema import Case
from contactfem.common.units import Given


def stops(case: Case) -> list[float]:
    """Times that a step must end at: corners of tables, times of output, the end.

    Args:
        case: The case.

    Returns:
        The times, ascending [s].
    """
    tables: list[Given] = [t for c in case.conditions for t in _tables(c)]
    tables += [t for o in case.obstacles.values() for t in o.displacement.values()]
    tables += [body.temperature for body in case.bodies.values() if body.temperature is not None]
    tables += [o.temperature for o in case.obstacles.values() if o.temperature is not None]
    for interface in case.interfaces.values():
        given = (interface.heat.pressure, interface.heat.dissipation)
        tables += [table for table in given if table is not None]
    times = {t for table in tables for t in table.times} | set(case.output.times)
    return sorted({t for t in times if 0.0 < t < case.time.end} | {case.time.end})


def _tables(condition: Condition) -> list[Given]:
    """All values over time of a condition."""
    tables: list[Given] = []
    for group in (condition.traction, condition.body_force):
        tables += (group or {}).values()
    tables += condition.grip.force.values() if condition.grip else []
    tables += [condition.pressure] if condition.pressure else []
    tables += [condition.field] if condition.field is not None else []
    tables += [condition.convection.ambient] if condition.convection else []
    return tables + list(condition.components().values())
