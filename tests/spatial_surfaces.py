"""Facets in space to test with: pairs that overlap at random, and grids."""

import numpy as np
import scipy.sparse as sp

from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.polygon_operators import assemble_polygons, covered
from contactfem.mortar.polygons import find_facet_pairs, intersect


def facet(rng, kind, flip, height, shift=(0.0, 0.0)):
    """Positions of the nodes of a facet of 3 or 4 nodes that is neither regular nor flat."""
    plan = [[0, 0], [1, 0], [1, 1], [0, 1]] if kind == 4 else [[0, 0], [1, 0], [0.3, 1]]
    plan = np.array(plan, float) + rng.uniform(-0.15, 0.15, (kind, 2)) + shift
    heights = height + rng.uniform(-0.1, 0.1, kind)
    return np.column_stack((plan[::-1] if flip else plan, heights))


def quadruple(first, kind):
    return first + np.minimum(np.arange(4), kind - 1)


def one_over_three(rng, own, other, basis="dual"):
    """One nonmortar facet below three mortar ones that each cover a part of it."""
    shifts = ((0.45, 0.35), (-0.75, 0.3), (0.2, -0.85))
    parts = [facet(rng, own, False, 0.0)]
    parts += [facet(rng, other, True, 0.05, shift) for shift in shifts]
    mortar = np.array([quadruple(own + i * other, other) for i in range(3)])
    return mesh_of(own, quadruple(0, own)[None], mortar, np.vstack(parts), basis)


def mesh_of(n, nonmortar, mortar, X, basis="dual", free=None):
    free = np.ones(X.shape, bool) if free is None else free
    return InterfaceMesh(n, np.asarray(nonmortar), np.asarray(mortar), X, free, basis)


def grid(n, kind, height=0.0, flip=False, turn=0.0, size=1.0, seed=0, jitter=0.2):
    """A square of n x n cells around the origin: quadrilaterals, or each as two triangles."""
    rng = np.random.default_rng(seed)
    line = np.linspace(-size / 2, size / 2, n + 1)
    X = np.stack(np.meshgrid(line, line, indexing="ij"), -1).reshape(-1, 2)
    inner = (np.abs(X) < size / 2 - 1e-9).all(1)
    X[inner] += rng.uniform(-jitter, jitter, (inner.sum(), 2)) * size / n
    X = X @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    a = (i * (n + 1) + j).ravel()
    facets = np.stack([a, a + n + 1, a + n + 2, a + 1], 1)
    if kind == 3:
        facets = np.vstack((facets[:, [0, 1, 2, 2]], facets[:, [0, 2, 3, 3]]))
    if flip:
        facets = facets[:, ::-1] if kind == 4 else facets[:, [2, 1, 0, 0]]
    return np.column_stack((X, np.full(len(X), height))), np.ascontiguousarray(facets)


def two_grids(na, ka, nb, kb, turn=0.3, size=1.5, height=0.0, basis="dual"):
    """A square below a mortar one that is turned."""
    A, own = grid(na, ka)
    B, other = grid(nb, kb, height, True, turn, size, 1)
    return mesh_of(len(A), own, other + len(A), np.vstack((A, B)), basis)


def polygons_of(mesh, x, radius=3.0):
    chosen = np.arange(len(mesh.nonmortar))
    return covered(mesh, x, intersect(mesh, x, find_facet_pairs(mesh, x, chosen, radius)))


def operators_of(mesh, polygons):
    """D and M without what nodes that have no multiplier make of them."""
    entries = assemble_polygons(mesh, polygons)
    nodes, values = entries.D
    rows, columns, shares = entries.M
    M = sp.csr_matrix((shares, (rows, columns)), (mesh.n_nonmortar, mesh.n_nodes))
    return np.bincount(nodes, values, mesh.n_nonmortar), M


def neighbours(facets, n):
    """What an `InterfaceMesh` says of one surface alone."""
    return mesh_of(n, facets, np.empty((0, 4), np.int64), np.zeros((n, 3))).neighbours
