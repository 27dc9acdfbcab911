"""Segments: pieces of two surfaces that face each other (1.4)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contactfem._kernels import ffi, lib
from contactfem.common.typing import Bools, Floats, Ints
from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.normals import NormalField
from contactfem.mortar.search_range import SearchRange
from contactfem.mortar.sparse import Sparse

OVERLAP = 1e-9  # facet coordinate by which segments of one facet may overlap


@dataclass(frozen=True)
class Segments:
    """Segments of some nonmortar facets and the integrals over them (layout in kernels.h).

    Attributes:
        facets: Nonmortar and mortar facet of each segment, shape (s, 2).
        span: Interval of the nonmortar facet coordinate ξ in [-1, 1], shape (s, 2).
        integrals: ∫ N1N1, N1N2, N2N2 [m], N1ζ, N2ζ [m], N1g, N2g [m²], shape (s, 7); around an axis
            all of them times a length.
        derivatives: Of the integrals with respect to the positions of a, b, the normals at a, b and
            the positions of c, d, shape (s, 7, 12); None where not asked for.
    """

    facets: Ints
    span: Floats
    integrals: Floats
    derivatives: Floats | None


def find_segments(
    mesh: InterfaceMesh, x: Floats, normals: Floats, chosen: Ints, reach: SearchRange
) -> Segments:
    """Segments of some nonmortar facets: search, cut, and drop what is deeper than may be.

    Args:
        mesh: The interface.
        x: Current positions [m], shape (n_nodes, 2).
        normals: Nodal normals [-], shape (n_nonmortar, 2).
        chosen: Nonmortar facets, shape (k,).
        reach: How far to look.

    Returns:
        The segments, without derivatives.
    """
    pairs = find_pairs(mesh, x, normals, chosen, reach)
    return cut(mesh, x, normals, pairs, differentiate=False, behind=reach.behind)


def find_pairs(
    mesh: InterfaceMesh, x: Floats, normals: Floats, chosen: Ints, reach: SearchRange | float
) -> Ints:
    """Candidate facet pairs: facing each other and not further apart than the search reaches.

    Args:
        mesh: The interface.
        x: Current positions [m], shape (n_nodes, 2).
        normals: Nodal normals [-], shape (n_nonmortar, 2).
        chosen: Nonmortar facets to search for, shape (k,).
        reach: How far along the normals, or one radius for both directions [m].

    Returns:
        Pairs (nonmortar facet, mortar facet) ordered by both, shape (p, 2).

    Raises:
        ValueError: The radius is not positive.
    """
    if not isinstance(reach, SearchRange):
        reach = SearchRange.within(reach, len(mesh.nonmortar))
    reach = reach.limited(x)
    nonmortar = np.ascontiguousarray(mesh.nonmortar[chosen])
    capacity = 4 * len(nonmortar) + 4 * len(mesh.mortar) + 16
    while True:
        pairs: Ints = np.empty((capacity, 2), np.int64)
        count = lib.cf_pairs(
            _read(x), _read(normals), len(nonmortar), _read_int(nonmortar), len(mesh.mortar),
            _read_int(mesh.mortar), reach.ahead, _read(reach.behind[chosen]), capacity,
            _write_int(pairs),
        )  # fmt: skip
        if count < 0:
            raise ValueError(f"search radius {reach.ahead:g} m: must be positive")
        if count <= capacity:
            break
        capacity = count
    pairs = pairs[:count]
    pairs[:, 0] = chosen[pairs[:, 0]]
    return pairs


def cut(
    mesh: InterfaceMesh,
    x: Floats,
    normals: Floats,
    pairs: Ints,
    differentiate: bool,
    behind: Floats | None = None,
) -> Segments:
    """Segments of candidate pairs; where several mortar facets cover one place, the nearest stands.

    Args:
        mesh: The interface.
        x: Current positions [m], shape (n_nodes, 2).
        normals: Nodal normals [-], shape (n_nonmortar, 2).
        pairs: Candidates, shape (p, 2).
        differentiate: Whether the derivatives of the integrals are wanted.
        behind: Largest overlap of every nonmortar facet [m], (k,); None for any.

    Returns:
        The segments that are not empty.
    """
    span, integrals, distance = _integrals(mesh, x, normals, pairs, None)
    keep = span[:, 1] > span[:, 0]
    if behind is not None:
        weight = integrals[:, :3] @ (1.0, 2.0, 1.0)
        gap = integrals[:, 5:].sum(1)
        keep &= gap >= -behind[pairs[:, 0]] * weight
    keep[hidden(pairs[:, 0], span, distance, keep)] = False
    found = Segments(pairs[keep], span[keep], integrals[keep], None)
    if not differentiate:
        return found
    return differentiated(mesh, x, normals, found, np.ones(len(found.facets), bool))


def differentiated(
    mesh: InterfaceMesh, x: Floats, normals: Floats, segments: Segments, chosen: Bools
) -> Segments:
    """Some segments with derivatives of their integrals: they cost far more than these.

    Args:
        mesh: The interface.
        x: Positions that they were cut at [m], shape (n_nodes, 2).
        normals: Nodal normals there [-], shape (n_nonmortar, 2).
        segments: Segments.
        chosen: Which of them, (s,).

    Returns:
        The chosen segments.
    """
    facets = segments.facets[chosen]
    derivatives = np.empty((len(facets), 7, 12))
    _integrals(mesh, x, normals, facets, derivatives)
    return Segments(facets, segments.span[chosen], segments.integrals[chosen], derivatives)


def _integrals(
    mesh: InterfaceMesh, x: Floats, normals: Floats, pairs: Ints, derivatives: Floats | None
) -> tuple[Floats, Floats, Floats]:
    """Interval, integrals and mean distance of every pair; fills derivatives where given."""
    p = len(pairs)
    span, integrals, distance = np.empty((p, 2)), np.empty((p, 7)), np.empty(p)
    lib.cf_segments(
        _read(x), _read(normals), _read_int(mesh.nonmortar), _read_int(mesh.mortar),
        mesh.axisymmetric, p, _read_int(pairs), _write(span), _write(integrals), _write(distance),
        ffi.NULL if derivatives is None else _write(derivatives),
    )  # fmt: skip
    return span, integrals, distance


def entries(
    mesh: InterfaceMesh,
    segments: Segments,
    normals: NormalField,
    on_facets: tuple[Ints, Bools, Floats, Floats | None],
) -> tuple[Ints, Ints, Floats, Sparse | None]:
    """Entries of mortar operators, see `cf_entries` in kernels.h.

    Args:
        mesh: The interface.
        segments: All segments of some nonmortar facets.
        normals: Normal field that they were cut with.
        on_facets: Number of each segment's facet, (s,); whether facets are covered, (f,); their
            basis A, (f, 2, 2), and its derivative, (f, 2, 2, 3).

    Returns:
        Rows, columns, values, and derivatives by positions where the segments have them.
    """
    (e, covered, A, dA), room = on_facets, 12 * len(segments.facets)
    rows, columns, values = np.empty(room, np.int64), np.empty(room, np.int64), np.empty(room)
    by = segments.derivatives is not None
    segment, by_integrals, by_masses = (
        np.empty(room, np.int64),
        np.empty(7 * room),
        np.empty(3 * room),
    )
    count = lib.cf_entries(
        _read_int(mesh.nonmortar), _read_int(mesh.mortar), _read_flags(mesh.has_multiplier),
        mesh.basis == "standard", len(e), _read_int(segments.facets), _read(segments.integrals),
        _read_int(e), _read_flags(covered), _read(A), ffi.NULL if dA is None else _read(dA),
        _write_int(rows), _write_int(columns), _write(values),
        _write_int(segment) if by else ffi.NULL, _write(by_integrals), _write(by_masses),
    )  # fmt: skip
    derivative = None
    if by:
        derivative = _entry_rows(mesh, segments, normals, segment[:count], by_integrals, by_masses)
    return rows[:count], columns[:count], values[:count], derivative


def _entry_rows(
    mesh: InterfaceMesh,
    segments: Segments,
    normals: NormalField,
    segment: Ints,
    by_integrals: Floats,
    by_masses: Floats,
) -> Sparse:
    """Derivatives of entries by positions, (e, 2 n_nodes); see `cf_entry_rows` in kernels.h."""
    assert segments.derivatives is not None
    facet = segments.facets[:, 0]
    count = np.bincount(facet, minlength=1)
    starts = np.zeros(len(segment) + 1, np.int32)
    np.cumsum(12 + 4 * count[facet[segment]], out=starts[1:])
    values, columns = np.empty(starts[-1]), np.empty(starts[-1], np.int32)
    lib.cf_entry_rows(
        _read_int(mesh.nonmortar), _read_int(mesh.mortar), _read_int(normals.around),
        _read(normals.blocks), len(facet), _read_int(segments.facets), _read(segments.derivatives),
        len(segment), _read_int(segment), _read(by_integrals), _read(by_masses), _write(values),
        ffi.from_buffer("int32_t[]", columns, require_writable=True),
    )  # fmt: skip
    return Sparse(starts, columns, values, 2 * mesh.n_nodes)


def hidden(facet: Ints, span: Floats, distance: Floats, keep: NDArray[np.bool_]) -> Ints:
    """Segments whose middle is behind a nearer one of the same nonmortar facet that stands.

    Args:
        facet: Nonmortar facet of each segment, ascending, shape (s,).
        span: Interval of its coordinate, shape (s, 2).
        distance: Mean distance [m], shape (s,).
        keep: Segments to look at, shape (s,).

    Returns:
        Numbers of those that are hidden.
    """
    order = np.flatnonzero(keep)
    order = order[np.lexsort((span[order, 0], facet[order]))]
    first, second = order[:-1], order[1:]
    meet = (facet[first] == facet[second]) & (span[second, 0] < span[first, 1] - OVERLAP)
    order = order[np.isin(facet[order], facet[first[meet]])]
    order = order[np.lexsort((order, distance[order], facet[order]))]  # from near to far
    starts = np.flatnonzero(np.diff(facet[order], prepend=-1))
    rank = np.arange(len(order)) - np.repeat(starts, np.diff(starts, append=len(order)))
    middle, stands = span[order].mean(axis=1), np.ones(len(order), bool)
    for r in range(1, int(rank.max(initial=0)) + 1):
        at = np.flatnonzero(rank == r)
        for nearer in range(1, r + 1):
            before = at - nearer
            inside = (span[order[before], 0] < middle[at]) & (middle[at] < span[order[before], 1])
            stands[at[stands[before] & inside]] = False
    return np.asarray(order[~stands])


def _read(array: Floats) -> object:
    return ffi.from_buffer("double[]", np.ascontiguousarray(array))


def _read_int(array: Ints) -> object:
    return ffi.from_buffer("int64_t[]", np.ascontiguousarray(array))


def _read_flags(array: Bools) -> object:
    return ffi.from_buffer("uint8_t[]", np.ascontiguousarray(array).view(np.uint8))


def _write(array: Floats) -> object:
    return ffi.from_buffer("double[]", array, require_writable=True)


def _write_int(array: Ints) -> object:
    return ffi.from_buffer("int64_t[]", array, require_writable=True)
