"""From a case to meshes, equations and interfaces."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from mpi4py import MPI

from contactfem.case.base import AXES
from contactfem.case.schema import Case
from contactfem.common.time_table import constant
from contactfem.common.timers import Timers
from contactfem.discretisation.bodies import (
    body_problem,
    is_unrestrained,
    on_axis,
    vertices_of_condition,
)
from contactfem.discretisation.given_data import given as given_data
from contactfem.discretisation.interfaces import (
    contact_of_interface,
    multiplier_count,
    rigid_side,
    vertices_of_sides,
)
from contactfem.discretisation.meshes import GivenMeshes, mechanical_mesh, thermal_mesh
from contactfem.fem.dof_numbering import Prescribed, TiedDofs
from contactfem.mechanics.body import BodyProblem
from contactfem.mechanics.bulk_system import System
from contactfem.mechanics.contact_equations import Interface
from contactfem.mortar.crosspoints import check_shared, shared_nodes

if TYPE_CHECKING:
    from contactfem.thermomechanics.thermal_problem import Thermal


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
    unrestrained: frozenset[str]
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
            name: old[name]
            if name in old and old[name].mesh is mesh
            else body_problem(case, name, mesh)
            for name, mesh in meshes.items()
        }
    with timers.book("setup"):
        index = {name: k for k, name in enumerate(bodies)}
        prescribed, tied, held = [], [], []
        for condition in case.conditions:
            vertices = vertices_of_condition(condition, meshes, comm)
            for axis, table in condition.components().items():
                body, component = index[condition.body], AXES.index(axis)
                prescribed.append(Prescribed(body, vertices, component, given_data(case, table)))
                held.append(f"{condition.on}.{axis}")
            for axis, table in (condition.grip.force if condition.grip else {}).items():
                tied.append(TiedDofs(index[condition.body], vertices, AXES.index(axis), table))
        if case.axisymmetric:  # a point on the axis stays on it
            for name, k in index.items():
                prescribed.append(Prescribed(k, on_axis(meshes[name], comm), 0, constant(0.0)))
                held.append(f"{name} on the axis.x")
        multipliers = multiplier_count(case, meshes) if case.solver.system == "saddle" else 0
        system = System(comm, list(bodies.values()), prescribed, tied, multipliers)
        shared = shared_nodes(
            {name: vertices_of_sides(case, name, index, meshes) for name in case.interfaces}
        )
        interfaces = tuple(
            Interface(name, *contact_of_interface(case, name, system, index, meshes, shared[name]))
            for name in (case.interfaces if case.mechanics else ())
        )
        check_shared({interface.name: interface.nodes.mesh for interface in interfaces})
        unrestrained = frozenset(
            name for name in bodies if is_unrestrained(case, name, meshes[name])
        )
    return Discretisation(bodies, system, interfaces, tuple(held), unrestrained)


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
            obstacle = rigid_side(case, interface.mortar, face.X) if rigid else None
            sides[name] = obstacle, free.get(name)
        return discretise_heat(case, bodies, thermal, sides, comm, timers, known)
