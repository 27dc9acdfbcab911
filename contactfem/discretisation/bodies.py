"""Bodies of a case as equations."""

from __future__ import annotations

import numpy as np

from mpi4py import MPI

from contactfem.case.base import AXES
from contactfem.case.body_meshes import ON_AXIS
from contactfem.case.cell_materials import CellMaterials, cell_materials
from contactfem.case.element_choice import element_of
from contactfem.case.materials import Material
from contactfem.case.scene import Condition
from contactfem.case.schema import Case
from contactfem.case.temperature_scale import given_temperature, reference_temperature
from contactfem.common import user_function as functions
from contactfem.common.time_table import constant
from contactfem.common.typing import Ints
from contactfem.discretisation.given_data import given
from contactfem.errors import CaseError
from contactfem.fem.body_mesh import BodyMesh
from contactfem.forms.energies import (
    linear_elastic,
    linear_elastic_mixed,
    neo_hooke,
    neo_hooke_mixed,
)
from contactfem.forms.mechanics import Energy
from contactfem.geometry.rigid_motions import free_rigid_modes
from contactfem.mechanics.body import BodyProblem, Law, Load


def on_axis(mesh: BodyMesh, comm: MPI.Comm) -> Ints:
    """Vertices on the axis x = 0, on all ranks; collective."""
    r = None if mesh.data is None else mesh.data.points[:, 0]
    found = None if r is None else np.flatnonzero(np.abs(r) <= ON_AXIS * np.abs(r).max())
    return np.asarray(comm.bcast(found))


def body_problem(case: Case, name: str, mesh: BodyMesh) -> BodyProblem:
    """Equations of one body: its element, law and loads."""
    body = case.bodies[name]
    materials = materials_of(case, name, mesh)
    cell = mesh.mesh.basix_cell().name
    elements = {element_of(body, case.materials[each], cell) for each in materials.names}
    law = _law(case, materials, mixed="MINI" in elements)
    loads = [load for c in case.conditions if c.body == name for load in _loads(case, c)]
    theta = given_temperature(case, name) if case.heat is None else None
    return BodyProblem(name, mesh, law, theta, loads, case.axisymmetric)


def materials_of(case: Case, name: str, mesh: BodyMesh) -> CellMaterials:
    """Materials of a body's cells, on all ranks; collective.

    Raises:
        CaseError: Its groups of cells do not give one to each.
    """
    if not case.bodies[name].materials:
        return CellMaterials(case.bodies[name].all_materials, None)
    found = None if mesh.data is None else cell_materials(case, name, mesh.data)
    materials: CellMaterials = mesh.mesh.comm.bcast(found)
    return materials


def _law(case: Case, materials: CellMaterials, *, mixed: bool) -> Law:
    """Energy and parameters of a body's materials, which all have one model."""
    small = case.strain == "small"
    each = {name: _parameters(case.materials[name]) for name in materials.names}
    first = case.materials[materials.names[0]]
    reference = reference_temperature(first)
    parameters = {
        key: materials.values({name: own[key] for name, own in each.items()})
        for key in each[materials.names[0]]
    }
    E = max(case.materials[name].E for name in materials.names)
    if first.model == "neo-hooke":
        built_in = linear_elastic if small else neo_hooke
        with_mean_stress = linear_elastic_mixed if small else neo_hooke_mixed
        mean = with_mean_stress if mixed else None
        return Law(built_in, parameters, E, small, small, mean, reference)
    energy = _user_energy(case, first.model)
    return Law(energy, parameters, E, small, linear=False, reference=reference)


def _parameters(material: Material) -> dict[str, float]:
    """What stands in a material's energy, by name."""
    return {
        "bulk_modulus": material.K,
        "shear_modulus": material.mu,
        "expansion": material.expansion,
    } | material.parameters


def _user_energy(case: Case, reference: str) -> Energy:
    """A user's energy "file.py:function", the file relative to the case."""
    try:
        return functions.reference(reference).load(case.path.parent)
    except CaseError as error:
        raise CaseError(f"{case.path}: material model {error}") from None


def _loads(case: Case, condition: Condition) -> list[Load]:
    """Loads of a condition, none if it prescribes a motion."""
    if condition.pressure is not None:
        return [Load(condition.surface, (given(case, condition.pressure),))]
    found = condition.traction or condition.body_force
    if found is None:
        return []
    zero = constant(0.0)
    components = tuple(given(case, found.get(axis, zero)) for axis in AXES[: case.axes])
    return [Load(condition.surface if condition.traction else None, components)]


def vertices_of_condition(
    condition: Condition, meshes: dict[str, BodyMesh], comm: MPI.Comm
) -> Ints:
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


def is_unrestrained(case: Case, name: str, mesh: BodyMesh) -> bool:
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
