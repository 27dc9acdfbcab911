"""Surfaces in the plane cut at corners into smooth chains."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from contactfem.common.typing import Bools, Floats, Ints
from contactfem.mortar.interface_mesh import InterfaceMesh, averaged_normals
from contactfem.mortar.normals import NormalField
from contactfem.mortar.operators import Mortar
from contactfem.mortar.search_range import SearchRange
from contactfem.mortar.segments import Segments, find_segments
from contactfem.mortar.sparse import Sparse

FEATURE_COSINE = float(np.cos(np.radians(30.0)))  # of the turn beyond which a node is a corner
NEARER = 0.01  # share of a facet by which one chain at a corner must be nearer than the other


@dataclass(frozen=True)
class CutMesh(InterfaceMesh):
    """An interface with some corners cut: a second node stands there for one of two facets.

    A corner itself belongs to the facet that faces the mortar side; the second node, without a
    multiplier, ends the other one. So each facet has its own normal there, and the multiplier of
    the corner acts along one of them.

    Attributes:
        carries: Nonmortar nodes with a multiplier, (n_nonmortar,).
    """

    carries: Bools | None = None

    @cached_property
    def has_multiplier(self) -> Bools:
        """As of every `InterfaceMesh`, and not the second nodes."""
        assert self.carries is not None
        return self.carries


def folded(fold: Ints, matrix: Sparse, height: int, width: int) -> Sparse:
    """A matrix by the positions of a cut mesh as one by those of the whole one.

    Args:
        fold: Node of the whole mesh that each node of the cut one is, (n,).
        matrix: The matrix, its columns two per node.
        height: Rows to keep, the first ones.
        width: Number of nodes of the whole mesh.
    """
    rows, columns, values = matrix.part(0, height).triplets()
    columns = 2 * fold[columns // 2] + columns % 2
    return Sparse.of_triplets((rows, columns, values), (height, 2 * width))


def folded_entries(surface: InterfaceMesh, mesh: InterfaceMesh, cut: Mortar) -> Mortar:
    """Entries of a cut mesh as those of the whole one.

    Args:
        surface: The cut mesh; the whole one itself where nothing is cut.
        mesh: The whole mesh.
        cut: Entries of the first.
    """
    fold = surface.fold
    if fold is None:
        return cut
    col, by = np.where(cut.col >= 0, fold[cut.col], cut.col), cut.derivative
    derivative = None if by is None else folded(fold, by, by.height, mesh.n_nodes)
    return Mortar(cut.row, col, cut.value, derivative)


def folded_normals(surface: InterfaceMesh, mesh: InterfaceMesh, cut: NormalField) -> NormalField:
    """The normal field of a cut mesh as that of the whole one; arguments as above."""
    if surface.fold is None:
        return cut
    n = mesh.n_nonmortar
    return NormalField(cut.n[:n], surface.fold[cut.around[:n]], cut.blocks[:n], mesh.n_nodes)


def corners(mesh: InterfaceMesh) -> Ints:
    """Nodes where two facets of the nonmortar surface turn by more than 30°, by their positions X.

    Args:
        mesh: The interface.

    Returns:
        Node, facet that ends there and facet that starts there, (c, 3).
    """
    if mesh.dim != 2 or mesh.directions is not None:
        return np.empty((0, 3), np.int64)
    a, b = mesh.nonmortar.T
    edge = mesh.X[b] - mesh.X[a]
    edge = edge / np.hypot(edge[:, 0], edge[:, 1])[:, None]
    before: Ints = np.full(mesh.n_nonmortar, -1, np.int64)
    before[b] = np.arange(len(b))
    after = np.arange(len(a))
    at = before[a] >= 0
    node, first, second = a[at], before[a[at]], after[at]
    turn = np.einsum("ci,ci->c", edge[first], edge[second])
    found = np.column_stack((node, first, second))
    return np.asarray(found[turn < FEATURE_COSINE - 1e-9])


def cut_at_corners(mesh: InterfaceMesh, x: Floats, reach: SearchRange) -> InterfaceMesh:
    """Cuts those corners where one chain, seen along its own normal, is nearest to the mortar side.

    Where neither chain is opposite to it, or both are as near, a corner keeps the mean normal: so
    it meets what it points to.

    Args:
        mesh: The interface.
        x: Positions [m], (n_nodes, 2).
        reach: How far the sides look for each other.

    Returns:
        The cut interface; the given one where nothing is cut.
    """
    found = corners(mesh)
    if not len(found):
        return mesh
    trial = _cut(mesh, found)
    assert trial.fold is not None
    normals = averaged_normals(trial, x[trial.fold])[0]
    chosen = np.unique(found[:, 1:])
    segments = find_segments(trial, x[trial.fold], normals, chosen, reach)
    gap = np.column_stack([_nearness(mesh, segments, found[:, 1 + k], 1 - k) for k in (0, 1)])
    size = np.hypot(*(mesh.X[mesh.nonmortar[:, 1]] - mesh.X[mesh.nonmortar[:, 0]]).T)
    gap[~_moves(mesh, found, normals)] = np.inf
    margin = NEARER * size[found[:, 1:]].min(axis=1)
    best = gap.argmin(axis=1)
    own, other = np.take_along_axis(gap, np.column_stack((best, 1 - best)), 1).T
    with np.errstate(invalid="ignore"):
        single = np.isfinite(own) & ((other - own) > margin)
    if not single.any():
        return mesh
    kept = np.where(best[:, None] == 0, found[:, (0, 1, 2)], found[:, (0, 2, 1)])
    return _cut(mesh, kept[single])


def _cut(mesh: InterfaceMesh, at: Ints) -> CutMesh:
    """Cuts at nodes (node, facet that keeps it, facet that gets the second node), (c, 3)."""
    n, c = mesh.n_nonmortar, len(at)
    fold = np.concatenate((np.arange(n), at[:, 0], np.arange(n, mesh.n_nodes)))
    facets = mesh.nonmortar.copy()
    starts = facets[at[:, 2], 0] == at[:, 0]  # else the facet ends there
    facets[at[:, 2], np.where(starts, 0, 1)] = n + np.arange(c)
    return CutMesh(
        n_nonmortar=n + c,
        nonmortar=facets,
        mortar=mesh.mortar + c,
        X=mesh.X[fold],
        free=mesh.free[fold],
        basis=mesh.basis,
        axisymmetric=mesh.axisymmetric,
        fold=fold,
        carries=np.concatenate((mesh.has_multiplier, np.zeros(c, bool))),
    )


def _moves(mesh: InterfaceMesh, found: Ints, normals: Floats) -> Bools:
    """Whether corners can move along the normals of their chains, (c, 2)."""
    free = mesh.free[found[:, 0]]
    second = mesh.n_nonmortar + np.arange(len(found))
    n = np.stack((normals[found[:, 0]], normals[second]), axis=1)
    along = np.any(free[:, None, :] & (np.abs(n) > 0.5), axis=2)
    return np.asarray(np.logical_or(np.all(free, axis=1, keepdims=True), along))


def _nearness(mesh: InterfaceMesh, segments: Segments, facets: Ints, end: int) -> Floats:
    """Mean gap of facets around one of their ends, infinite where nothing is opposite, (c,)."""
    m, k = segments.integrals, len(mesh.nonmortar)
    weight = m[:, (0, 1)].sum(1) if end == 0 else m[:, (1, 2)].sum(1)
    area = np.bincount(segments.facets[:, 0], weight, k)[facets]
    gap = np.bincount(segments.facets[:, 0], m[:, 5 + end], k)[facets]
    return np.asarray(np.divide(gap, area, out=np.full(len(facets), np.inf), where=area > 0.0))
