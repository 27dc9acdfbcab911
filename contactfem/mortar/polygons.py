"""Polygons: what facets of two surfaces in space share, with integrals."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contactfem._kernels import ffi, lib
from contactfem.common.typing import Bools, Floats, Ints
from contactfem.mortar.interface_mesh import InterfaceMesh

N_MASS = 10
# Where ∫ N_j N_k of a facet stands among the integrals
MASS: Ints = np.array([[0, 1, 2, 3], [1, 4, 5, 6], [2, 5, 7, 8], [3, 6, 8, 9]])


@dataclass(frozen=True)
class Polygons:
    """What pairs of facets share, and the integrals over it (layout in kernels.h).

    Attributes:
        facets: Nonmortar and mortar facet of each pair, ordered by nonmortar facet, (s, 2).
        met: Which of their triangles share something, as bits, (s,).
        integrals: ∫ N_j N_k of the nonmortar nodes j <= k, ∫ N_j N_l with the mortar nodes l [m²],
            (s, 26).
    """

    facets: Ints
    met: NDArray[np.int32]
    integrals: Floats

    @property
    def mixed(self) -> Floats:
        """∫ N_j N_l of nonmortar nodes j and mortar nodes l [m²], (s, 4, 4)."""
        return self.integrals[:, N_MASS:].reshape(-1, 4, 4)

    def part(self, chosen: Bools) -> "Polygons":
        """Some of the pairs: all of a nonmortar facet's or none.

        Args:
            chosen: Which, (s,).
        """
        return Polygons(self.facets[chosen], self.met[chosen], self.integrals[chosen])


def find_facet_pairs(mesh: InterfaceMesh, x: Floats, chosen: Ints, radius: float) -> Ints:
    """Candidate pairs of facets in space: facing each other and nearer than the search radius.

    Args:
        mesh: The interface.
        x: Current positions [m], shape (n_nodes, 3).
        chosen: Nonmortar facets to search for, ascending, shape (k,).
        radius: Search radius [m].

    Returns:
        Pairs (nonmortar facet, mortar facet) ordered by both, shape (p, 2).

    Raises:
        ValueError: The radius is not positive.
    """
    nonmortar = np.ascontiguousarray(mesh.nonmortar[chosen])
    capacity = 16 * (len(nonmortar) + len(mesh.mortar)) + 64
    while True:
        pairs: Ints = np.empty((capacity, 2), np.int64)
        count = lib.cf_polygon_pairs(
            at_kernel(x), len(nonmortar), at_kernel(nonmortar), len(mesh.mortar),
            at_kernel(mesh.mortar), radius, capacity, at_kernel(pairs),
        )  # fmt: skip
        if count < 0:
            raise ValueError(f"search radius {radius:g} m: must be positive")
        if count <= capacity:
            break
        capacity = count
    pairs = pairs[:count]
    pairs[:, 0] = chosen[pairs[:, 0]]
    return pairs


def intersect(mesh: InterfaceMesh, x: Floats, pairs: Ints) -> Polygons:
    """What candidate pairs share; where several mortar facets cover one place, the nearest counts.

    Args:
        mesh: The interface.
        x: Current positions [m], shape (n_nodes, 3).
        pairs: All candidates of some nonmortar facets, ordered by these, shape (p, 2).

    Returns:
        The pairs that share something.
    """
    pairs = np.ascontiguousarray(pairs)
    integrals, met = np.empty((len(pairs), 26)), np.empty(len(pairs), np.int32)
    lib.cf_polygons(
        at_kernel(x), at_kernel(mesh.nonmortar), at_kernel(mesh.mortar), len(pairs),
        at_kernel(pairs), at_kernel(integrals), at_kernel(met),
    )  # fmt: skip
    return Polygons(pairs, met, integrals).part(met != 0)


def at_kernel(array: NDArray[np.generic]) -> object:
    """An array for a kernel; it is contiguous, or only read."""
    kind = {"f8": "double[]", "i8": "int64_t[]", "i4": "int32_t[]"}[array.dtype.str[1:]]
    return ffi.from_buffer(kind, np.ascontiguousarray(array))
