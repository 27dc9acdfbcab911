"""Known tractions and heat flows at the boundary vertices of a body.

Recovered stresses and fluxes are made to obey it (Wiberg et al. 1998). On surfaces of interfaces,
where both bodies are fitted together instead, nothing is said here.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from contactfem.adaptivity.recovery.constraints import ConstraintRows
from contactfem.case.scene import Condition
from contactfem.case.schema import Case
from contactfem.common.place_time import Varying
from contactfem.common.time_table import Table
from contactfem.common.typing import Bools, Floats, Ints
from contactfem.common.units import Given
from contactfem.discretisation.given_data import given
from contactfem.fem.gathered_mesh import MeshView
from contactfem.meshes.data import matches

ON_AXIS = 1e-9  # distance from the axis over the largest that counts as none
SMOOTH = np.cos(np.deg2rad(30.0))  # facets that turn by less share one condition at their vertex


@dataclass(frozen=True)
class FacetData:
    """What is known on each boundary facet.

    Attributes:
        known: Which components of the traction, or whether the heat flow, is known, (f, c).
        value: Traction (f, 2) [Pa] in x and y, or outward heat flow (f, 1) [W/m²].
    """

    known: Bools
    value: Floats


def tractions(case: Case, body: str, view: MeshView, x: Floats, t: float) -> FacetData:
    """Tractions on a body's boundary: free but for loads; unknown where it is held or may touch.

    Loads are given per reference area; on the axis of a body of revolution nothing is known but
    that there is no shear.

    Args:
        case: The case.
        body: Name of the body.
        view: Its mesh.
        x: Positions of its vertices [m], (n, 2).
        t: Time [s].
    """
    facets = view.boundary
    known, value = np.ones((len(facets), 2), bool), np.zeros((len(facets), 2))
    normal = facet_normals(facets, x)
    middle = view.data.points[facets].mean(axis=1)
    stretch = _areas(case, facets, x) / _areas(case, facets, view.data.points)
    for condition in _mechanical(case, body):
        at = _on(view, facets, condition.surface or "")
        for axis in condition.components():
            known[at, "xy".index(axis)] = False
        if condition.grip is not None:
            known[at] = False
        for axis, table in (condition.traction or {}).items():
            found = _load(case, table, middle[at], t)
            value[at, "xy".index(axis)] += found / stretch[at]
        if condition.pressure is not None:
            found = _load(case, condition.pressure, middle[at], t)
            value[at] -= found[:, None] * normal[at]
    known[_of_interfaces(case, body, view, facets)] = False
    if case.axisymmetric:
        known[_on_axis(view.data.points, facets), 0] = False
    return FacetData(known, value)


def _load(case: Case, value: Given, x: Floats, t: float) -> Floats:
    """A load at places (n, dim) and a time [Pa], (n,)."""
    found = given(case, value)
    if isinstance(found, Varying):
        return found.at(x, t, case.time.step)
    return np.full(len(x), found.at(t, case.time.step))


def heat_flows(case: Case, body: str, view: MeshView, theta: Floats, t: float) -> FacetData:
    """Heat that leaves through a body's boundary: none but for fluxes and convection.

    Args:
        case: The case.
        body: Name of the body.
        view: Its thermal mesh.
        theta: Temperatures of its vertices [K], (n,).
        t: Time [s].
    """
    facets = view.boundary
    known, value = np.ones((len(facets), 1), bool), np.zeros((len(facets), 1))
    for condition in case.conditions:
        if condition.body != body or condition.surface is None or not condition.is_thermal:
            continue
        at = _on(view, facets, condition.surface)
        flux = condition.heat_flux
        if condition.convection is not None:
            ambient = condition.convection.ambient(t)
            middle = theta[facets[at]].mean(axis=1)
            value[at, 0] += condition.convection.coefficient * (middle - ambient)
        elif isinstance(flux, Table):
            value[at, 0] -= flux(t)
        else:  # prescribed temperature, or a flux over place
            known[at] = False
    known[_of_interfaces(case, body, view, facets)] = False
    return FacetData(known, value)


def vertex_conditions(
    facets: Ints, x: Floats, data: FacetData, rows: Callable[[Floats], Floats], n_columns: int
) -> ConstraintRows:
    """Conditions at the vertices, each with the normal of its facets; two at corners.

    Args:
        facets: Boundary facets, the body on their left, (f, 2).
        x: Positions of all vertices [m], (n, 2).
        data: What is known on the facets.
        rows: Rows of traction or heat flow for unit normals (k, 2) -> (k, c, columns).
        n_columns: Components of the recovered field.

    Returns:
        The conditions.
    """
    normal = facet_normals(facets, x)
    before = np.full(len(x), -1)
    before[facets[:, 1]] = np.arange(len(facets))
    first, second = before[facets[:, 0]], np.arange(len(facets))  # the two facets at each vertex
    smooth = np.einsum("fi,fi->f", normal[first], normal[second]) >= SMOOTH
    alike = smooth & (data.known[first] == data.known[second]).all(axis=1) & (first >= 0)
    mean = normal[first] + normal[second]
    mean /= np.linalg.norm(mean, axis=1, keepdims=True)
    parts = [
        (facets[alike, 0], mean[alike], data.known[second[alike]],
         0.5 * (data.value[first[alike]] + data.value[second[alike]])),
    ]  # fmt: skip
    apart = ~alike & (first >= 0)
    for facet in (first[apart], second[apart]):
        parts.append((facets[apart, 0], normal[facet], data.known[facet], data.value[facet]))
    vertices, normals, known, value = (np.concatenate(part) for part in zip(*parts, strict=True))
    A = rows(normals)
    use = known.ravel()
    return ConstraintRows(
        np.repeat(vertices, A.shape[1])[use], A.reshape(-1, n_columns)[use], value.ravel()[use]
    )


def cartesian_rows(normals: Floats) -> Floats:
    """Rows of (σn)_x and (σn)_y for σ = (xx, yy, zz, xy), (k, 2, 4).

    Args:
        normals: Unit normals, (k, 2).
    """
    nx, ny = normals.T
    zero = np.zeros_like(nx)
    return np.stack(
        (np.column_stack((nx, zero, zero, ny)), np.column_stack((zero, ny, zero, nx))), axis=1
    )


def facet_normals(facets: Ints, x: Floats) -> Floats:
    """Outward unit normals of facets with the body on their left, (f, 2)."""
    edge = x[facets[:, 1]] - x[facets[:, 0]]
    return np.asarray(np.column_stack((edge[:, 1], -edge[:, 0])) / np.hypot(*edge.T)[:, None])


def vertex_normals(facets: Ints, x: Floats, vertices: Ints) -> Floats:
    """Averaged outward unit normals at vertices of a surface, (k, 2).

    Args:
        facets: Facets of the surface by mesh vertices, (f, 2).
        x: Positions of all vertices of the mesh [m], (n, 2).
        vertices: Where, (k,).
    """
    total = np.zeros_like(x)
    for end in (0, 1):
        np.add.at(total, facets[:, end], facet_normals(facets, x))
    found = total[vertices]
    return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))


def _areas(case: Case, facets: Ints, x: Floats) -> Floats:
    """Areas of facets [m], around an axis [m²]; on the axis that of a line instead, (f,)."""
    length = np.hypot(*(x[facets[:, 1]] - x[facets[:, 0]]).T)
    if not case.axisymmetric:
        return np.asarray(length)
    radius = x[facets, 0].mean(axis=1)
    return np.asarray(length * np.where(_on_axis(x, facets), 1.0, radius))


def _on_axis(x: Floats, facets: Ints) -> Bools:
    """Facets on the axis x = 0, (f,)."""
    return np.asarray(np.abs(x[facets, 0]).max(axis=1) <= ON_AXIS * np.abs(x[:, 0]).max())


def _mechanical(case: Case, body: str) -> Sequence[Condition]:
    return [c for c in case.conditions if c.body == body and c.surface and not c.is_thermal]


def _on(view: MeshView, facets: Ints, surface: str) -> Ints:
    """Places of a group's facets among the boundary facets."""
    return matches(view.data.groups[surface], facets)


def _of_interfaces(case: Case, body: str, view: MeshView, facets: Ints) -> Ints:
    """Boundary facets of all interface surfaces of a body."""
    found: list[Ints] = [np.empty(0, np.int64)]
    for interface in case.interfaces.values():
        for side in (interface.nonmortar, interface.mortar):
            owner, _, surface = side.partition(".")
            if owner == body and side not in case.obstacles:
                found.append(_on(view, facets, surface))
    return np.concatenate(found)
