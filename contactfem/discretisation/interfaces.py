"""Interfaces of a case as equations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from contactfem.case.contact_parameters import constants
from contactfem.case.law_factory import friction_law
from contactfem.case.obstacles import Plane, Polyline, RigidCylinder, RigidSurface, Sphere
from contactfem.case.schema import Case
from contactfem.common.typing import Bools, Floats
from contactfem.contact.conditions import Contact, ContactLaw
from contactfem.discretisation.search import search_range
from contactfem.errors import CaseError
from contactfem.fem.body_mesh import BodyMesh
from contactfem.mechanics.bulk_system import System
from contactfem.mechanics.interface_nodes import InterfaceNodes
from contactfem.meshes.triangles import read_triangles
from contactfem.mortar.crosspoints import Side
from contactfem.mortar.rigid_surfaces import (
    cylinder_side,
    spatial_plane,
    sphere_side,
    triangulated_side,
)
from contactfem.mortar.sides import BodySide, RigidSide, circle_side, plane_side, polyline_side

CYLINDER_FACETS = 256  # at least; an error of the radius of 5e-5
TIED = 0.2  # initial gap over facet size up to which tied surfaces are near enough
CIRCLE_FACETS = 1024  # at least; an error of the radius of 3e-6


def multiplier_count(case: Case, meshes: dict[str, BodyMesh]) -> int:
    """Number of components of the multipliers of all interfaces."""
    sides = [interface.nonmortar.partition(".") for interface in case.interfaces.values()]
    return sum(meshes[body].surface(surface).X.size for body, _, surface in sides)


def vertices_of_sides(
    case: Case, name: str, index: dict[str, int], meshes: dict[str, BodyMesh]
) -> tuple[Side, Side | None]:
    """Bodies and vertices of both sides of an interface."""

    def side(on: str) -> Side:
        body, _, surface = on.partition(".")
        return index[body], meshes[body].surface(surface).vertices

    interface = case.interfaces[name]
    rigid = interface.mortar in case.obstacles
    return side(interface.nonmortar), None if rigid else side(interface.mortar)


def contact_of_interface(
    case: Case,
    name: str,
    system: System,
    index: dict[str, int],
    meshes: dict[str, BodyMesh],
    shared: Bools,
) -> tuple[InterfaceNodes, Contact]:
    """Nodes and laws of one interface."""
    interface = case.interfaces[name]
    body, _, surface = interface.nonmortar.partition(".")
    nonmortar = BodySide(index[body], meshes[body].surface(surface))
    E_nonmortar = system.bodies[index[body]].law.youngs_modulus
    mortar: BodySide | RigidSide
    if interface.mortar in case.obstacles:
        mortar = rigid_side(case, interface.mortar, nonmortar.surface.X)
        E_mortar = np.inf
    else:
        body, _, surface = interface.mortar.partition(".")
        mortar = BodySide(index[body], meshes[body].surface(surface))
        E_mortar = system.bodies[index[body]].law.youngs_modulus
    nodes = InterfaceNodes(system, nonmortar, mortar, interface.multiplier, shared)
    found = constants(
        interface,
        nonmortar.surface,
        (E_nonmortar, E_mortar),
        mortar.surface if isinstance(mortar, BodySide) else None,
    )
    law = ContactLaw(
        friction=friction_law(case, interface.friction),
        c=found.c,
        c_n=found.c_n,
        c_t=found.c_t,
        stiffness=min(E_nonmortar, E_mortar),
        reach=search_range(case, name, meshes, system.comm),
        normal_compliance=found.normal_compliance,
        tangential_compliance=found.tangential_compliance,
        augmented=interface.normal.law == "augmented",
    )
    contact = Contact(system.comm, nodes.mesh, law)
    if interface.normal.law == "tied" or interface.adjust:
        contact = Contact(system.comm, nodes.mesh, _adjusted(case, name, contact, nodes))
    return nodes, contact


def _adjusted(case: Case, name: str, contact: Contact, nodes: InterfaceNodes) -> ContactLaw:
    """Laws with the initial gaps that count as none, and which nodes are tied; collective.

    Raises:
        CaseError: Nothing is near enough to be tied.
    """
    interface = case.interfaces[name]
    operators = contact.operators(nodes.X)
    gap = np.where(np.isfinite(operators.gap), operators.gap, np.inf)
    tied = interface.normal.law == "tied"
    reach = interface.adjust
    near = np.abs(gap) <= (np.maximum(reach or 0.0, TIED * operators.size) if tied else reach or 0)
    if tied and not near.any():
        least = float(np.abs(gap).min())
        raise CaseError(
            f"{case.path}: interfaces.{name}: tied surfaces are nowhere near each other; the "
            f"smallest gap is {least:g} m; give adjust = a distance up to which they are tied"
        )
    return replace(contact.law, initial_gap=np.where(near, gap, 0.0), tied=near if tied else None)


def rigid_side(case: Case, name: str, X: Floats) -> RigidSide:
    """Rigid side as facets, large and fine enough for the surface with the nodes X [m]."""
    obstacle = case.obstacles[name]
    motion = obstacle.motion(case.axes)
    extent = 10.0 * float(np.linalg.norm(np.ptp(X, axis=0))) + 2.0 * _travel(case)
    if isinstance(obstacle, Plane):
        point, normal = np.array(obstacle.point), np.array(obstacle.normal)
        centre = X.mean(0) - normal * (normal @ (X.mean(0) - point))
        plane = plane_side if case.axes == 2 else spatial_plane
        return plane(centre.tolist(), obstacle.normal, extent, motion)
    if isinstance(obstacle, Polyline):
        return polyline_side(np.array(obstacle.points), obstacle.closed, motion)
    if isinstance(obstacle, RigidSurface):
        points, triangles = read_triangles(obstacle.file)
        return triangulated_side(points * obstacle.unit, triangles, motion)
    if isinstance(obstacle, Sphere):
        margin = 0.05 * extent + 2.0 * _travel(case)
        near = np.array((X.min(axis=0) - margin, X.max(axis=0) + margin))
        return sphere_side(
            obstacle.center, obstacle.radius, obstacle.inside, _spacing(X), near, motion
        )
    if isinstance(obstacle, RigidCylinder):
        facets = max(CYLINDER_FACETS, int(2.0 * np.pi * obstacle.radius / _spacing(X)))
        return cylinder_side(
            obstacle.point, obstacle.axis, obstacle.radius, obstacle.inside, facets, extent, motion
        )
    size = np.hypot(*np.diff(X, axis=0).T)
    facets = max(CIRCLE_FACETS, int(4 * np.pi * obstacle.radius / size.mean()))
    return circle_side(obstacle.center, obstacle.radius, obstacle.inside, facets, motion)


def _travel(case: Case) -> float:
    """Length that all prescribed motions of a case together cannot exceed [m]."""
    tables = [table for c in case.conditions for table in c.components().values()]
    tables += [table for o in case.obstacles.values() for table in o.motion(case.axes)]
    return float(sum(max(map(abs, table.values), default=0.0) for table in tables))


def _spacing(X: Floats) -> float:
    """About the distance of neighbouring points of a surface in space [m]."""
    return float(np.linalg.norm(np.ptp(X, axis=0)) / np.sqrt(len(X)))
