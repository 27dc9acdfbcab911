"""A body's mesh distributed over the ranks, with its input numbering."""

from collections.abc import Mapping
from dataclasses import dataclass

import basix.ufl
import numpy as np
import numpy.typing as npt
import ufl
from dolfinx.fem import FunctionSpace
from dolfinx.mesh import Mesh, exterior_facet_indices

from mpi4py import MPI

from contactfem.common.typing import Floats, Ints
from contactfem.errors import MeshError
from contactfem.fem.compat import cell_nodes, create_mesh
from contactfem.meshes.data import FACETS, CellName, MeshData, Surface, matches

Local = npt.NDArray[np.int32]


@dataclass(frozen=True)
class BodyMesh:
    """Distributed mesh of one body; its named surfaces are known to every rank.

    `data` is the input mesh, on rank 0 only. `ids` numbers the groups for `ds`.
    """

    mesh: Mesh
    surfaces: Mapping[str, Surface]
    n_points: int
    data: MeshData | None
    ids: Mapping[str, int]
    _facets: Mapping[str, Local]
    _integration: list[tuple[int, Local]]

    def facets(self, name: str) -> Local:
        """Owned facets of a group: local numbers (k,), ascending, each on one rank only."""
        return self._facets[name]

    def surface(self, name: str) -> Surface:
        """Whole surface of a group, the same on all ranks.

        Raises:
            MeshError: there is no such group.
        """
        if name not in self.surfaces:
            raise MeshError(f"the mesh has no group '{name}'; groups: {', '.join(self.surfaces)}")
        return self.surfaces[name]

    @property
    def groups(self) -> dict[str, Ints]:
        """Facets of every group by input vertices (k, nf), oriented outward, on all ranks."""
        return {name: s.vertices[s.facets] for name, s in self.surfaces.items()}

    def ds(self, name: str, degree: int | None = None) -> ufl.Measure:
        """Surface measure of a group; measures of several groups may stand in one form.

        Args:
            name: the group.
            degree: polynomial degree of the quadrature, estimated if None.

        Returns:
            The measure on the reference configuration.
        """
        return ufl.Measure(
            "ds",
            domain=self.mesh,
            subdomain_data=self._integration,
            subdomain_id=self.ids[name],
            metadata=None if degree is None else {"quadrature_degree": degree},
        )


def distribute(comm: MPI.Comm, data: MeshData | None) -> BodyMesh:
    """Spread a mesh over the ranks, collectively.

    Args:
        comm: communicator.
        data: the mesh on rank 0, None on the others.

    Returns:
        This rank's part of it, with ghosts over shared facets.

    Raises:
        ValueError: rank 0 gave no mesh.
    """
    if comm.rank == 0 and data is None:
        raise ValueError("rank 0 gives the mesh")
    head = None
    if data is not None:
        surfaces = {name: data.surface(name) for name in data.groups if len(data.groups[name])}
        head = (data.cell_type, data.points.shape, data.cells.shape[1], surfaces)
    cell_type, (n_points, dim), n_vertices, surfaces = comm.bcast(head)
    cells = data.cells if data is not None else np.empty((0, n_vertices), dtype=np.int64)
    points = data.points if data is not None else np.empty((0, dim))
    element = basix.ufl.element("Lagrange", cell_type, 1, shape=(dim,))
    mesh = create_mesh(comm, cells, points, ufl.Mesh(element))
    facets, pairs, vertices = _boundary(mesh, cell_type)
    owned = {
        name: np.flatnonzero(matches(vertices, s.vertices[s.facets]) >= 0)
        for name, s in surfaces.items()
    }
    ids = {name: k + 1 for k, name in enumerate(surfaces)}
    integration: list[tuple[int, Local]] = [
        (ids[name], pairs[rows].ravel()) for name, rows in owned.items()
    ]
    local = {name: facets[rows] for name, rows in owned.items()}
    return BodyMesh(mesh, surfaces, n_points, data, ids, local, integration)


def dof_of_vertex(mesh: Mesh, V: FunctionSpace) -> tuple[Local, Ints]:
    """Which unknowns sit at which vertex of the input mesh.

    Args:
        mesh: mesh of a `BodyMesh`.
        V: space on it with one dof block per vertex (more elsewhere do not matter), or a subspace.

    Returns:
        Local block dofs (m,), ascending, owned and ghost, and their input vertices (m,).
    """
    layout = V.dofmap.dof_layout
    nodes = cell_nodes(mesh)
    columns = [layout.entity_dofs(0, i)[0] for i in range(nodes.shape[1])]
    places = V.dofmap.list[:, columns]
    node = np.full(int(places.max(initial=-1)) + 1, -1, dtype=np.int64)
    node[places] = nodes
    dofs = np.flatnonzero(node >= 0)
    return dofs.astype(np.int32), mesh.geometry.input_global_indices[node[dofs]]


def dofs_at_vertices(mesh: Mesh, V: FunctionSpace) -> tuple[Ints, Ints]:
    """Which scalar unknowns are the components of a vector at which vertex of the input mesh.

    Args:
        mesh: mesh of a `BodyMesh`.
        V: space on it with unknowns at the vertices (more elsewhere do not matter), or a
            subspace; its components need not be blocked.

    Returns:
        Local scalar dofs (m, components) and input vertices (m,), ascending, owned and ghost.
    """
    columns = []
    for component in [V.sub(k) for k in range(V.num_sub_spaces)] or [V]:
        dofs, vertices = dof_of_vertex(mesh, component)
        order = np.argsort(vertices)
        columns.append(dofs[order].astype(np.int64))
    return np.column_stack(columns), vertices[order]


def gather_vertex_values(
    comm: MPI.Comm, body: BodyMesh, V: FunctionSpace, values: Floats
) -> Floats | None:
    """Vertex values in input numbering, collectively.

    Args:
        comm: the communicator of the mesh.
        body: the mesh.
        V: space on it with unknowns at the vertices, or a subspace.
        values: local scalar values, at least the owned ones, flat.

    Returns:
        (n_points, components) on rank 0, None elsewhere.
    """
    dofs, vertices = dofs_at_vertices(body.mesh, V)
    owned = dofs[:, 0] < V.dofmap.index_map.size_local * V.dofmap.index_map_bs
    mine = np.asarray(values)[dofs[owned]]
    parts = comm.gather((vertices[owned], mine))
    if parts is None:
        return None
    result = np.full((body.n_points, mine.shape[1]), np.nan)
    for numbers, part in parts:
        result[numbers] = part
    return result


def gather_cell_values(comm: MPI.Comm, body: BodyMesh, values: Floats) -> Floats | None:
    """Values of all cells in input numbering, collectively.

    Args:
        comm: the communicator of the mesh.
        body: the mesh.
        values: of this rank's cells, owned ones first (local, k).

    Returns:
        (cells, k) on rank 0, None elsewhere.
    """
    topology = body.mesh.topology
    owned = topology.index_map(topology.dim).size_local
    mine = np.asarray(topology.original_cell_index[:owned], np.int64)
    parts = comm.gather((mine, values[:owned]))
    if parts is None:
        return None
    result = np.empty((sum(len(numbers) for numbers, _ in parts), values.shape[1]))
    for numbers, part in parts:
        result[numbers] = part
    return result


def _boundary(mesh: Mesh, cell_type: CellName) -> tuple[Local, Local, Ints]:
    """Owned exterior facets.

    Returns:
        Local numbers (k,), pairs of cell and local facet (k, 2), input vertices (k, nf).
    """
    topology = mesh.topology
    tdim = topology.dim
    topology.create_connectivity(tdim - 1, tdim)
    topology.create_connectivity(tdim, tdim - 1)
    facets = np.sort(exterior_facet_indices(topology)).astype(np.int32)
    table = np.array(FACETS[cell_type])
    to_cell = topology.connectivity(tdim - 1, tdim)
    # Through the cell: entities_to_geometry divides by zero where there are no facets.
    cells = to_cell.array[to_cell.offsets[facets]]
    of_cell = topology.connectivity(tdim, tdim - 1).array.reshape(-1, len(table))
    local = np.argmax(of_cell[cells] == facets[:, None], axis=1)
    nodes = cell_nodes(mesh)[cells[:, None], table[local]]
    pairs = np.stack([cells, local], axis=1).astype(np.int32)
    return facets, pairs, mesh.geometry.input_global_indices[nodes]
