"""Summary of an interface: facets, parameters, hints."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from contactfem.case.cell_materials import surface_modulus
from contactfem.case.contact_parameters import constants
from contactfem.case.scene import Interface
from contactfem.case.schema import Case
from contactfem.case.search_distances import (
    obstacle_thickness,
    outline_of,
    search_distances,
    side_thickness,
)
from contactfem.case.side_choice import FINER
from contactfem.check.facet_matching import match
from contactfem.check.side_summary import stiff_and_fine
from contactfem.check.spatial_gap import gap_to_obstacle, spatial_gap
from contactfem.common.text import one_line
from contactfem.common.typing import Floats
from contactfem.common.unit_display import engineering, scale_for
from contactfem.errors import CaseError, MeshError
from contactfem.geometry.facets import facet_sizes
from contactfem.geometry.side_comparison import Facets
from contactfem.meshes.data import Surface


def interface_facts(case: Case, interface: Interface) -> Iterator[str]:
    """Facets, constants and hints of one interface; builds its bodies' meshes.

    Args:
        case: The case.
        interface: One of its interfaces.

    Yields:
        Lines of text.
    """
    nonmortar, E_nonmortar = _side(case, interface.nonmortar)
    mortar, E_mortar = None, np.inf
    if interface.mortar not in case.obstacles:
        mortar, E_mortar = _side(case, interface.mortar)
    found = constants(interface, nonmortar, (E_nonmortar, E_mortar), mortar)
    yield f"facets: {_facets(nonmortar)} on {_facets(mortar) if mortar else 'an obstacle'}"
    parts = [f"c_n = {_stiffness(found.c_n * found.c)}"]
    if interface.friction:
        parts.append(f"c_t = {_stiffness(found.c_t * found.c)}")
    yield f"active set: {', '.join(parts)}"
    if interface.normal.law != "multiplier":
        parts = [f"epsilon_N = {_stiffness(1.0 / found.normal_compliance)}"]
        if interface.friction:
            parts.append(f"c_T = {_stiffness(1.0 / found.tangential_compliance)}")
        yield f"penalty: {', '.join(parts)}"
    if case.axes == 2:
        yield _search(case, interface, nonmortar, mortar)
    if mortar is not None and case.axes == 2:
        yield from _hints(interface, nonmortar, mortar)
    if mortar is not None and case.axes == 3:
        yield from _hints_in_space(interface, nonmortar, mortar)
    if mortar is not None:
        facets = Facets(nonmortar.X, nonmortar.facets), Facets(mortar.X, mortar.facets)
        if text := stiff_and_fine(case, interface, facets):
            yield f"WARNING: {text}"


def gap_in_space(case: Case, interface: Interface) -> float | None:
    """Smallest gap between two sides in space; builds meshes of bodies.

    Args:
        case: The case.
        interface: One of its interfaces.

    Returns:
        The gap, negative where the bodies overlap [m]; None if they nowhere face each other.
    """
    surface = _side(case, interface.nonmortar)[0]
    if (obstacle := case.obstacles.get(interface.mortar)) is not None:
        return gap_to_obstacle(surface, obstacle)
    return spatial_gap(surface, _side(case, interface.mortar)[0])


def _hints_in_space(interface: Interface, nonmortar: Surface, mortar: Surface) -> Iterator[str]:
    """Whether the finer side is nonmortar: by 13 % too high a pressure was found at ratio 2."""
    h, h_mortar = (float(np.median(facet_sizes(s.X, s.facets))) for s in (nonmortar, mortar))
    if h_mortar >= FINER * h:
        yield (
            f"HINT: mortar facets are {h_mortar / h:.2g} times as large as nonmortar ones, and "
            f"pressure peaks at their corners; better with {interface.mortar} as nonmortar"
        )


def outlines_of(case: Case, interface: Interface) -> tuple[Floats, Floats]:
    """Ends of the facets around the two bodies of an interface [m], (b, 2, 2) each."""
    first, second = (
        outline_of(case.bodies[side.partition(".")[0]].mesh.build())
        for side in (interface.nonmortar, interface.mortar)
    )
    return first, second


def _search(case: Case, interface: Interface, nonmortar: Surface, mortar: Surface | None) -> str:
    """How far the sides look for each other."""
    if interface.search_radius is not None:
        return f"search: gaps and overlaps up to {engineering(interface.search_radius, 'm')}"
    body, second = (side.partition(".")[0] for side in (interface.nonmortar, interface.mortar))
    own = outline_of(case.bodies[body].mesh.build())
    other = None
    if mortar is None:
        other = obstacle_thickness(case.obstacles[interface.mortar])
    elif second != body:
        other = side_thickness(mortar, outline_of(case.bodies[second].mesh.build()))
    deepest = search_distances(interface, nonmortar, own, other)[1].max()
    depth = f"up to {engineering(float(deepest), 'm')}" if np.isfinite(deepest) else "of any depth"
    return f"search: gaps of any width, overlaps {depth}"


def _side(case: Case, on: str) -> tuple[Surface, float]:
    """Surface "body.surface" and the Young's modulus behind it [Pa].

    Raises:
        CaseError: The body cannot be meshed.
    """
    body, _, surface = on.partition(".")
    try:
        data = case.bodies[body].mesh.build()
        return data.surface(surface), surface_modulus(case, body, surface, data)
    except MeshError as error:
        raise CaseError(f"{case.path}: bodies.{body}.mesh: {one_line(str(error))}") from None


def _hints(interface: Interface, nonmortar: Surface, mortar: Surface) -> Iterator[str]:
    """What would be better the other way round."""
    found = match(nonmortar, mortar)
    if found is None:
        return
    if found.ratio >= FINER:
        yield (
            f"HINT: mortar facets are {found.ratio:.2g} times as long as nonmortar ones where they "
            "touch, and pressure peaks at their corners; better with "
            f"{interface.mortar} as nonmortar"
        )
    back = match(mortar, nonmortar)
    if back is not None and len(found.edges) > len(back.edges):
        places = " and ".join(f"({x:.4g}, {y:.4g}) m" for x, y in found.edges)
        yield (
            f"HINT: {interface.nonmortar} overhangs the end of {interface.mortar} at {places}, "
            f"where its facets are covered in part; better with {interface.mortar} as nonmortar"
        )


def _facets(surface: Surface) -> str:
    """Number and size of the facets."""
    lengths = facet_sizes(surface.X, surface.facets)
    scale = scale_for(float(lengths.max()), "m")
    return f"{len(lengths)} of {_range(lengths / scale.factor)} {scale.label}"


def _stiffness(values: npt.NDArray[np.floating]) -> str:
    """A stiffness [Pa/m]."""
    return f"{_range(values)} Pa/m"


def _range(values: npt.NDArray[np.floating]) -> str:
    """A value, or the smallest and the largest."""
    low, high = (f"{float(v):.4g}" for v in (values.min(), values.max()))
    return low if low == high else f"{low} to {high}"
