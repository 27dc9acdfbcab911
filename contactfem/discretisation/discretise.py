"""From a case to its discretisation: meshes on the ranks, system of equations, interfaces."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from mpi4py import MPI

from contactfem.case.base import AXES
from contactfem.case.contact_parameters import constants
from contactfem.case.element_choice import element_of
from contactfem.case.law_factory import friction_law
from contactfem.case.scene import Condition, Material, Plane, Polyline
from contactfem.case.schema import Case
from contactfem.common import user_function as functions
from contactfem.common.time_table import constant
from contactfem.common.timers import Timers
from contactfem.common.typing import Bools, Floats, Ints
from contactfem.contact.conditions import Contact, ContactLaw
from contactfem.discretisation.meshes import ON_AXIS, GivenMeshes, mechanical_mesh, thermal_mesh
from contactfem.discretisation.search import search_range
from contactfem.errors import CaseError
from contactfem.fem.body_mesh import BodyMesh
from contactfem.fem.dof_numbering import Grip, Prescribed
from contactfem.forms.energies import (
    linear_elastic,
    linear_elastic_mixed,
    neo_hooke,
    neo_hooke_mixed,
)
from contactfem.forms.mechanics import Energy
from contactfem.geometry.rigid_motions import free_rigid_modes
from contactfem.mechanics.body import BodyProblem, Law, Load
from contactfem.mechanics.bulk_system import System
from contactfem.mechanics.condensed import Interface
from contactfem.mechanics.interface_nodes import (
    BodySide,
    InterfaceNodes,
    RigidSide,
    circle_side,
    plane_side,
    polyline_side,
)
from contactfem.mortar.crosspoints import Side, check_shared, shared_nodes

if TYPE_CHECKING:
    from contactfem.thermomechanics.thermal_problem import Thermal

CIRCLE_FACETS = 1024  # at least; an error of the radius of 3e-6


@dataclass(frozen=True)
class Discretisation:
    """What a case becomes before its first step.

    Attributes:
        bodies: Body problems by name, in the order of the system.
        system: Their system.
        interfaces: The interfaces.
        held: Names of what each prescribed motion belongs to, "body.surface.x".
        unheld: Bodies that their conditions leave a rigid motion.
        heat: The heat side; None where heat is not solved for.
    """

    bodies: dict[str, BodyProblem]
    system: System
    interfaces: tuple[Interface, ...]
    held: tuple[str, ...]
    unheld: frozenset[str]
    heat: Thermal | None = None


def discretise(
    case: Case,
    comm: MPI.Comm,
    timers: Timers,
    given: GivenMeshes | None = None,
    before: Discretisation | None = None,
) -> Discretisation:
    """Build meshes, forms, numbering and interfaces of a case; collective.

    Args:
        case: The case.
        comm: All ranks.
        timers: Where time is booked.
        given: Meshes to take instead of those of the case, on the first rank.
        before: What is kept, with all that was made of it, where no mesh is given; the names of
            those that are given are then known on all ranks. Without it a body that is given no
            thermal mesh shares its mechanical one.

    Returns:
        The discretisation.

    Raises:
        CaseError: The meshes do not fit the case.
    """
    found = before
    if found is None or (given is not None and given.mechanical):
        found = _mechanics(case, comm, timers, given, before)
    if case.heat is None:
        return found
    return replace(found, heat=_heat(case, found, comm, timers, given, before))


def _mechanics(
    case: Case,
    comm: MPI.Comm,
    timers: Timers,
    given: GivenMeshes | None,
    before: Discretisation | None,
) -> Discretisation:
    """The mechanical side alone."""
    with timers.book("mesh"):
        old = {} if before is None else before.bodies
        kept = {name: body.mesh for name, body in old.items()}
        meshes = {
            name: mechanical_mesh(case, name, comm, given, kept.get(name)) for name in case.bodies
        }
    with timers.book("jit"):
        bodies = {
            name: old[name] if name in old and old[name].mesh is mesh else _body(case, name, mesh)
            for name, mesh in meshes.items()
        }
    with timers.book("setup"):
        index = {name: k for k, name in enumerate(bodies)}
        prescribed, grips, held = [], [], []
        for condition in case.conditions:
            vertices = _vertices(condition, meshes, comm)
            for axis, table in condition.components().items():
                body, component = index[condition.body], AXES.index(axis)
                prescribed.append(Prescribed(body, vertices, component, table))
                held.append(f"{condition.on}.{axis}")
            for axis, table in (condition.grip.force if condition.grip else {}).items():
                grips.append(Grip(index[condition.body], vertices, AXES.index(axis), table))
        if case.axisymmetric:  # a point on the axis stays on it
            for name, k in index.items():
                prescribed.append(Prescribed(k, _on_axis(meshes[name], comm), 0, constant(0.0)))
                held.append(f"{name} on the axis.x")
        multipliers = _multipliers(case, meshes) if case.solver.system == "saddle" else 0
        system = System(comm, list(bodies.values()), prescribed, grips, multipliers)
        shared = shared_nodes(
            {name: _vertices_of(case, name, index, meshes) for name in case.interfaces}
        )
        interfaces = tuple(
            Interface(name, *_interface(case, name, system, index, meshes, shared[name]))
            for name in (case.interfaces if case.mechanics else ())
        )
        check_shared({interface.name: interface.nodes.mesh for interface in interfaces})
        unheld = frozenset(name for name in bodies if _is_unheld(case, name, meshes[name]))
    return Discretisation(bodies, system, interfaces, tuple(held), unheld)


def _heat(
    case: Case,
    found: Discretisation,
    comm: MPI.Comm,
    timers: Timers,
    given: GivenMeshes | None,
    before: Discretisation | None,
) -> Thermal:
    """The heat side, on thermal meshes or, where a body has none, on the mechanical one."""
    from contactfem.discretisation.heat import discretise_heat

    bodies = found.bodies
    meshes = {name: body.mesh for name, body in bodies.items()}
    known = None if before is None else before.heat
    kept = {} if known is None else {body.name: body.mesh for body in known.bodies}
    with timers.book("mesh"):
        thermal = {
            name: thermal_mesh(case, name, comm, given, mesh, kept.get(name))
            for name, mesh in meshes.items()
        }
    with timers.book("heat.setup"):
        free = {interface.name: interface.nodes.mesh.free for interface in found.interfaces}
        sides = {}
        for name, interface in case.interfaces.items():
            body, _, surface = interface.nonmortar.partition(".")
            face = meshes[body].surface(surface)
            rigid = interface.mortar in case.obstacles
            obstacle = _obstacle(case, interface.mortar, face.X) if rigid else None
            sides[name] = obstacle, free.get(name)
        return discretise_heat(case, bodies, thermal, sides, comm, timers, known)


def _multipliers(case: Case, meshes: dict[str, BodyMesh]) -> int:
    """Number of components of the multipliers of all interfaces."""
    sides = [interface.nonmortar.partition(".") for interface in case.interfaces.values()]
    return sum(meshes[body].surface(surface).X.size for body, _, surface in sides)


def _on_axis(mesh: BodyMesh, comm: MPI.Comm) -> Ints:
    """Vertices on the axis x = 0, on all ranks; collective."""
    r = None if mesh.data is None else mesh.data.points[:, 0]
    found = None if r is None else np.flatnonzero(np.abs(r) <= ON_AXIS * np.abs(r).max())
    return np.asarray(comm.bcast(found))


def _body(case: Case, name: str, mesh: BodyMesh) -> BodyProblem:
    body = case.bodies[name]
    element = element_of(body, case.materials[body.material], mesh.mesh.basix_cell().name)
    law = _law(case, case.materials[body.material], mixed=element == "MINI")
    loads = [load for c in case.conditions if c.body == name for load in _loads(c, case.axes)]
    theta = body.temperature if case.heat is None else None
    return BodyProblem(name, mesh, law, theta, loads, case.axisymmetric)


def _law(case: Case, material: Material, *, mixed: bool) -> Law:
    """Energy and parameters of a material."""
    small = case.strain == "small"
    parameters = {
        "bulk_modulus": material.K,
        "shear_modulus": material.mu,
        "expansion": material.expansion,
    } | material.parameters
    if material.model == "neo-hooke":
        energy = linear_elastic if small else neo_hooke
        with_mean_stress = linear_elastic_mixed if small else neo_hooke_mixed
        return Law(
            energy, parameters, material.E, small, small, with_mean_stress if mixed else None
        )
    return Law(_user_energy(case, material.model), parameters, material.E, small, linear=False)


def _user_energy(case: Case, reference: str) -> Energy:
    """A user's energy "file.py:function", the file relative to the case."""
    try:
        return functions.reference(reference).load(case.path.parent)
    except CaseError as error:
        raise CaseError(f"{case.path}: material model {error}") from None


def _loads(condition: Condition, axes: int) -> list[Load]:
    """Loads of a condition, none if it prescribes a motion."""
    if condition.pressure is not None:
        return [Load(condition.surface, (condition.pressure,))]
    given = condition.traction or condition.body_force
    if given is None:
        return []
    components = tuple(given.get(axis, constant(0.0)) for axis in AXES[:axes])
    return [Load(condition.surface if condition.traction else None, components)]


def _vertices(condition: Condition, meshes: dict[str, BodyMesh], comm: MPI.Comm) -> Ints:
    """Input vertices that a condition acts on."""
    mesh = meshes[condition.body]
    if condition.at is not None:
        nearest = None
        if mesh.data is not None:
            distance = np.linalg.norm(mesh.data.points - np.array(condition.at), axis=1)
            nearest = (
                int(np.argmin(distance)),
                float(distance.min()),
                float(np.ptp(mesh.data.points)),
            )
        vertex, distance_, size = comm.bcast(nearest)
        if distance_ > 1e-6 * size:
            raise CaseError(
                f"condition on {condition.on}: no vertex at {condition.at} m; the nearest is "
                f"{distance_:g} m away"
            )
        return np.array([vertex])
    if condition.surface is None:
        return np.arange(mesh.n_points)
    return mesh.surface(condition.surface).vertices


def _vertices_of(
    case: Case, name: str, index: dict[str, int], meshes: dict[str, BodyMesh]
) -> tuple[Side, Side | None]:
    """Bodies and vertices of both sides of an interface."""

    def side(on: str) -> Side:
        body, _, surface = on.partition(".")
        return index[body], meshes[body].surface(surface).vertices

    interface = case.interfaces[name]
    rigid = interface.mortar in case.obstacles
    return side(interface.nonmortar), None if rigid else side(interface.mortar)


def _interface(
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
        mortar = _obstacle(case, interface.mortar, nonmortar.surface.X)
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
    return nodes, Contact(system.comm, nodes.mesh, law)


def _obstacle(case: Case, name: str, X: Floats) -> RigidSide:
    """Rigid side as facets, large and fine enough for the surface with the nodes X [m]."""
    obstacle = case.obstacles[name]
    motion = (obstacle.displacement["x"], obstacle.displacement["y"])
    if isinstance(obstacle, Plane):
        point, normal = np.array(obstacle.point), np.array(obstacle.normal)
        centre = X.mean(0) - normal * (normal @ (X.mean(0) - point))
        extent = 10 * float(np.hypot(*np.ptp(X, axis=0))) + 4 * _travel(case)
        return plane_side(centre.tolist(), obstacle.normal, extent, motion)
    if isinstance(obstacle, Polyline):
        return polyline_side(np.array(obstacle.points), obstacle.closed, motion)
    size = np.hypot(*np.diff(X, axis=0).T)
    facets = max(CIRCLE_FACETS, int(4 * np.pi * obstacle.radius / size.mean()))
    return circle_side(obstacle.center, obstacle.radius, obstacle.inside, facets, motion)


def _travel(case: Case) -> float:
    """Length that all led motions of a case together cannot exceed [m]."""
    tables = [table for c in case.conditions for table in c.components().values()]
    tables += [table for o in case.obstacles.values() for table in o.displacement.values()]
    return float(sum(max(map(abs, table.values), default=0.0) for table in tables))


def _is_unheld(case: Case, name: str, mesh: BodyMesh) -> bool:
    """Whether a body's conditions leave it a rigid motion."""
    if case.axisymmetric:  # along the axis is the only one
        return not any(c.body == name and "y" in c.components() for c in case.conditions)
    points, masks, rotation_held = [], [], False
    for condition in case.conditions:
        if condition.body != name or not (condition.displacement or condition.grip):
            continue
        if condition.at is not None:
            X = np.array([condition.at])
        elif condition.surface is not None:
            X = mesh.surface(condition.surface).X
        else:
            return False
        rotation_held = rotation_held or condition.grip is not None
        points.append(X)
        given = condition.components()
        masks.append(np.tile([axis in given for axis in AXES[: case.axes]], (len(X), 1)))
    if not points:
        return True
    X, mask = np.concatenate(points), np.concatenate(masks)
    size = float(np.ptp(np.concatenate([s.X for s in mesh.surfaces.values()]), axis=0).max())
    modes = free_rigid_modes(X, mask, X.mean(0), size, rotation_held=rotation_held)
    return len(modes) > 0
