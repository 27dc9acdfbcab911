"""Both surfaces of an interface as arrays."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
import scipy.sparse as sp

from contactfem.common.typing import Bools, Floats, Ints
from contactfem.mortar.multiplier_extension import extension
from contactfem.mortar.sparse import Sparse, joined
from contactfem.mortar.spatial_normals import averaged_normals as spatial_normals

Basis = Literal["dual", "standard"]


@dataclass(frozen=True)
class InterfaceMesh:
    """Both surfaces numbered together, nonmortar nodes first; the same on all ranks.

    In the plane a facet (a, b) has its body on the left, so its outward normal is (dy, -dx) of
    b - a. In space facets are quadruples of nodes, counter-clockwise seen from outside, and a
    triangle (a, b, c, c) has its last node twice.

    Attributes:
        n_nonmortar: Number of nonmortar nodes; they are nodes 0 .. n_nonmortar - 1.
        nonmortar: Nonmortar facets, shape (k, 2) or (k, 4).
        mortar: Mortar facets, likewise.
        X: Reference coordinates of all nodes [m], shape (n, dim).
        free: Components of each node that contact may move, shape (n, dim).
        basis: Functions that the multiplier is made of: dual ones (9), or the shape functions (7).
        axisymmetric: Whether integrals over the interface run around the axis x = 0, with the
            weight 2πx [m]: its forces are then those of the whole circumference, and integrals are
            in [m²] where "[m]" is said.
        directions: Unit normals of the nonmortar nodes and their derivatives, each with respect to
            the node's own position, where a rigid mortar side gives them; None for averaged ones.
        shared: Nonmortar nodes that are on another surface of an interface too, shape (n,); None
            for none.
        fold: Where corners are cut, node of the whole interface that each node is, shape (n,).
    """

    n_nonmortar: int
    nonmortar: Ints
    mortar: Ints
    X: Floats
    free: Bools
    basis: Basis = "dual"
    axisymmetric: bool = False
    directions: "Directions | None" = None
    shared: Bools | None = None
    fold: Ints | None = None

    @property
    def dim(self) -> int:
        """Dimension of space: 2 in the plane, around an axis as well."""
        return int(self.X.shape[1])

    @property
    def n_nodes(self) -> int:
        """Number of nodes on both surfaces."""
        return len(self.X)

    @cached_property
    def has_multiplier(self) -> Bools:
        """Nonmortar nodes with a multiplier: those that can move along their normal, (n,)."""
        free = self.free[: self.n_nonmortar]
        if self.dim == 3:
            n = spatial_normals(self.nonmortar, self.X, np.ones_like(free), self.neighbours)[0]
        else:
            n = averaged_normals(self, self.X)[0]
        moves = free.all(1) | (free & (np.abs(n) > 0.5)).any(1)
        return np.asarray(moves if self.shared is None else moves & ~self.shared)

    @cached_property
    def neighbours(self) -> Ints:
        """Nonmortar nodes that an edge of a facet joins with each, -1 beyond the last, (n, most).

        In the plane the previous node comes before the next.
        """
        pairs = _edges(self.nonmortar)
        pairs = np.concatenate((pairs[:, ::-1], pairs))
        _, first = np.unique(pairs, axis=0, return_index=True)
        own, other = pairs[np.sort(first)].T
        order = np.argsort(own, kind="stable")
        own, other = own[order], other[order]
        count = np.bincount(own, minlength=self.n_nonmortar)
        place = np.arange(len(own)) - np.repeat(np.cumsum(count) - count, count)
        result = np.full((self.n_nonmortar, int(count.max(initial=1))), -1, np.int64)
        result[own, place] = other
        return result

    @cached_property
    def extension(self) -> sp.csr_matrix:
        """Multipliers of all nonmortar nodes from those that there are, see `extension`, (n, n)."""
        return extension(self.neighbours, self.has_multiplier)


def half_lengths(mesh: InterfaceMesh, x: Floats) -> Floats:
    """Half the length of the facets at each nonmortar node, without the weight of an axis.

    Args:
        mesh: The interface.
        x: Current positions [m], shape (n_nodes, 2).

    Returns:
        Lengths [m], shape (n_nonmortar,).
    """
    edge = x[mesh.nonmortar[:, 1]] - x[mesh.nonmortar[:, 0]]
    half = np.repeat(0.5 * np.hypot(edge[:, 0], edge[:, 1]), 2)
    return np.bincount(mesh.nonmortar.ravel(), half, mesh.n_nonmortar).astype(np.float64)


def full_lengths(mesh: InterfaceMesh, x: Floats) -> Floats:
    """The lengths of `facet_lengths` alone.

    Args:
        mesh: The interface.
        x: Current positions [m], shape (n_nodes, 2).

    Returns:
        Lengths [m], shape (n_nonmortar,).
    """
    _, size, share = _shares(mesh, x)
    half = (size[:, None] * share).ravel()
    return np.bincount(mesh.nonmortar.ravel(), half, mesh.n_nonmortar).astype(np.float64)


def _shares(mesh: InterfaceMesh, x: Floats) -> tuple[Floats, Floats, Floats]:
    """Edge and length of each facet, and the share of it that each end gets."""
    ends = mesh.nonmortar
    edge = x[ends[:, 1]] - x[ends[:, 0]]
    weight = 2.0 * np.pi * x[ends, 0] if mesh.axisymmetric else np.ones(ends.shape)
    return edge, np.hypot(edge[:, 0], edge[:, 1]), (2.0 * weight + weight[:, ::-1]) / 6.0


def facet_lengths(mesh: InterfaceMesh, x: Floats) -> tuple[Floats, Sparse]:
    """∫ N_j over the facets at each nonmortar node, half their length, with derivative.

    On a facet it is L (2 d_j + d_k) / 6 with the weights d of its ends: 1, or 2πx around an axis.

    Args:
        mesh: The interface.
        x: Current positions [m], shape (n_nodes, 2).

    Returns:
        Lengths [m], shape (n_nonmortar,), and their derivative [-], (n_nonmortar, 2 n_nodes).
    """
    ends = mesh.nonmortar
    edge, size, share = _shares(mesh, x)
    t = edge / size[:, None]
    slope = 2.0 * np.pi if mesh.axisymmetric else 0.0
    entries = []
    for j in (0, 1):
        for k, sign in ((0, -1.0), (1, 1.0)):
            value = sign * share[:, j, None] * t
            value[:, 0] += size * slope * (2.0 if k == j else 1.0) / 6.0
            columns = 2 * ends[:, k, None] + np.arange(2)
            entries.append((np.repeat(ends[:, j], 2), columns.ravel(), value.ravel()))
    shape = (mesh.n_nonmortar, 2 * mesh.n_nodes)
    return full_lengths(mesh, x), Sparse.of_triplets(joined(entries), shape)


def _edges(facets: Ints) -> Ints:
    """Edges of facets, pairs of nodes (e, 2).

    A facet of two nodes is one; of others each node and the next make one, if they differ.
    """
    if facets.shape[1] == 2:
        return facets
    pairs = np.stack((facets, np.roll(facets, -1, axis=1)), axis=2).reshape(-1, 2)
    return np.asarray(pairs[pairs[:, 0] != pairs[:, 1]])


Directions = Callable[[InterfaceMesh, Floats], tuple[Floats, Floats]]


def averaged_normals(mesh: InterfaceMesh, x: Floats) -> tuple[Floats, Floats]:
    """Averaged unit normals of the nonmortar nodes and the length of the sums they come from.

    Args:
        mesh: The interface.
        x: Current positions [m], shape (n_nodes, 2).

    Returns:
        Normals [-], shape (n_nonmortar, 2), and lengths [-], (n_nonmortar,).
    """
    edge = x[mesh.nonmortar[:, 1]] - x[mesh.nonmortar[:, 0]]
    edge = edge / np.hypot(edge[:, 0], edge[:, 1])[:, None]
    total = np.zeros((mesh.n_nonmortar, 2))
    for j in (0, 1):
        np.add.at(total, mesh.nonmortar[:, j], np.column_stack((edge[:, 1], -edge[:, 0])))
    length = np.hypot(total[:, 0], total[:, 1])
    return total / length[:, None], length
