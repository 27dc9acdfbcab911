"""Mortar operators D, M of surfaces in space, with derivatives (7)-(11)."""

from dataclasses import dataclass

import numpy as np

from contactfem._kernels import lib
from contactfem.common.typing import Floats, Ints
from contactfem.mortar.facet_areas import areas, is_triangle
from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.polygon_basis import FacetBasis, facet_basis
from contactfem.mortar.polygons import MASS, N_MASS, Polygons, at_kernel
from contactfem.mortar.sparse import Sparse, Triplets

TINY_COVERAGE = 1e-14  # covered share of a facet below which it counts as uncovered (round-off)
ROOM = 4_000_000  # entries of derivatives that are made at once


@dataclass(frozen=True)
class Entries:
    """Entries of D and M; repeated ones add up. With dual functions always Σ_l M_jl = D_jj.

    Attributes:
        D: Nodes and values of D_jj = ∫ Φ_j [m²].
        M: Rows, columns and values of M_jl = ∫ Φ_j (N_l∘P) [m²]; of standard functions also, with
            the sign of mortar entries, D_jj δ_jk - ∫ Φ_j N_k of nonmortar nodes k.
    """

    D: tuple[Ints, Floats]
    M: Triplets


@dataclass(frozen=True)
class Derivatives:
    """Derivatives by the positions, columns 3 per node; the ranks' parts add up.

    Attributes:
        rows: Those of D, of the jumps and of the forces, one below the other.
        n_nonmortar: Number of nonmortar nodes.
    """

    rows: Sparse
    n_nonmortar: int

    @property
    def D(self) -> Sparse:
        """Of D_jj, (n_nonmortar, 3 n_nodes)."""
        return self.rows.part(0, self.n_nonmortar)

    @property
    def jump(self) -> Sparse:
        """Of the weighted jumps v_j = Σ_l M_jl (x_l - x_j), rows 3 per nonmortar node."""
        return self.rows.part(self.n_nonmortar, 4 * self.n_nonmortar)

    @property
    def force(self) -> Sparse:
        """Of Σ_j M_jl λ_j at fixed λ, rows 3 per node."""
        return self.rows.part(4 * self.n_nonmortar, self.rows.height)


def covered(mesh: InterfaceMesh, x: Floats, polygons: Polygons) -> Polygons:
    """The polygons of facets that more than round-off is covered of.

    Args:
        mesh: The interface.
        x: Positions that they belong to [m], shape (n_nodes, 3).
        polygons: All polygons of some nonmortar facets.
    """
    e = polygons.facets[:, 0]
    k = len(mesh.nonmortar)
    share = np.bincount(e, polygons.mixed.sum(axis=(1, 2)), k) / areas(mesh.nonmortar, x)
    return polygons.part(share[e] > TINY_COVERAGE)


def _on_facets(mesh: InterfaceMesh, polygons: Polygons) -> tuple[Ints, Ints, Floats, FacetBasis]:
    """Facets with polygons, the number of each polygon's facet, their masses, and the basis."""
    facets, e = np.unique(polygons.facets[:, 0], return_inverse=True)
    mass: Floats = np.zeros((len(facets), N_MASS))
    np.add.at(mass, e, polygons.integrals[:, :N_MASS])
    basis = facet_basis(mass[:, MASS], is_triangle(mesh.nonmortar[facets]), mesh.basis)
    return facets, e, mass[:, MASS], basis


def assemble_polygons(mesh: InterfaceMesh, polygons: Polygons) -> Entries:
    """Mortar operators of polygons, with the multiplier's basis on the covered part of each facet.

    Args:
        mesh: The interface.
        polygons: All polygons of some covered nonmortar facets.

    Returns:
        The operators' entries.
    """
    facets, e, mass, basis = _on_facets(mesh, polygons)
    nodes = mesh.nonmortar[facets]
    D = nodes.ravel(), mass.sum(axis=2).ravel()
    parts = [
        (
            mesh.nonmortar[polygons.facets[:, 0]],
            mesh.mortar[polygons.facets[:, 1]],
            basis.A[e] @ polygons.mixed,
        )
    ]
    if mesh.basis == "standard":
        own = mass.sum(axis=2)[:, :, None] * np.eye(4) - mass
        parts.append((nodes, nodes, own))
    rows, columns, values = (
        np.concatenate([part.ravel() for part in stack])
        for stack in zip(
            *(
                (
                    np.broadcast_to(a[:, :, None], v.shape),
                    np.broadcast_to(b[:, None, :], v.shape),
                    v,
                )
                for a, b, v in parts
            ),
            strict=True,
        )
    )
    at = values != 0.0  # the last place of a triangle holds nothing
    return Entries(D, (rows[at], columns[at], values[at]))


def differentiate_polygons(
    mesh: InterfaceMesh, x: Floats, polygons: Polygons, multiplier: Floats
) -> Derivatives:
    """Derivatives of what the operators are used for, contracted within the kernel.

    Args:
        mesh: The interface.
        x: Positions that the polygons belong to [m], shape (n_nodes, 3).
        polygons: All polygons of some covered nonmortar facets.
        multiplier: λ_j [Pa], shape (n_nonmortar, 3).

    Returns:
        The derivatives.
    """
    n, n_nodes = mesh.n_nonmortar, mesh.n_nodes
    number, rows = _rows(mesh, x, polygons, multiplier)
    each: Ints = np.arange(len(number))
    gather = Sparse.of_triplets(
        (number, each, np.ones(len(each))), (4 * n + 3 * n_nodes, len(each))
    )
    return Derivatives(gather @ rows, n)


def _rows(
    mesh: InterfaceMesh, x: Floats, polygons: Polygons, multiplier: Floats
) -> tuple[Ints, Sparse]:
    """Numbers and derivatives of the quantities of facets, see `cf_polygon_rows` in kernels.h."""
    facets, e, _, basis = _on_facets(mesh, polygons)
    standard = mesh.basis == "standard"
    own = np.where(is_triangle(mesh.nonmortar[facets]), 3, 4)
    first = np.searchsorted(e, np.arange(len(facets) + 1))
    others = 4 * np.diff(first)  # at most
    height = (7 if standard else 4) * own + 3 * others
    numbers: list[Ints] = [np.empty(0, np.int64)]
    parts: list[tuple[Ints, Ints, Floats]] = []
    for lo, hi in _blocks(3 * height * (own + others)):
        at = slice(first[lo], first[hi])
        number: Ints = np.empty(height[lo:hi].sum(), np.int64)
        size = (3 * height * (own + others))[lo:hi].sum()
        starts = np.empty(len(number) + 1, np.int32)
        columns, values = np.empty(size, np.int32), np.empty(size)
        count = lib.cf_polygon_rows(
            at_kernel(x), mesh.n_nonmortar, at_kernel(mesh.nonmortar), at_kernel(mesh.mortar),
            standard, at.stop - at.start, at_kernel(polygons.facets[at]),
            at_kernel(polygons.met[at]), at_kernel(polygons.integrals[at]), at_kernel(multiplier),
            at_kernel(basis.A[lo:hi]), at_kernel(basis.inverse[lo:hi]),
            at_kernel(basis.delta[lo:hi]), at_kernel(number), at_kernel(starts),
            at_kernel(columns), at_kernel(values),
        )  # fmt: skip
        used = starts[count]
        numbers.append(number[:count])
        parts.append((np.diff(starts[: count + 1]), columns[:used].copy(), values[:used].copy()))
    return np.concatenate(numbers), _stacked(parts, 3 * mesh.n_nodes)


def _blocks(room: Ints) -> list[tuple[int, int]]:
    """Ranges of facets that need at most `ROOM` entries together, or are one facet."""
    end, result, lo = np.cumsum(room), [], 0
    while lo < len(room):
        before = end[lo - 1] if lo else 0
        hi = max(lo + 1, int(np.searchsorted(end, before + ROOM, side="right")))
        result.append((lo, hi))
        lo = hi
    return result


def _stacked(parts: list[tuple[Ints, Ints, Floats]], width: int) -> Sparse:
    """One matrix of lengths of rows, columns and values of several."""
    lengths, columns, values = (
        (np.concatenate(p) for p in zip(*parts, strict=True))
        if parts
        else (np.empty(0, np.int32), np.empty(0, np.int32), np.empty(0))
    )
    starts = np.concatenate(([0], np.cumsum(lengths))).astype(np.int32)
    return Sparse(starts, columns, values, width)
