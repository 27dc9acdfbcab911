"""From a case to the equations of heat."""

from collections.abc import Callable, Mapping

import numpy as np

from mpi4py import MPI

from contactfem.case.cell_materials import CellMaterials
from contactfem.case.law_factory import conductance_law, varies
from contactfem.case.materials import Material
from contactfem.case.scene import Condition
from contactfem.case.schema import Case
from contactfem.case.temperature_scale import initial_temperature
from contactfem.common.time_table import Table
from contactfem.common.timers import Timers
from contactfem.common.typing import Bools, Floats
from contactfem.discretisation.bodies import materials_of
from contactfem.discretisation.given_data import given
from contactfem.discretisation.search import search_range
from contactfem.fem.body_mesh import BodyMesh
from contactfem.heat.body import HeatBody, HeatLaw, HeatLoad
from contactfem.heat.interface import HeatInterface, HeatInterfaceLaw
from contactfem.heat.interface_nodes import HeatNodes
from contactfem.heat.system import HeatSystem, PrescribedTemperature
from contactfem.heat.time_schemes import scheme
from contactfem.mechanics.body import BodyProblem
from contactfem.mortar.sides import BodySide, RigidSide
from contactfem.thermomechanics.body_transfer import BodyLink
from contactfem.thermomechanics.interface_transfer import InterfaceLink
from contactfem.thermomechanics.thermal_problem import Thermal
from contactfem.transfer.surface import SurfaceTransfer

PRESCRIBED = 1.0 - 1e-9  # share of the mechanical nodes around a thermal one that are held


def discretise_heat(
    case: Case,
    bodies: Mapping[str, BodyProblem],
    meshes: Mapping[str, BodyMesh],
    sides: Mapping[str, tuple[RigidSide | None, Bools | None]],
    comm: MPI.Comm,
    timers: Timers,
    before: Thermal | None = None,
) -> Thermal:
    """Build the heat side of a case; collective.

    Args:
        case: The case, with heat.
        bodies: Its mechanical problems.
        meshes: Thermal meshes of the bodies.
        sides: Of every interface the obstacle, if its mortar side is one, and
            which components of its mechanical nodes contact may move, if there is mechanics.
        comm: All ranks.
        timers: Where time is booked.
        before: A heat side, of which bodies are taken whose mesh is the same.

    Returns:
        The heat side.

    Raises:
        CaseError: A function that cannot be loaded, or a mesh without a surface that heat needs.
    """
    assert case.heat is not None
    index = {name: k for k, name in enumerate(bodies)}
    kept = {} if before is None else {body.name: body for body in before.bodies}
    heat = [
        kept[name]
        if name in kept and kept[name].mesh is meshes[name]
        else _body(case, name, meshes[name])
        for name in bodies
    ]
    held, names = [], []
    for condition in case.conditions:
        if condition.temperature is not None:
            vertices = meshes[condition.body].surface(condition.surface or "").vertices
            value = given(case, condition.temperature)
            held.append(PrescribedTemperature(index[condition.body], vertices, value))
            names.append(condition.on)
    system = HeatSystem(comm, heat, held, scheme(case.heat.scheme), case.heat.petsc, timers)
    links = [BodyLink(comm, bodies[name], heat[k]) for name, k in index.items()]
    interfaces = [
        _interface(case, name, bodies, meshes, heat, system, sides[name])
        for name in case.interfaces
    ]
    system.couple([link.heat for link in interfaces])
    initial = [_initial(case, body) for body in heat]
    system.set_held(0.0, initial)
    return Thermal(system, links, interfaces, names, initial, moving=case.mechanics)


def _body(case: Case, name: str, mesh: BodyMesh) -> HeatBody:
    loads = [_load(case, c) for c in case.conditions if c.body == name and _is_load(c)]
    return HeatBody(
        name,
        mesh,
        _law(case, materials_of(case, name, mesh)),
        loads,
        axisymmetric=case.axisymmetric,
        deforms=case.strain == "finite" and case.mechanics,
    )


def _law(case: Case, materials: CellMaterials) -> HeatLaw:
    assert case.heat is not None

    def values(of: Callable[[Material], float]) -> float | Floats:
        return materials.values({name: of(case.materials[name]) for name in materials.names})

    conductivity = values(lambda m: m.conductivity or 0.0)
    capacity = values(lambda m: (m.density or 0.0) * (m.heat_capacity or 0.0))
    if not case.heat.thermoelastic:
        return HeatLaw(conductivity, capacity)
    return HeatLaw(conductivity, capacity, values(lambda m: 3.0 * m.expansion * m.K))


def _is_load(condition: Condition) -> bool:
    return condition.is_thermal and condition.temperature is None


def _load(case: Case, condition: Condition) -> HeatLoad:
    surface = condition.surface
    if condition.convection is not None:
        return HeatLoad(surface, condition.convection.ambient, condition.convection.coefficient)
    assert condition.field is not None
    return HeatLoad(surface, given(case, condition.field))


def _initial(case: Case, body: HeatBody) -> Floats:
    """Temperature at time zero, flat local."""
    value = given(case, initial_temperature(case, body.name))
    if isinstance(value, Table):
        return np.full(body.n_dofs, value(0.0))
    return np.array(value(body.V.tabulate_dof_coordinates().T, 0.0))


def _interface(
    case: Case,
    name: str,
    bodies: Mapping[str, BodyProblem],
    meshes: Mapping[str, BodyMesh],
    heat: list[HeatBody],
    system: HeatSystem,
    side: tuple[RigidSide | None, Bools | None],
) -> InterfaceLink:
    """Heat side of an interface, with the ways between its mechanical and thermal surfaces."""
    interface = case.interfaces[name]
    obstacle, free = side
    index = {body: k for k, body in enumerate(bodies)}
    owner, _, surface = interface.nonmortar.partition(".")
    nonmortar = BodySide(index[owner], meshes[owner].surface(surface))
    mechanical = bodies[owner].mesh.surface(surface)
    to_heat = SurfaceTransfer(mechanical, nonmortar.surface, interface.nonmortar)
    to_mechanics = SurfaceTransfer(nonmortar.surface, mechanical, interface.nonmortar)
    mortar: BodySide | RigidSide | None = obstacle
    if mortar is None:
        other, _, face = interface.mortar.partition(".")
        mortar = BodySide(index[other], meshes[other].surface(face))
    count = len(nonmortar.surface.X)
    second = mortar if isinstance(mortar, RigidSide) else mortar.surface
    moves = np.ones((count + len(second.X), 2), bool)
    if free is not None:
        held = to_heat((~free[: len(mechanical.X)]).astype(np.float64))
        moves[:count] = held < PRESCRIBED
    nodes = HeatNodes(heat, system, nonmortar, mortar, moves, case.axisymmetric)
    temperature = case.obstacles[interface.mortar].temperature if obstacle is not None else None
    h = interface.heat.conductance
    law = HeatInterfaceLaw(
        conductance_law(case, interface.heat),
        interface.heat.partition,
        search_range(case, name, meshes, system.comm),
        temperature,
        coefficient=given(case, h) if h is not None and varies(interface.heat) else None,
        by_pressure=interface.heat.law not in ("insulated", "constant", "gas"),
    )
    return InterfaceLink(
        HeatInterface(name, nodes, law),
        to_heat,
        to_mechanics,
        interface.heat.pressure,
        interface.heat.dissipation,
        has_friction=interface.friction is not None,
        surface=mechanical,
    )
