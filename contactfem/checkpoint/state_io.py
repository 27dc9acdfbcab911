"""The state of a run as arrays, for any number of ranks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from dolfinx import fem

from mpi4py import MPI

from contactfem.checkpoint import serialization as packing
from contactfem.checkpoint.archive import Array, Tree
from contactfem.common.typing import Floats, Ints
from contactfem.discretisation.discretise import Discretisation
from contactfem.discretisation.meshes import GivenMeshes
from contactfem.discretisation.state import State
from contactfem.fem.body_mesh import BodyMesh
from contactfem.heat.ringing import Increment, Increments, Zigzag
from contactfem.meshes.data import FACETS, MeshData

if TYPE_CHECKING:
    from contactfem.thermomechanics.thermal_problem import Thermal


def snapshot(discretisation: Discretisation, state: State, before: State | None = None) -> Tree:
    """States and meshes of a run; collective.

    Values of finite element functions are kept cell by cell, in the order of the input mesh: it
    then does not matter where an element has its unknowns.

    Args:
        discretisation: The meshes.
        state: The state.
        before: The state before it, if the run may go back to that.

    Returns:
        The arrays on the first rank; elsewhere an empty tree.
    """
    heat = discretisation.heat
    tree: Tree = {"state": _of_state(discretisation, state)}
    if before is not None:
        tree["before"] = _of_state(discretisation, before)
    if discretisation.system.comm.rank:
        return {}
    tree["meshes"] = {name: _of_mesh(body.mesh) for name, body in discretisation.bodies.items()}
    if heat is not None:
        tree["thermal_meshes"] = {
            body.name: _of_mesh(body.mesh)
            for body in heat.bodies
            if body.mesh is not discretisation.bodies[body.name].mesh
        }
    return tree


def meshes(tree: Tree) -> GivenMeshes:
    """Meshes of a snapshot.

    Args:
        tree: The snapshot; empty but on the first rank.
    """
    mechanical, thermal = (
        {name: _mesh(part) for name, part in tree.get(key, {}).items()}
        for key in ("meshes", "thermal_meshes")
    )
    return GivenMeshes(mechanical, thermal)


def restored(
    discretisation: Discretisation, tree: Tree, ramp_end: float
) -> tuple[State, State | None]:
    """States of a snapshot; the bodies are set to the last one; collective.

    Args:
        discretisation: Of the snapshot's meshes.
        tree: The snapshot; only looked at on the first rank.
        ramp_end: Time at which constant loads and motions are reached [s].

    Returns:
        The state, and the one before it if that was kept.
    """
    comm = discretisation.system.comm
    tree = comm.bcast({name: tree[name] for name in ("state", "before") if name in tree})
    before = _state(discretisation, tree["before"], ramp_end) if "before" in tree else None
    return _state(discretisation, tree["state"], ramp_end), before


def _of_state(discretisation: Discretisation, state: State) -> Tree:
    """Collective; whole on the first rank."""
    system, heat = discretisation.system, discretisation.heat
    pairs = zip(discretisation.bodies.items(), state.u, strict=True)
    others = len(system.tied) + len(system.multipliers)  # stand first, on the first rank
    tree: Tree = {
        "t": np.array(state.t),
        "dt": np.array(state.dt),
        "repeatable": np.array(state.repeatable),
        "displacement": {name: _gathered(system.comm, body.V, u) for (name, body), u in pairs},
        "warmth": {
            body.name: _gathered(
                system.comm, body.temperature.function_space, mechanical_temperature
            )
            for body, mechanical_temperature in zip(
                system.bodies, state.mechanical_temperature, strict=False
            )
            if body.temperature is not None
        },
        "others": state.x[:others],
        "interfaces": {
            interface.name: _of_interface(state, k)
            for k, interface in enumerate(discretisation.interfaces)
        },
    }
    if heat is not None:
        tree["heat"] = _of_heat(heat, state)
    return tree


def _state(discretisation: Discretisation, tree: Tree, ramp_end: float) -> State:
    """A state, to which the bodies are set; collective."""
    system = discretisation.system
    t, dt = tree["t"].item(), tree["dt"].item()
    if not (np.isfinite(t) and t >= 0.0 and np.isfinite(dt) and dt >= 0.0):
        raise ValueError(f"no state can be of t = {t:g} s after a step of {dt:g} s")
    for name, body in discretisation.bodies.items():
        _insert(body.V, tree["displacement"][name], body.u.x.array)
        if body.temperature is not None:
            _insert(body.temperature.function_space, tree["warmth"][name], body.temperature.x.array)
        body.set_time(t, ramp_end)
    _set_unknowns(discretisation, tree["others"])
    parts = [tree["interfaces"][interface.name] for interface in discretisation.interfaces]
    found, guess = [], []
    for interface, part in zip(discretisation.interfaces, parts, strict=True):
        mesh = interface.nodes.mesh
        packing.check_lengths(part, (mesh.n_nonmortar, mesh.n_nodes), mesh.n_nonmortar)
        operators = interface.contact.operators(interface.nodes.positions(t, ramp_end))
        if "conditions" in part:
            found.append(packing.contact_state(part["conditions"], interface.contact, operators))
        guess.append(packing.active_set(part["guess"]) if "guess" in part else None)
    state = State(
        t,
        system.x.array.copy(),
        [body.u.x.array.copy() for body in system.bodies],
        tuple(packing.history(part["history"]) for part in parts),
        [part["slip"] for part in parts],
        tuple(found),
        dt=dt,
        repeatable=bool(tree["repeatable"]),
        guess=tuple(guess),
    )
    if discretisation.heat is not None:
        _restore_heat(discretisation.heat, tree["heat"], state, discretisation)
    return state


def _set_unknowns(discretisation: Discretisation, others: Array) -> None:
    """Fill the vector of unknowns from the displacements, and from grips and multipliers."""
    system, n = discretisation.system, discretisation.system.numbering
    x = system.x.array
    for body, unknown in zip(system.bodies, n.unknown, strict=True):
        mine = (unknown >= n.first) & (unknown < n.first + n.n_local)
        x[unknown[mine] - n.first] = body.u.x.array[mine]
    if system.comm.rank == 0:
        x[: len(others)] = others


def _of_interface(state: State, k: int) -> Tree:
    tree: Tree = {"slip": state.slip[k], "history": packing.packed(state.histories[k])}
    if state.conditions:
        tree["conditions"] = packing.packed_state(state.conditions[k])
    if state.guess and state.guess[k] is not None:
        tree["guess"] = packing.packed(state.guess[k])
    return tree


def _of_heat(heat: Thermal, state: State) -> Tree:
    """Fields on the thermal meshes, exchanges and increments; collective."""
    comm, increments = heat.system.comm, state.increments
    zigzags = increments.zigzags
    scalars = {
        "temperature": state.theta,
        "rate": state.rate,
        "change": increments.last,
        "last_rate": [z.rate for z in zigzags],
        "turn": [z.turn for z in zigzags],
        "alternations": [z.count for z in zigzags],
    }
    bodies: Tree = {}
    for k, body in enumerate(heat.bodies):
        bodies[body.name] = {
            name: _gathered(comm, body.V, values[k]) for name, values in scalars.items() if values
        }
        moved = _gathered(comm, body.displacement_space, state.thermal_u[k])
        bodies[body.name]["displacement"] = moved
    return {
        "bodies": bodies,
        "exchanges": {
            link.heat.name: packing.packed(exchange)
            for link, exchange in zip(heat.interfaces, state.exchanges, strict=False)
        },
        "increments": np.array([(i.norm, i.inner) for i in increments.recent]),
        "largest": np.array(increments.largest),
    }


def _restore_heat(heat: Thermal, tree: Tree, state: State, discretisation: Discretisation) -> None:
    names = ("temperature", "rate", "change", "last_rate", "turn", "alternations")
    fields: dict[str, list[Floats]] = {name: [] for name in names}
    for body in heat.bodies:
        part = tree["bodies"][body.name]
        _insert(body.displacement_space, part["displacement"], body.u.x.array)
        for name in fields.keys() & part.keys():
            fields[name].append(np.zeros(body.n_dofs))
            _insert(body.V, part[name], fields[name][-1])
    exchanges = []
    for link in heat.interfaces if tree.get("exchanges") else ():
        part, mesh = tree["exchanges"][link.heat.name], link.heat.nodes.mesh
        n, every = mesh.n_nonmortar, mesh.n_nodes
        own = {name: part[name] for name in ("conduction", "friction")}
        packing.check_lengths(own, (every, every), every)
        packing.check_lengths(part["means"], (n, every), n)
        exchanges.append(packing.exchange(part))
    state.rate = fields["rate"]
    state.accept_heat(fields["temperature"], exchanges, discretisation)
    recent = tuple(Increment(float(norm), float(inner)) for norm, inner in tree["increments"])
    columns = (fields[name] for name in ("last_rate", "turn", "alternations"))
    zigzags = tuple(Zigzag(*arrays) for arrays in zip(*columns, strict=True))
    largest = float(tree["largest"])
    state.increments = Increments(tuple(fields["change"]), recent, largest, zigzags)


def _of_mesh(mesh: BodyMesh) -> Tree:
    data = mesh.data
    assert data is not None
    return {
        "points": data.points,
        "cells": data.cells,
        "cell_type": np.array(data.cell_type),
        "names": np.array(list(data.groups), dtype=str),
        "groups": {str(k): facets for k, facets in enumerate(data.groups.values())},
        "cell_names": np.array(list(data.cell_groups), dtype=str),
        "cell_groups": {str(k): cells for k, cells in enumerate(data.cell_groups.values())},
    }


def _mesh(tree: Tree) -> MeshData:
    groups = {str(name): tree["groups"][str(k)] for k, name in enumerate(tree["names"])}
    parts = {
        str(name): tree["cell_groups"][str(k)] for k, name in enumerate(tree.get("cell_names", ()))
    }
    points, cells = tree["points"], tree["cells"]
    if points.ndim != 2 or not np.isfinite(points).all() or cells.ndim != 2 or not len(cells):
        raise ValueError("a mesh is none")
    if tree["cell_type"].ndim or str(tree["cell_type"]) not in FACETS:
        raise ValueError("a mesh has cells of an unknown kind")
    for numbers in (cells, *groups.values()):
        if numbers.dtype.kind != "i" or numbers.min(initial=0) < 0:
            raise ValueError("a mesh has numbers of nodes that are none")
        if numbers.max(initial=0) >= len(points):
            raise ValueError("a mesh names nodes that it does not have")
    for numbers in parts.values():
        if numbers.dtype.kind != "i" or not ((0 <= numbers) & (numbers < len(cells))).all():
            raise ValueError("a mesh names cells that it does not have")
    return MeshData(tree["points"], tree["cells"], str(tree["cell_type"]), groups, parts)  # type: ignore[arg-type]


def _gathered(comm: MPI.Comm, V: fem.FunctionSpace, values: Floats) -> Floats:
    """Local values as (cells, dofs) in the order of the input cells, on the first rank."""
    topology = V.mesh.topology
    cells = topology.index_map(topology.dim)
    owned = cells.size_local
    parts = comm.gather((topology.original_cell_index[:owned], values[_dofs(V)[:owned]]))
    if parts is None:
        return np.empty((0, 0))
    table = np.empty((cells.size_global, parts[0][1].shape[1]))
    for numbers, part in parts:
        table[numbers] = part
    return table


def _insert(V: fem.FunctionSpace, table: Array, into: Floats) -> None:
    """Write values of all input cells to this rank's dofs, owned and ghost.

    Raises:
        ValueError: The values are of another mesh, or not finite.
    """
    dofs = _dofs(V)
    if table.shape != (V.mesh.topology.index_map(V.mesh.topology.dim).size_global, dofs.shape[1]):
        raise ValueError(f"values of shape {table.shape} are of another mesh")
    if not np.isfinite(table).all():
        raise ValueError("values are not finite")
    into[dofs] = table[V.mesh.topology.original_cell_index]


def _dofs(V: fem.FunctionSpace) -> Ints:
    """Scalar dofs of every local cell, owned cells first, (cells, dofs)."""
    bs, blocks = V.dofmap.index_map_bs, V.dofmap.list
    dofs = bs * blocks[:, :, None].astype(np.int64) + np.arange(bs)
    return np.asarray(dofs.reshape(len(blocks), bs * blocks.shape[1]))
