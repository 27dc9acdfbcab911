"""Nodal values from one mesh of a body to another: sparse matrices, built once per pair of meshes.

Values are replicated: each rank holds those of all vertices, in input numbering, and the same
matrices, so that to apply one takes no communication.
"""

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from dolfinx.fem import FunctionSpace

from mpi4py import MPI

from contactfem.common.block_csr import block_rows
from contactfem.common.typing import Floats, Ints
from contactfem.errors import MeshError
from contactfem.fem.body_mesh import BodyMesh, dofs_at_vertices
from contactfem.geometry.closest_point import NearestFacets
from contactfem.meshes.data import MeshData, Surface
from contactfem.transfer.point_location import Location, cell_sizes, simplices, surroundings

FAR = 0.5  # of the larger one of the cells: how far outside of the source a vertex may lie


class VertexValues:
    """Where a space keeps its values at the vertices of a body's mesh."""

    def __init__(self, comm: MPI.Comm, body: BodyMesh, V: FunctionSpace) -> None:
        """Find the unknowns at the vertices, once for all later calls.

        Args:
            comm: the communicator of the mesh.
            body: the mesh.
            V: scalar or vector space with unknowns at the vertices, or a subspace; unknowns
                elsewhere, such as bubbles, are passed over.
        """
        self._comm = comm
        self._n_points = body.n_points
        self._dofs, self._vertices = dofs_at_vertices(body.mesh, V)
        n_owned = V.dofmap.index_map.size_local * V.dofmap.index_map_bs
        owned = self._dofs[:, 0] < n_owned
        self._owned, self._mine = self._dofs[owned], self._vertices[owned]

    def replicate(self, values: Floats) -> Floats:
        """Values at all vertices, on all ranks; collective.

        Args:
            values: local scalar values, at least the owned ones, flat.

        Returns:
            (n_points, components).
        """
        result = np.zeros((self._n_points, self._dofs.shape[1]))
        result[self._mine] = np.asarray(values)[self._owned]
        self._comm.Allreduce(MPI.IN_PLACE, result)
        return result

    def insert(self, values: Floats, into: Floats) -> None:
        """Write values at all vertices to this rank's ones.

        Args:
            values: (n_points, components), the same on all ranks.
            into: local scalar values, owned and ghost, flat; other unknowns are left alone.
        """
        into[self._dofs] = values[self._vertices]


def replicate(comm: MPI.Comm, body: BodyMesh, V: FunctionSpace, values: Floats) -> Floats:
    """`VertexValues.replicate` for once."""
    return VertexValues(comm, body, V).replicate(values)


def insert(body: BodyMesh, V: FunctionSpace, values: Floats, into: Floats) -> None:
    """`VertexValues.insert` for once."""
    VertexValues(body.mesh.comm, body, V).insert(values, into)


class VolumeTransfer:
    """Nodal interpolation of a field in a body, Φ_K = Σ N_I(X_K) Φ_I (29)-(31).

    Vertices outside of the source mesh, on curved boundaries, take the field of the nearest cell,
    continued by its gradient. Conserved are linear fields, to round-off; bounds, but at these
    vertices; not integrals, which change by the error of interpolation, of second order.

    Attributes:
        matrix: (n_target, n_source), with rows of the sum 1.
        farthest: Largest distance of a target vertex outside of the source mesh [m].
        is_identity: Whether the meshes are the same.
    """

    matrix: sp.csr_matrix
    farthest: float
    is_identity: bool = False

    def __init__(self, comm: MPI.Comm, source: BodyMesh, target: BodyMesh, name: str) -> None:
        """Build the matrix; collective, and the ranks share the search.

        A vertex on a slit of no width takes the value of its own lip. A slit that is curved has to
        be wide enough for the facets of both meshes.

        Args:
            comm: communicator.
            source: mesh that has the values.
            target: mesh of the same body that gets them.
            name: the body's name, for errors.

        Raises:
            MeshError: a vertex lies farther outside of the source mesh than half a cell, the
                larger of those around it and the nearest one of the source.
        """
        given, wanted = (everywhere(comm, body.data) for body in (source, target))
        if _equal(given.points, given.cells, wanted.points, wanted.cells):
            self.matrix, self.farthest = _identity(len(given.points)), 0.0
            self.is_identity = True
            return
        inward, size = surroundings(wanted.points, wanted.cells)
        self.matrix, distance = located(comm, given, wanted.points, inward, size, name)
        self.farthest = float(distance.max())

    def __call__(self, values: Floats) -> Floats:
        """Values at the target's vertices.

        Args:
            values: at the source's vertices, (n_source, c) or (n_source,).

        Returns:
            (n_target, c) or (n_target,).
        """
        return np.asarray(self.matrix @ values)


def located(
    comm: MPI.Comm, given: MeshData, points: Floats, inward: Floats, size: Floats, name: str
) -> tuple[sp.csr_matrix, Floats]:
    """Interpolation of a mesh at points; collective, and the ranks share the search.

    Args:
        comm: communicator.
        given: the mesh, on all ranks.
        points: where its field is wanted [m], (n, dim).
        inward: points on their side of a slit [m], (n, dim).
        size: lengths of which half is the largest distance allowed [m], (n,).
        name: the body's name, for errors.

    Returns:
        The matrix (n, n_given), and how far the points lie outside [m], (n,).

    Raises:
        MeshError: a point lies too far outside.
    """
    first, last = (len(points) * (comm.rank + k) // comm.size for k in (0, 1))
    mine = Location(given).places(points[first:last], inward[first:last])
    parts = comm.allgather((mine.cells, mine.weights, mine.distance))
    cells, weights, distance = (np.concatenate(part) for part in zip(*parts, strict=True))
    larger = np.maximum(size, cell_sizes(given.points, given.cells)[cells])
    _check_near(name, points, distance, larger)
    return block_rows(weights[:, None], given.cells[cells], len(given.points)), distance


class SurfaceTransfer:
    """Nodal values along a surface, from each target node's nearest point on the source's facets.

    In the reference configuration, without communication, and the same on all ranks. The weights
    lie in [0, 1]: bounds are conserved (p >= 0 stays so), and constants; along straight sides that
    end at the same points linear fields as well. Totals are not: see `conserved`.

    Attributes:
        matrix: (n_target, n_source) in the surfaces' own numbering, with rows of the sum 1.
        farthest: Largest distance of a target node from the source's facets [m].
    """

    matrix: sp.csr_matrix
    farthest: float

    def __init__(self, source: Surface, target: Surface, name: str) -> None:
        """Build the matrix.

        Args:
            source: surface that has the values.
            target: the same surface of another mesh of the body.
            name: the surface's name, for errors.

        Raises:
            MeshError: a node is farther from the source than half a facet, the larger of those
                around it and the nearest one of the source.
        """
        self._source, self._target = source, target
        if _equal(source.X, source.facets, target.X, target.facets):
            self.matrix, self.farthest = _identity(len(source.X)), 0.0
            return
        facets = simplices(source.facets)
        nearest, weights, distance = NearestFacets(source.X, facets).closest(target.X)
        size = surroundings(target.X, target.facets)[1]
        larger = np.maximum(size, cell_sizes(source.X, facets)[nearest])
        _check_near(name, target.X, distance, larger)
        self.matrix = block_rows(weights[:, None], facets[nearest], len(source.X))
        self.farthest = float(distance.max())

    def __call__(self, values: Floats) -> Floats:
        """Values at the target's nodes.

        Args:
            values: at the source's nodes, (n_source, c) or (n_source,).

        Returns:
            (n_target, c) or (n_target,).
        """
        return np.asarray(self.matrix @ values)

    def conserved(self, density: Floats, weights: Floats, total: float) -> tuple[Floats, float]:
        """Density at the target's nodes with a given total, Σ w_K q_K = Q to round-off.

        The interpolated density, rescaled. A loaded patch that lies between the target's nodes, so
        that interpolation sees nothing of it, loads the nodes of the facets it lies on.

        Args:
            density: q at the source's nodes, not negative, (n_source,).
            weights: w at the target's nodes, such as ∫ N_K dΓ, positive, (n_target,).
            total: Q, not negative.

        Returns:
            Density at the target's nodes (n_target,), and the defect of the interpolated one (see
            `conserving`).

        Raises:
            ValueError: there is a total but no density.
        """
        values = self(density)
        if total == 0.0 or values.any():
            return conserving(values, weights, total)
        return conserving(self.spread(density) / weights, weights, total)[0], -1.0

    def spread(self, density: Floats) -> Floats:
        """Load the target's nodes with what lies on their facets, the transpose of interpolation.

        Args:
            density: at the source's nodes, (n_source,).

        Returns:
            Sum of the densities at a target node, each by its share of the facet (n_target,).
        """
        facets = simplices(self._target.facets)
        nearest, shares, _ = NearestFacets(self._target.X, facets).closest(self._source.X)
        loads = shares * density[:, None]
        found = np.bincount(facets[nearest].ravel(), loads.ravel(), len(self._target.X))
        return found.astype(np.float64)


def conserving(values: Floats, weights: Floats, total: float) -> tuple[Floats, float]:
    """Rescale a density such that Σ w_K q_K = Q.

    Args:
        values: q, of one sign, (n,).
        weights: w, positive, (n,).
        total: Q.

    Returns:
        The density, and its defect before that: (Σ w q - Q) / max(|Σ w q|, |Q|), from -1 where all
        was missing to 1 where nothing should have been.

    Raises:
        ValueError: Q is not 0 and the density has no total, or one of the other sign.
    """
    raw = float(weights @ values)
    if raw == total:
        return values, 0.0
    if total == 0.0:
        return np.zeros_like(values), 1.0
    if raw == 0.0 or (raw > 0.0) != (total > 0.0):
        raise ValueError(f"a density with the total {raw:g} cannot be scaled to {total:g}")
    return values * (total / raw), (raw - total) / max(abs(raw), abs(total))


def everywhere(comm: MPI.Comm, data: MeshData | None) -> MeshData:
    """Points and cells of the first rank's mesh, on all ranks."""
    bare: MeshData = comm.bcast(None if data is None else replace(data, groups={}))
    return bare


def _equal(X: Floats, cells: Ints, other_X: Floats, other_cells: Ints) -> bool:
    return np.array_equal(X, other_X) and np.array_equal(cells, other_cells)


def _identity(n: int) -> sp.csr_matrix:
    return sp.identity(n, format="csr")


def _check_near(name: str, points: Floats, distance: Floats, size: Floats) -> None:
    """Raise an error if points are too far outside of the source, naming the worst one."""
    far = distance > FAR * size
    if far.any():
        worst = np.argmax(np.where(far, distance, 0.0))
        raise MeshError(
            f"'{name}' differs between its meshes: {far.sum()} of {len(points)} points of one "
            f"are not on the other, the farthest at {points[worst]} m lies {distance[worst]:.3g} m "
            f"away, with cells of {size[worst]:.3g} m there; allowed is {FAR} of a cell"
        )
