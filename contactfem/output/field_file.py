"""Gather fields of bodies and contact surfaces into one VTKHDF file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mpi4py import MPI

from contactfem.case.schema import Case
from contactfem.common.typing import Floats
from contactfem.discretisation.discretise import Discretisation
from contactfem.discretisation.state import State
from contactfem.errors import WriteError
from contactfem.fem.body_mesh import BodyMesh, gather_cell_values, gather_vertex_values
from contactfem.output.gather import interface_tables
from contactfem.output.vtkhdf import NAME, Block, VtkHdfFile
from contactfem.results.data import InterfaceTable, MeshErrors, SurfaceHeat

if TYPE_CHECKING:
    from contactfem.heat.body import HeatBody
    from contactfem.mechanics.body import BodyProblem

FACETS = {1: "point", 2: "interval", 3: "triangle", 4: "quadrilateral"}  # by their vertices
NOTHING = 1e-9  # of a temperature's range: a smaller jump tells no conductance


class FieldFile:
    """Writes the fields of a run.

    Args:
        case: The case.
        comm: All ranks; the first one writes.
        out: Folder of the run; it exists.
        last: Time up to which what an earlier run wrote counts [s]; None to begin anew.
    """

    def __init__(self, case: Case, comm: MPI.Comm, out: Path, last: float | None) -> None:
        self._case, self._comm, self._path = case, comm, out / NAME
        self._file = VtkHdfFile(self._path, last) if comm.rank == 0 else None

    def write(
        self,
        t: float,
        discretisation: Discretisation,
        state: State,
        errors: Sequence[MeshErrors] = (),
    ) -> None:
        """Add a time; collective.

        Args:
            t: The time [s].
            discretisation: The bodies, with the fields of that time.
            state: The state at that time.
            errors: Errors of the cells, where meshes adapt.

        Raises:
            WriteError: There is no room, on all ranks alike.
        """
        blocks = [
            *self._bodies(discretisation, errors),
            *self._thermal(discretisation, errors),
            *self._surfaces(interface_tables(discretisation, state), discretisation),
        ]
        trouble = ""
        if self._file is not None:
            try:
                self._file.append(t, blocks)
            except OSError as error:
                trouble = f"{self._path}: cannot be written: {error.strerror or error}"
        if trouble := self._comm.bcast(trouble):
            raise WriteError(trouble)

    def _shared(self, discretisation: Discretisation, body: HeatBody) -> bool:
        """Whether the temperature of a body stands on its mechanical mesh, and always will."""
        found = discretisation.bodies.get(body.name)
        alone = not self._case.mechanics or self._case.adaptivity is not None
        return not alone and found is not None and found.mesh is body.mesh

    def _bodies(self, discretisation: Discretisation, errors: Sequence[MeshErrors]) -> list[Block]:
        """Mechanical meshes, with the temperature where it stands there; collective."""
        if not self._case.mechanics:
            return []
        blocks, heat = [], discretisation.heat
        thermal = {body.name: body for body in (heat.bodies if heat is not None else ())}
        for name, body in discretisation.bodies.items():
            fields = _stressed(self._comm, body)
            if name in thermal and self._shared(discretisation, thermal[name]):
                fields |= _heated(self._comm, thermal[name])
            blocks += self._block(name, "mechanics", body.mesh, fields, errors)
        return blocks

    def _thermal(self, discretisation: Discretisation, errors: Sequence[MeshErrors]) -> list[Block]:
        """Thermal meshes of their own; collective."""
        blocks, heat = [], discretisation.heat
        for body in heat.bodies if heat is not None else ():
            if self._shared(discretisation, body):
                continue
            space, values = body.displacement_space, body.u.x.array
            u = gather_vertex_values(self._comm, body.mesh, space, values)
            fields = _heated(self._comm, body) | ({} if u is None else {"displacement": u})
            name = f"{body.name} heat" if self._case.mechanics else body.name
            blocks += self._block(name, "heat", body.mesh, fields, errors, body.name)
        return blocks

    def _block(
        self,
        name: str,
        problem: str,
        mesh: BodyMesh,
        fields: dict[str, Floats],
        errors: Sequence[MeshErrors],
        body: str = "",
    ) -> list[Block]:
        """The block of a mesh, on the first rank."""
        data = mesh.data
        if data is None:
            return []
        cell_data: dict[str, Floats] = {}
        if self._case.adaptivity is not None:
            cell_data["error_density"] = np.full(len(data.cells), np.nan)
            for found in errors:
                same = (found.problem, found.body) == (problem, body or name)
                if same and np.array_equal(found.cells, data.cells):
                    cell_data["error_density"] = found.density
        return [Block(name, data.points, data.cells, data.cell_type, fields, cell_data)]

    def _surfaces(
        self, tables: Sequence[InterfaceTable], discretisation: Discretisation
    ) -> list[Block]:
        """Contact surfaces, on the first rank."""
        if self._comm.rank > 0:
            return []
        heated = discretisation.heat is not None
        taken = {*self._case.bodies, *(f"{name} heat" for name in self._case.bodies)}
        return [surface_block(table, heated, taken) for table in tables]


def _stressed(comm: MPI.Comm, body: BodyProblem) -> dict[str, Floats]:
    """Displacement, Cauchy stress and von Mises stress of a body, on the first rank; collective."""
    u = gather_vertex_values(comm, body.mesh, body.vertex_space, body.u.x.array)
    stress = _averaged(comm, body.mesh, body.cell_stress())
    if u is None or stress is None:
        return {}
    return {"displacement": u, "stress": stress, "von_mises": von_mises(stress)}


def _heated(comm: MPI.Comm, body: HeatBody) -> dict[str, Floats]:
    """Temperature and heat flux of a body, on the first rank; collective."""
    theta = gather_vertex_values(comm, body.mesh, body.V, body.theta.x.array)
    flux = _averaged(comm, body.mesh, body.cell_flux())
    return {} if theta is None or flux is None else {"temperature": theta[:, 0], "heat_flux": flux}


def _averaged(comm: MPI.Comm, mesh: BodyMesh, values: Floats) -> Floats | None:
    """Mean of the cells around every vertex, on the first rank; collective."""
    gathered = gather_cell_values(comm, mesh, values)
    if gathered is None or mesh.data is None:
        return None
    cells = mesh.data.cells
    at, n = cells.ravel(), mesh.n_points
    count = np.maximum(np.bincount(at, minlength=n), 1)
    columns = [np.bincount(at, np.repeat(c, cells.shape[1]), minlength=n) for c in gathered.T]
    found: Floats = np.column_stack(columns) / count[:, None]
    return found


def von_mises(stress: Floats) -> Floats:
    """Equivalent stress √(3/2 s:s) of the deviator s.

    Args:
        stress: xx, yy, zz, xy, yz, xz (n, 6) [Pa].

    Returns:
        (n,) [Pa].
    """
    deviator = stress[:, :3] - stress[:, :3].mean(1, keepdims=True)
    found: Floats = np.sqrt(1.5 * (deviator**2).sum(1) + 3.0 * (stress[:, 3:] ** 2).sum(1))
    return found


def surface_block(table: InterfaceTable, heated: bool, taken: set[str]) -> Block:
    """The block of a contact surface.

    Args:
        table: Its nodes.
        heated: Whether heat is solved for.
        taken: Names of other blocks, which it may not have.

    Returns:
        The block.
    """
    fields = {
        "displacement": table.x - table.X,
        "pressure": table.pressure,
        "traction": table.traction if table.traction_vector is None else table.traction_vector,
        "gap": table.gap,
        "slip": table.slip if table.slip_vector is None else table.slip_vector,
        "status": table.status.astype(np.float64),
        "coverage": table.coverage,
    }
    if heated:
        nothing = np.full(len(table.X), np.nan)
        heat = table.heat or SurfaceHeat(nothing, nothing, nothing, nothing)
        jump = heat.temperature - heat.mortar_temperature
        least = NOTHING * np.nanmax(np.abs(heat.temperature), initial=1.0)
        fields |= {
            "temperature": heat.temperature,
            "mortar_temperature": heat.mortar_temperature,
            "heat_flux": heat.flux,
            "dissipation": heat.dissipation,
            "conductance": np.divide(heat.flux, jump, out=nothing.copy(), where=abs(jump) > least),
        }
    name = f"{table.name} surface" if table.name in taken else table.name
    facets = table.facets
    return Block(name, table.X, facets, FACETS[facets.shape[1]], fields)
