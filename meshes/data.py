"""A mesh as arrays, with surfaces from facet groups."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.errors import MeshError

CellName = Literal["triangle", "quadrilateral", "tetrahedron", "hexahedron"]

# Facets of a cell in dolfinx's order, each by its vertices such that, in a cell with positive
# Jacobian, (b - a) turned clockwise, or (b - a) x (c - a), points outward.
FACETS: dict[CellName, tuple[tuple[int, ...], ...]] = {
    "triangle": ((1, 2), (2, 0), (0, 1)),
    "quadrilateral": ((0, 1), (2, 0), (1, 3), (3, 2)),
    "tetrahedron": ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)),
    "hexahedron": (
        (0, 2, 1, 3),
        (0, 1, 4, 5),
        (0, 4, 2, 6),
        (1, 3, 5, 7),
        (2, 6, 3, 7),
        (4, 5, 6, 7),
    ),
}
FAR = 1e30  # m; no geometry reaches so far
# The same cell seen in a mirror: its vertices in an order that changes the sign of the Jacobian.
MIRROR: dict[CellName, tuple[int, ...]] = {
    "triangle": (0, 2, 1),
    "quadrilateral": (0, 2, 1, 3),
    "tetrahedron": (0, 1, 3, 2),
    "hexahedron": (0, 2, 1, 3, 4, 6, 5, 7),
}


@dataclass(frozen=True)
class Surface:
    """Facets of one group.

    `vertices` (n,) mesh vertex numbers; `facets` (k, nf) indices into them; `X` (n, dim) [m].
    Walking a 2D facet from a to b the outward normal is (dy, -dx): the body lies on the left.
    A 2D surface is numbered along its walk, chain by chain.
    """

    vertices: Ints
    facets: Ints
    X: Floats


@dataclass(frozen=True)
class MeshData:
    """One body's mesh in input numbering.

    `points` (n, dim) [m]; `cells` (m, nv) in dolfinx vertex order, all with positive Jacobian;
    `groups`: named boundary facets (k, nf), oriented outward and in the order of a walk.
    """

    points: Floats
    cells: Ints
    cell_type: CellName
    groups: dict[str, Ints]

    def surface(self, name: str) -> Surface:
        """Surface of a group, numbered along the walk in 2D.

        Args:
            name: a key of `groups`.

        Returns:
            The surface with its own vertex numbering.

        Raises:
            MeshError: there is no such group, or it has no facets.
        """
        facets = self.groups.get(name)
        if facets is None or not len(facets):
            what = "has no facets" if facets is not None else "is not a group of this mesh"
            raise MeshError(f"'{name}' {what}; groups: {', '.join(self.groups) or 'none'}")
        vertices, first, inverse = np.unique(facets.ravel(), return_index=True, return_inverse=True)
        walk = np.argsort(first)
        rank = np.empty_like(walk)
        rank[walk] = np.arange(len(walk))
        return Surface(
            vertices[walk], rank[inverse].reshape(facets.shape), self.points[vertices[walk]]
        )


def mesh_data(
    points: Floats, cells: Ints, cell_type: CellName, groups: Mapping[str, Ints]
) -> MeshData:
    """Mesh with positive cells, outward facets and no unused points.

    Args:
        points: coordinates (n, dim) [m].
        cells: vertices (m, nv) in dolfinx order, of either sign.
        cell_type: name of the cells.
        groups: boundary facets (k, nf) by their vertices, in any order.

    Returns:
        The mesh; points keep their order.

    Raises:
        MeshError: a vertex that is no point, a point that is nowhere or out of all bounds, a
            degenerate or twisted cell, or a group's facet that is not on the boundary.
    """
    check_points(points, cells)
    used, flat = np.unique(cells.ravel(), return_inverse=True)
    number = np.full(len(points), -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    points = np.ascontiguousarray(points[used], dtype=np.float64)
    cells = positive(points, flat.reshape(cells.shape).astype(np.int64), cell_type)
    boundary = boundary_facets(cells, cell_type)
    oriented = {name: _oriented(name, number[f], boundary) for name, f in groups.items()}
    return MeshData(points, cells, cell_type, oriented)


def check_points(points: Floats, cells: Ints) -> None:
    """Make sure that cells have points that one can calculate with.

    Args:
        points: coordinates (n, dim) [m].
        cells: vertices (m, nv) of cells or facets, of one kind.

    Raises:
        MeshError: a vertex that is no point, a point whose coordinates are not finite or huge, or
            all points in one place.
    """
    if not len(cells):
        raise MeshError("has no cells")
    if cells.min() < 0 or cells.max() >= len(points):
        raise MeshError(f"has cells with vertices that are none of its {len(points)} points")
    used = points[np.unique(cells)]
    nowhere = ~(np.abs(used) < FAR).all(axis=1)
    if nowhere.any():
        raise MeshError(
            f"{nowhere.sum()} points have coordinates that are not finite or beyond {FAR:g} m"
        )
    if np.ptp(used, axis=0).max() < 1.0 / FAR:
        raise MeshError(f"has cells all of whose points lie within {1.0 / FAR:g} m")


def jacobians(points: Floats, cells: Ints, cell_type: CellName) -> Floats:
    """Jacobian determinants [m^dim] at every corner of every cell (m, nv), of simplices (m, 1)."""
    dim = points.shape[1]
    corners = range(2**dim) if cell_type in ("quadrilateral", "hexahedron") else [0]
    dets = []
    for a in corners:
        bits = [1 << k for k in range(dim)]
        if len(corners) == 1:
            ends, starts = [*range(1, dim + 1)], [0] * dim
        else:
            ends, starts = [a | bit for bit in bits], [a & ~bit for bit in bits]
        edges = points[cells[:, ends]] - points[cells[:, starts]]
        dets.append(np.linalg.det(edges))
    return np.stack(dets, axis=1)


def positive(points: Floats, cells: Ints, cell_type: CellName) -> Ints:
    """Cells with positive Jacobians: mirrored ones are turned.

    Raises:
        MeshError: a cell without volume, or twisted so that its Jacobian changes sign.
    """
    det = jacobians(points, cells, cell_type)
    turned = np.all(det < 0, axis=1)
    bad = np.flatnonzero(~turned & ~np.all(det > 0, axis=1))
    if len(bad):
        where = points[cells[bad[0]]].mean(axis=0)
        raise MeshError(
            f"{len(bad)} of {len(cells)} cells are flat or twisted, the first near {where} m"
        )
    cells = cells.copy()
    cells[turned] = cells[turned][:, MIRROR[cell_type]]
    return cells


def boundary_facets(cells: Ints, cell_type: CellName) -> Ints:
    """Facets (k, nf) that belong to one cell only, oriented outward."""
    return boundary(cells, cell_type)[0]


def boundary(cells: Ints, cell_type: CellName) -> tuple[Ints, Ints]:
    """Facets (k, nf) that belong to one cell only, oriented outward, and that cell (k,)."""
    facets = np.concatenate([cells[:, list(local)] for local in FACETS[cell_type]])
    number = _numbered(facets)
    outer = np.flatnonzero(np.bincount(number)[number] == 1)
    return facets[outer], outer % len(cells)


def _numbered(rows: Ints) -> Ints:
    """Numbers (k,) from 0 for rows (k, n) of vertices, equal where the rows are equal as sets."""
    columns = np.sort(rows, axis=1).T
    number: Ints = columns[0]
    for column in columns[1:]:
        _, number = np.unique(number * (rows.max() + 1) + column, return_inverse=True)
    return number


def matches(rows: Ints, table: Ints) -> Ints:
    """For each row its place in `table` as a set of numbers, -1 where it is not there.

    Args:
        rows: (k, n).
        table: (m, n), rows differ as sets.

    Returns:
        (k,) indices into `table`.
    """
    number = _numbered(np.concatenate([table, rows]))
    place = np.full(len(number), -1, dtype=np.int64)
    place[number[: len(table)]] = np.arange(len(table))
    found: Ints = place[number[len(table) :]]
    return found


def _oriented(name: str, facets: Ints, boundary: Ints) -> Ints:
    """Facets of a group as they stand in `boundary`, in 2D in the order of a walk."""
    if not len(facets):
        return np.empty((0, boundary.shape[1]), dtype=np.int64)
    if facets.shape[1] != boundary.shape[1]:
        raise MeshError(
            f"group '{name}' has facets of {facets.shape[1]} vertices, the cells have "
            f"{boundary.shape[1]}"
        )
    place = matches(facets, boundary)
    if np.any(place < 0):
        raise MeshError(
            f"group '{name}': {np.sum(place < 0)} of {len(facets)} facets are not on "
            "the body's boundary"
        )
    facets = boundary[np.unique(place)]
    return _walk(facets) if facets.shape[1] == 2 else facets


def _walk(facets: Ints) -> Ints:
    """2D facets chain by chain; a chain starts where nothing leads to it, a closed one anywhere."""
    leaving = {int(a): k for k, a in enumerate(facets[:, 0])}
    inner = np.isin(facets[:, 0], facets[:, 1])
    order: list[int] = []
    seen = np.zeros(len(facets), dtype=bool)
    for start in (*np.flatnonzero(~inner), *np.flatnonzero(inner)):
        k: int | None = int(start)
        while k is not None and not seen[k]:
            seen[k] = True
            order.append(k)
            k = leaving.get(int(facets[k, 1]))
    return facets[order]
