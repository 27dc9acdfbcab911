"""New meshes from size fields; the state carried over (28)-(31)."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from dolfinx import fem

from mpi4py import MPI

from contactfem.adaptivity.anisotropic_layers import flat_cells, regular_rows
from contactfem.adaptivity.decisions import NewSizes
from contactfem.case.schema import Case
from contactfem.common.typing import Floats
from contactfem.contact.slip import interpolated
from contactfem.contact.state import ContactHistory
from contactfem.discretisation.discretise import Discretisation
from contactfem.discretisation.meshes import GivenMeshes
from contactfem.discretisation.state import State, initial_state
from contactfem.errors import CaseError
from contactfem.fem.vertex_values import VertexValues
from contactfem.heat.body import HeatBody
from contactfem.heat.ringing import Increments
from contactfem.laws.active_set import ActiveSet
from contactfem.mechanics.body import BodyProblem
from contactfem.mechanics.contact_equations import Interface
from contactfem.mechanics.elements import cell_size
from contactfem.meshes.data import MeshData
from contactfem.meshes.layers import Layers
from contactfem.meshes.size_field import size_field
from contactfem.transfer.lumped_projection import LumpedProjection
from contactfem.transfer.surface import SurfaceTransfer
from contactfem.transfer.volume import VolumeTransfer

if TYPE_CHECKING:
    from contactfem.thermomechanics.thermal_problem import Thermal

NEARLY = 0.05  # relative change of a body's heat by interpolation up to which it is scaled back


def new_meshes(case: Case, present: Discretisation, sizes: NewSizes) -> GivenMeshes:
    """Advancing-front meshes of the exact geometries; collective.

    Args:
        case: The case.
        present: Has the present meshes.
        sizes: Wanted sizes.

    Returns:
        The meshes, on the first rank; on the others their names.

    Raises:
        CaseError: A body cannot be meshed at these sizes.
    """
    comm = present.system.comm
    found, error = GivenMeshes(dict.fromkeys(sizes.mechanical), dict.fromkeys(sizes.thermal)), None
    if comm.rank == 0:
        try:
            found = _made(case, present, sizes)
        except CaseError as raised:
            error = raised
    error = comm.bcast(error)
    if error is not None:
        raise error
    return found


def _made(case: Case, present: Discretisation, sizes: NewSizes) -> GivenMeshes:
    set_temperature = (
        {} if present.heat is None else {body.name: body.mesh for body in present.heat.bodies}
    )
    return GivenMeshes(
        {
            name: _mesh(
                case, name, present.bodies[name].mesh.data, wanted, regular_rows(case, name)
            )
            for name, wanted in sizes.mechanical.items()
        },
        {
            name: _mesh(case, name, set_temperature[name].data, wanted, flat_cells(case, name))
            for name, wanted in sizes.thermal.items()
        },
    )


def _mesh(
    case: Case, name: str, data: MeshData | None, sizes: Floats, layers: Layers | None
) -> MeshData:
    """A mesh of a body with new sizes, given on its present one."""
    assert data is not None
    keep = [c.at for c in case.conditions if c.body == name and c.at is not None]
    keep += [probe.at for probe in case.probes.values() if probe.on == name]
    try:
        return case.bodies[name].mesh.adapted(size_field(data, sizes), keep, layers)
    except CaseError as error:
        raise CaseError(f"{case.path}: bodies.{name}: no adapted mesh: {error}") from None


def carried(old: Discretisation, new: Discretisation, state: State, ramp_end: float) -> State:
    """The state of a run on new meshes; collective. The bodies of both are set to it.

    Displacements and slip are interpolated at the nodes, temperatures projected, and scaled so that
    a body's heat is kept. Contact starts from the status of the nearest old node and from the new
    operators at the present positions; forces follow with the next equilibrium. At time zero the
    initial state is taken anew instead.

    Args:
        old: The present meshes.
        new: The new ones.
        state: The last good state on the old meshes.
        ramp_end: Time at which constant motions are reached [s].

    Returns:
        That state on the new meshes.
    """
    state.restore(old)
    if state.t == 0.0:  # what is given then has its values on any mesh
        return initial_state(new, ramp_end)
    result = replace(state, repeatable=False)
    if new.system is not old.system:
        result = _carry_mechanics(old, new, result, ramp_end)
    if old.heat is not None and new.heat is not None:
        _carry_temperatures(old.heat, new, result)
    return result


def _carry_mechanics(
    old: Discretisation, new: Discretisation, state: State, ramp_end: float
) -> State:
    """The mechanical side of a state, which the old bodies are set to, on new meshes."""
    comm, system = new.system.comm, new.system
    for name, body in new.bodies.items():
        if body is not old.bodies[name]:
            _carry_displacement(comm, old.bodies[name], body)
    u = [body.u.x.array.copy() for body in system.bodies]
    system.from_fields(u, system.x)
    system.spread(system.x)
    pairs = list(zip(old.interfaces, new.interfaces, strict=True))
    transfers = [_surface(old, new, k) for k in range(len(pairs))]
    histories = tuple(
        _history(after, history, transfer, state.t, ramp_end)
        for (_, after), history, transfer in zip(pairs, state.histories, transfers, strict=True)
    )
    return replace(
        state,
        x=system.x.array.copy(),
        u=[body.u.x.array.copy() for body in system.bodies],
        histories=histories,
        slip=[
            interpolated(transfer.matrix, slip, before.normals, after.normals)
            for transfer, slip, before, after in zip(
                transfers, state.slip, state.histories, histories, strict=True
            )
        ],
        conditions=(),
        guess=tuple(
            _nearest(transfer, guess)
            for transfer, guess in zip(transfers, state.starts(), strict=True)
        ),
    )


def _carry_temperatures(old: Thermal, new: Discretisation, state: State) -> None:
    """The heat side of a state on new meshes, or with mechanics on new ones."""
    assert new.heat is not None
    comm, thermal = new.system.comm, new.heat
    theta, rate = [values.copy() for values in state.theta], list(state.rate)
    for k, (a, b) in enumerate(zip(old.bodies, thermal.bodies, strict=True)):
        if a is b:
            continue
        move = LumpedProjection(comm, a.mesh, b.mesh, a.name)
        theta[k] = _carry_heat(comm, move, a, b, theta[k])
        if rate:
            rate[k] = _moved(comm, move.vertices, a, b, rate[k])
    thermal.system.set_held(state.t, theta)
    for link, values in zip(thermal.links if thermal.moving else (), theta, strict=False):
        link.set_displacement()
        link.set_temperature(values)
    state.accept_heat(theta, (), new)
    state.rate, state.increments = rate, Increments()


def _carry_displacement(comm: MPI.Comm, old: BodyProblem, new: BodyProblem) -> None:
    """Interpolate displacements, and the mean stress of MINI; linear in new cells."""
    move = VolumeTransfer(comm, old.mesh, new.mesh, old.name)
    values = VertexValues(comm, old.mesh, old.vertex_space).replicate(old.u.x.array)
    domain = new.mesh.mesh
    linear = fem.Function(fem.functionspace(domain, ("Lagrange", 1, (domain.geometry.dim,))))
    VertexValues(comm, new.mesh, linear.function_space).insert(move(values), linear.x.array)
    new.displacement.interpolate(linear)  # unknowns of bubbles are values in the middle of cells
    if old.law.mixed is not None:
        # The unknown is p h/μ with the mean cell size h
        scale = cell_size(new.mesh) / cell_size(old.mesh)
        p = VertexValues(comm, old.mesh, old.V.sub(1)).replicate(old.u.x.array)
        VertexValues(comm, new.mesh, new.V.sub(1)).insert(scale * move(p), new.u.x.array)


def _surface(old: Discretisation, new: Discretisation, k: int) -> SurfaceTransfer:
    """Transfer along the nonmortar surface of an interface."""
    side = old.interfaces[k].nodes.nonmortar
    body = list(old.bodies)[side.body]
    return SurfaceTransfer(
        side.surface, new.interfaces[k].nodes.nonmortar.surface, f"{body}: {old.interfaces[k].name}"
    )


def _history(
    interface: Interface,
    history: ContactHistory,
    transfer: SurfaceTransfer,
    t: float,
    ramp_end: float,
) -> ContactHistory:
    """What the next step starts from, at the new nodes."""
    operators = interface.contact.operators(interface.nodes.positions(t, ramp_end))
    pressure, traction = history.pressure, history.traction
    if pressure is not None:
        pressure = transfer(pressure)
    normals = operators.normals.n
    if traction is not None:
        traction = interpolated(transfer.matrix, traction, history.normals, normals)
    return ContactHistory(operators.D, operators.M, normals, operators.x, pressure, traction)


def _nearest(transfer: SurfaceTransfer, start: ActiveSet | None) -> ActiveSet | None:
    """Status of the nearest old node."""
    if start is None:
        return None
    at = np.asarray(transfer.matrix.argmax(axis=1)).ravel()
    return ActiveSet(start.status[at], start.direction[at])


def _carry_heat(
    comm: MPI.Comm, move: LumpedProjection, old: HeatBody, new: HeatBody, theta: Floats
) -> Floats:
    """Project temperatures, and keep the heat that they hold to round-off."""
    result = _moved(comm, move, old, new, theta)
    before, after = (
        comm.allreduce(float(body.stored(values).sum()))
        for body, values in ((old, theta), (new, result))
    )
    if abs(after - before) <= NEARLY * abs(after):
        return result * (before / after) if after != 0.0 else result
    capacity = comm.allreduce(float(new.stored(np.ones_like(result)).sum()))
    return result + (before - after) / capacity if capacity > 0.0 else result


def _moved(
    comm: MPI.Comm,
    move: VolumeTransfer | LumpedProjection,
    old: HeatBody,
    new: HeatBody,
    values: Floats,
) -> Floats:
    result = np.zeros(new.n_dofs)
    replicated = VertexValues(comm, old.mesh, old.V).replicate(values)
    VertexValues(comm, new.mesh, new.V).insert(move(replicated), result)
    return result
