"""Steady conduction with linear triangles: discrete solutions for the tests of error estimates."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg
from scipy.spatial import Delaunay

from contactfem.adaptivity.recovery.norms import (
    quadrature,
    relative_error,
    squared_errors,
    squared_norms,
)
from contactfem.adaptivity.recovery.patches import patches
from contactfem.results.relative_error import RelativeError

GAUSS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True)
class Plate:
    """Triangles of one conductivity: points (n, 2), counter-clockwise cells (m, 3)."""

    points: np.ndarray
    cells: np.ndarray
    conductivity: float = 1.0

    def shapes(self) -> tuple[np.ndarray, np.ndarray]:
        """Gradients of the shape functions (m, 3, 2) and areas (m,)."""
        x = self.points[self.cells]
        edge = np.roll(x, -1, 1) - np.roll(x, -2, 1)  # opposite to each vertex
        double = double_areas(x)
        return np.stack((edge[..., 1], -edge[..., 0]), -1) / double[:, None, None], double / 2

    def flux(self, temperature: np.ndarray) -> np.ndarray:
        """-k grad T in the cells, (m, 2)."""
        slopes = np.einsum("eai,ea->ei", self.shapes()[0], temperature[self.cells])
        return -self.conductivity * slopes

    def stiffness(self) -> sp.csr_matrix:
        """∫ k grad N_i · grad N_j."""
        slopes, area = self.shapes()
        local = self.conductivity * area[:, None, None] * slopes @ slopes.transpose(0, 2, 1)
        rows, cols = self.cells.repeat(3, 1).ravel(), np.tile(self.cells, (1, 3)).ravel()
        n = len(self.points)
        return sp.coo_matrix((local.ravel(), (rows, cols)), (n, n)).tocsr()

    def at_edge(self, axis: int, value: float) -> np.ndarray:
        """Vertices with this coordinate, along the edge."""
        found = np.flatnonzero(np.abs(self.points[:, axis] - value) < 1e-12)
        return found[np.argsort(self.points[found, 1 - axis])]


def double_areas(x: np.ndarray) -> np.ndarray:
    """Twice the signed areas of triangles with corners x (m, 3, 2)."""
    a, b = x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def jittered(
    counts: tuple[int, int],
    corner: tuple[float, float] = (0.0, 0.0),
    size: tuple[float, float] = (1.0, 1.0),
    conductivity: float = 1.0,
    jitter: float = 0.2,
    seed: int = 0,
) -> Plate:
    """Delaunay triangles of a rectangle: staggered rows of vertices, each moved at random."""
    rng = np.random.default_rng(seed)
    nx, ny = counts
    rows = []
    for j in range(ny + 1):
        u = np.concatenate(([0.0], np.arange(1.0 if j % 2 == 0 else 0.5, nx), [nx])) / nx
        v = np.full(len(u), j / ny)
        u[1:-1] += jitter * rng.uniform(-1, 1, len(u) - 2) / nx
        v += (0 < j < ny) * jitter * rng.uniform(-1, 1, len(u)) / ny
        rows.append(np.column_stack((u, v)))
    unit = np.vstack(rows) * size
    cells = Delaunay(unit).simplices.astype(np.int64)
    double = double_areas(unit[cells])
    cells[double < 0] = cells[double < 0][:, ::-1]
    return Plate(unit + corner, cells[np.abs(double) > 1e-9 / (nx * ny)], conductivity)


def solve(
    matrix: sp.csr_matrix, load: np.ndarray, held: np.ndarray, values: np.ndarray
) -> np.ndarray:
    """Temperatures with prescribed ones at the vertices `held`."""
    result = np.zeros(len(load))
    result[held] = values
    free = np.setdiff1d(np.arange(len(load)), held)
    rest = (load - matrix @ result)[free]
    result[free] = scipy.sparse.linalg.spsolve(matrix[free][:, free].tocsc(), rest)
    return result


@dataclass(frozen=True)
class Estimated:
    """Squares of the estimated errors of cells, the relative error, and the true one."""

    errors: np.ndarray
    estimate: RelativeError
    true: RelativeError


def estimated(
    plate: Plate,
    outside: np.ndarray,
    temperature: Callable[[np.ndarray], np.ndarray],
    gradient: Callable[[np.ndarray], np.ndarray],
    source: Callable[[np.ndarray], np.ndarray],
) -> Estimated:
    """Solve for an exact temperature, held at the vertices outside, and estimate the error."""
    rule = quadrature(plate.points, plate.cells)
    load = np.zeros(len(plate.points))
    np.add.at(load, plate.cells, (rule.weights * source(rule.x)) @ rule.shapes)
    T = solve(plate.stiffness(), load, outside, temperature(plate.points[outside]))
    samples = plate.flux(T)
    nodal = patches(plate.points, plate.cells).fit(samples)[:, 0]
    errors = squared_errors(rule, plate.cells, nodal, samples)
    norms = squared_norms(rule, samples)
    true = squared_norms(rule, -gradient(rule.x) - samples[:, None, :])
    return Estimated(errors, relative_error(errors, norms), relative_error(true, norms))


@dataclass(frozen=True)
class Joint:
    """Plates below and above y = 0 on (0, 1), with a conductance and a source d(x) between them."""

    lower: Plate
    upper: Plate
    conductance: float
    source: Callable[[np.ndarray], np.ndarray]

    def solve(self, exact: Callable[[int, np.ndarray, np.ndarray], np.ndarray]) -> list[np.ndarray]:
        """Temperatures of both, equal to exact(body, x, y) on all edges but y = 0.

        ∫ h (T_1 - T_2)(v_1 - v_2) = ∫ d (v_1 + v_2)/2 over the pieces between all vertices.
        """
        plates = (self.lower, self.upper)
        starts = (0, len(self.lower.points))
        edges = [plate.at_edge(1, 0.0) for plate in plates]
        x = [plate.points[edge, 0] for plate, edge in zip(plates, edges, strict=True)]
        cuts = np.unique(np.concatenate(x).round(13))
        half = np.diff(cuts)[:, None] / 2
        s = ((cuts[:-1, None] + cuts[1:, None]) / 2 + half * GAUSS[0]).ravel()
        w = (half * GAUSS[1]).ravel()
        matrix = sp.block_diag([plate.stiffness() for plate in plates]).tocsr()
        trace = []
        for k in (0, 1):
            hats = np.column_stack([np.interp(s, x[k], hat) for hat in np.eye(len(x[k]))])
            place = sp.csr_matrix(
                (np.ones(len(x[k])), (np.arange(len(x[k])), edges[k] + starts[k])),
                (len(x[k]), matrix.shape[0]),
            )
            trace.append(sp.csr_matrix(hats) @ place)
        jump = trace[0] - trace[1]
        matrix = matrix + jump.T @ sp.diags(self.conductance * w) @ jump
        load = (trace[0] + trace[1]).T @ (w * self.source(s) / 2)
        held, values = [], []
        for k, plate in enumerate(plates):
            sides = [(0, 0.0), (0, 1.0), (1, -1.0 if k == 0 else 1.0)]
            outside = np.unique(np.concatenate([plate.at_edge(*side) for side in sides]))
            held.append(outside + starts[k])
            values.append(exact(k, *plate.points[outside].T))
        both = solve(matrix.tocsr(), load, np.concatenate(held), np.concatenate(values))
        return np.split(both, [starts[1]])
