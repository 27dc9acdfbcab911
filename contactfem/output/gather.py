"""Results gathered on the first rank."""

import numpy as np

from contactfem.case.schema import Case
from contactfem.common.typing import Floats, Ints
from contactfem.discretisation.discretise import Discretisation
from contactfem.discretisation.state import State
from contactfem.fem.body_mesh import gather_vertex_values
from contactfem.fem.nodal_average import nodal_average
from contactfem.laws.active_set import Status
from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.normals import line_tangents
from contactfem.results.data import BodyPicture, InterfaceTable, SurfaceHeat

STRESS = ("stress.xx", "stress.yy", "stress.zz", "stress.xy", "stress.yz", "stress.xz")
DISPLACEMENT = ("displacement.x", "displacement.y", "displacement.z")


def body_pictures(discretisation: Discretisation) -> list[BodyPicture]:
    """Bodies with displacement and nodal stress, on the first rank; collective.

    Args:
        discretisation: The bodies.

    Returns:
        One picture per body; empty elsewhere.
    """
    from dolfinx import fem

    pictures = []
    comm = discretisation.system.comm
    for name, body in discretisation.bodies.items():
        u = gather_vertex_values(comm, body.mesh, body.vertex_space, body.u.x.array)
        V = fem.functionspace(body.mesh.mesh, ("Lagrange", 1, (6,)))
        average = nodal_average(V, body.cell_stress())
        stress = gather_vertex_values(comm, body.mesh, V, average.x.array)
        data = body.mesh.data
        if data is not None and u is not None and stress is not None:
            pictures.append(BodyPicture(name, data.points, data.cells, u, {"stress": stress}))
    return pictures


def heat_pictures(discretisation: Discretisation, state: State) -> list[BodyPicture]:
    """Thermal meshes with temperature and nodal heat flux, on the first rank; collective.

    Args:
        discretisation: The bodies.
        state: The last good state.

    Returns:
        One picture per body; empty elsewhere, and where heat is not solved for.
    """
    from dolfinx import fem

    pictures = []
    comm = discretisation.system.comm
    for k, body in enumerate(discretisation.heat.bodies if discretisation.heat else ()):
        body.theta.x.array[:], body.u.x.array[:] = state.theta[k], state.thermal_u[k]
        domain = body.mesh.mesh
        u = gather_vertex_values(comm, body.mesh, body.displacement_space, body.u.x.array)
        theta = gather_vertex_values(comm, body.mesh, body.V, body.theta.x.array)
        V = fem.functionspace(domain, ("Lagrange", 1, (domain.geometry.dim,)))
        average = nodal_average(V, body.cell_flux())
        flux = gather_vertex_values(comm, body.mesh, V, average.x.array)
        data = body.mesh.data
        if data is not None and u is not None and theta is not None and flux is not None:
            fields = {"temperature": theta, "heat_flux": flux}
            pictures.append(BodyPicture(body.name, data.points, data.cells, u, fields))
    return pictures


def probe_values(
    case: Case, pictures: list[BodyPicture], heat: list[BodyPicture]
) -> dict[str, float]:
    """Values at the probes on the first rank, linear on the cell that holds the point.

    Args:
        case: Names the probes.
        pictures: The bodies' values; empty on other ranks.
        heat: Likewise on thermal meshes.

    Returns:
        Value by name [SI].
    """
    mechanical = {picture.name: picture for picture in pictures}
    thermal = {picture.name: picture for picture in heat}
    values = {}
    for name, probe in case.probes.items():
        found = thermal if probe.value == "temperature" else mechanical
        if probe.on not in found:
            continue
        picture = found[probe.on]
        nodes, weights = locate(picture, np.array(probe.at))
        if probe.value == "temperature":
            column = picture.fields["temperature"][:, 0]
        elif probe.value in STRESS:
            column = picture.fields["stress"][:, STRESS.index(probe.value)]
        else:
            column = picture.displacement[:, DISPLACEMENT.index(probe.value)]
        values[name] = float(weights @ column[nodes])
    return values


def locate(picture: BodyPicture, point: Floats) -> tuple[Ints, Floats]:
    """Vertices and weights that interpolate at a point of the reference configuration.

    Args:
        picture: The body.
        point: Reference position [m].

    Returns:
        Vertices and weights: along the nearest cell's edge or, inside, by distance to its simplex.
    """
    distance = np.linalg.norm(picture.points - point, axis=1)
    nearest = int(np.argmin(distance))
    if distance[nearest] <= 1e-9 * np.ptp(picture.points):
        return np.array([nearest]), np.ones(1)
    from scipy.spatial import Delaunay  # slow to import

    around = picture.cells[(picture.cells == nearest).any(1)]
    vertices = np.unique(around)
    mesh = Delaunay(picture.points[vertices])
    k = int(mesh.find_simplex(point, tol=1e-9))
    if k < 0:
        return np.array([nearest]), np.ones(1)
    transform = mesh.transform[k]
    first = transform[:-1] @ (point - transform[-1])
    return vertices[mesh.simplices[k]], np.append(first, 1.0 - first.sum())


def interface_tables(discretisation: Discretisation, state: State) -> list[InterfaceTable]:
    """Nodal values along every interface at the last good state, on all ranks; collective.

    Args:
        discretisation: The interfaces.
        state: The state.

    Returns:
        One table per interface; empty before the first step.
    """
    if not discretisation.interfaces:
        return _tables_of_heat(discretisation, state)
    tables = []
    pairs = zip(discretisation.interfaces, state.conditions, strict=False)
    for k, (interface, c) in enumerate(pairs):
        mesh, n = interface.nodes.mesh, interface.nodes.mesh.n_nonmortar
        op = c.operators
        pressure, slip = c.pressure, state.slip[k]
        space = mesh.dim == 3
        status = np.where(mesh.has_multiplier, c.status, Status.NONE).astype(np.int8)
        mortar = np.arange(n, n if interface.nodes.is_rigid else mesh.n_nodes)
        weight = np.asarray(op.M.sum(0)).ravel()[mortar]
        seen = np.asarray(op.M.T @ np.where(c.active, pressure, 0.0)).ravel()[mortar]
        tables.append(
            InterfaceTable(
                name=interface.name,
                X=mesh.X[:n],
                x=op.x[:n],
                arc=_arc(mesh, op.x),
                gap=np.where(np.isfinite(c.gap), c.gap, np.nan),
                pressure=pressure,
                traction=_along(c.traction, op.normals.n),
                slip=_along(slip, op.normals.n),
                status=status,
                coverage=op.coverage,
                facet_length=op.size,
                depth=op.depth,
                facets=mesh.nonmortar,
                mortar_x=op.x[mortar],
                mortar_pressure=np.divide(
                    seen, weight, out=np.zeros(len(mortar)), where=weight > 0.0
                ),
                heat=_surface_heat(discretisation, state, k),
                traction_vector=c.traction if space else None,
                slip_vector=slip if space else None,
            )
        )
    return tables


def _along(vectors: Floats, normals: Floats) -> Floats:
    """Tangential vectors along (n_y, -n_x); in space their lengths."""
    if vectors.shape[1] == 3:
        return np.asarray(np.linalg.norm(vectors, axis=1))
    return np.asarray(np.einsum("ji,ji->j", vectors, line_tangents(normals)))


def _tables_of_heat(discretisation: Discretisation, state: State) -> list[InterfaceTable]:
    """Tables of interfaces without mechanics: heat, and the pressure that was given; collective."""
    tables = []
    for k, link in enumerate(discretisation.heat.interfaces if discretisation.heat else ()):
        X = link.surface.X
        none, nothing = np.zeros(len(X)), np.full(len(X), np.nan)
        edge = X[link.surface.facets[:, 1]] - X[link.surface.facets[:, 0]]
        half = np.repeat(0.5 * np.hypot(*edge.T), 2)
        tables.append(
            InterfaceTable(
                name=link.heat.name,
                X=X,
                x=X,
                arc=np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(X, axis=0).T)))),
                gap=nothing,
                pressure=none if link.pressure is None else none + link.pressure(state.t),
                traction=none,
                slip=none,
                status=np.full(len(X), Status.NONE, np.int8),
                coverage=none,
                facet_length=np.bincount(link.surface.facets.ravel(), half).astype(np.float64),
                facets=link.surface.facets,
                mortar_x=np.empty((0, 2)),
                mortar_pressure=np.empty(0),
                heat=_surface_heat(discretisation, state, k),
            )
        )
    return tables


def _surface_heat(discretisation: Discretisation, state: State, k: int) -> SurfaceHeat | None:
    """Heat at the nonmortar nodes of an interface; collective."""
    if discretisation.heat is None or not state.exchanges:
        return None
    return discretisation.heat.surface_heat(k, state.theta, state.exchanges[k], state.t)


def _arc(mesh: InterfaceMesh, x: Floats) -> Floats:
    """Arc length along the nonmortar surface, which is numbered along its walk [m]."""
    if mesh.dim == 3:
        return np.zeros(mesh.n_nonmortar)
    step = np.hypot(*np.diff(x[: mesh.n_nonmortar], axis=0).T)
    return np.concatenate(([0.0], np.cumsum(step)))
