"""Summary of error tolerances and limits of meshes and steps."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from contactfem.case.adaptivity_checks import adapting
from contactfem.common.text import percent
from contactfem.common.unit_display import engineering

if TYPE_CHECKING:
    from contactfem.case.schema import Case
    from contactfem.case.settings import Adaptivity


def adaptivity_words(case: Case) -> Iterator[tuple[str, str]]:
    """Rows of what adapts itself: tolerances, bodies and limits.

    Args:
        case: the case.

    Yields:
        Title and text.
    """
    settings = case.adaptivity
    if settings is None:
        yield "adaptivity", "off"
        return
    asked = []
    if case.mechanics and (tolerance := settings.for_mechanics()) is not None:
        asked.append(f"stress {percent(tolerance, 6)}")
    if case.heat is not None and (tolerance := settings.for_heat()) is not None:
        asked.append(f"heat flux {percent(tolerance, 6)}")
    transient = case.heat is not None and case.heat.scheme != "steady"
    if transient and (tolerance := settings.for_time()) is not None:
        asked.append(f"rate of temperature {percent(tolerance, 6)}")
    yield "adaptivity", f"errors asked for, ratios of norms: {', '.join(asked) or 'none'}"
    yield "new meshes", f"{', '.join(adapting(case)) or 'none'}; {_limits(settings)}"


def _limits(settings: Adaptivity) -> str:
    low = engineering(settings.size_min, "m") if settings.size_min else "1/2048 of the extent"
    high = engineering(settings.size_max, "m") if settings.size_max else "1/8 of the extent"
    contact = ""
    if settings.contact_size is not None:
        contact = f", {engineering(settings.contact_size, 'm')} where bodies may touch"
    if settings.aspect != 1.0:
        contact += f", of heat there up to {settings.aspect:g} times longer than thick"
    return (
        f"cells of {low} to {high}{contact}, growing by {settings.growth:g} per length, at most "
        f"{settings.max_cells}; at most {settings.max_remeshes} times per step"
    )
