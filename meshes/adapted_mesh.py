"""Triangles of given sizes inside an exact boundary."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contactfem.common.typing import Floats, Ints
from contactfem.errors import MeshError
from contactfem.meshes.boundary_nodes import Division, divided
from contactfem.meshes.curves import Boundary, enclosed
from contactfem.meshes.data import MeshData, jacobians, mesh_data
from contactfem.meshes.gmsh_session import gmsh_session
from contactfem.meshes.layers import Layers, Rows, facet_lengths, with_rows
from contactfem.meshes.size_field import SizeField

SHORT = 0.7  # of the size: facets below this make the cells around them smaller
GROWTH = 0.5  # largest increase of the size per distance that makes good triangles
MAX_CELLS = 5_000_000
AWAY = 0.4  # of its square's width: distance of a seed from the boundary


def adapt(
    boundary: Boundary, field: SizeField, keep: Floats, layers: Layers | None = None
) -> MeshData:
    """Frontal-Delaunay mesh with the sizes of a field.

    Nodes divide the curves first, so that no cell is ever moved; they are where the curves place
    them to the last digit, and corners stay.

    Args:
        boundary: closed loops of curves.
        field: wanted sizes; where they grow faster than 0.5 per distance, smaller ones are used.
        keep: points (k, 2) [m] that become nodes.
        layers: surfaces with flat cells, for which sizes are thicknesses.

    Returns:
        The mesh, the same for the same arguments.

    Raises:
        MeshError: the region cannot be meshed at these sizes.
    """
    field = field.graded(GROWTH)
    count = field if layers is None else replace(field, sizes=layers.mean(field.sizes))
    if count.number_of_cells() > MAX_CELLS:
        raise MeshError(
            f"the sizes ask for {count.number_of_cells():.2g} cells; at most {MAX_CELLS} are made"
        )
    division = _divided(boundary, field, keep, layers)
    fitting = _fitting(field, division)
    if fitting is not field:
        field, division = fitting, _divided(boundary, fitting, keep, layers)
    rows = with_rows(division, field, layers)
    inner = np.concatenate([division.inner, _seeds(field, rows)])
    points, cells = _filled(rows, inner, field)
    data = mesh_data(points, cells, "triangle", division.groups)
    area = 0.5 * jacobians(data.points, data.cells, "triangle").sum()
    wanted = sum(enclosed(division.nodes[loop]) for loop in division.loops)
    if abs(area - wanted) > 1e-9 * wanted:
        raise MeshError("facets of these sizes cross each other: the boundary needs smaller ones")
    return data


def _divided(boundary: Boundary, field: SizeField, keep: Floats, layers: Layers | None) -> Division:
    if layers is None:
        return divided(boundary, field, keep)
    lengths = facet_lengths(boundary, field, layers)
    return divided(boundary, field, keep, dict.fromkeys(layers.groups, lengths))


def _fitting(field: SizeField, division: Division) -> SizeField:
    """Sizes that fit the facets where corners and curves make these much shorter than wanted."""
    after = np.concatenate([np.roll(loop, -1) for loop in division.loops])
    start, end = division.nodes, division.nodes[after]
    middle, length = 0.5 * (start + end), np.hypot(*(end - start).T)
    short = length < SHORT * field.at(middle)
    return field.limited(middle[short], length[short], GROWTH) if np.any(short) else field


def _seeds(field: SizeField, rows: Rows) -> Floats:
    """A few nodes inside, without which gmsh takes several times as long for graded meshes.

    It starts from triangles of the boundary's nodes alone. Where many of these are close together
    the triangles are slivers across the region, and every new node meets very many of them.

    Args:
        field: wanted sizes h.
        rows: the region to be filled.

    Returns:
        Centres of squares, wider than 4 h and not wider than 8 h, that lie about half of that away
        from the region's boundary, (k, 2) [m].
    """
    from contactfem.geometry.closest_point import (
        NearestFacets,  # scipy, not before a mesh is adapted
    )

    width = _width(field.sizes)
    square = np.unique(np.column_stack([width, field.points // width[:, None]]), axis=0)
    width, centre = square[:, 0], (square[:, 1:] + 0.5) * square[:, :1]
    fits = field.covers(centre)
    fits[fits] = _width(field.at(centre[fits])) == width[fits]
    if not np.any(fits):
        return np.empty((0, 2))
    facets = np.concatenate([np.column_stack([k, np.roll(k, -1)]) for k in rows.loops])
    away = NearestFacets(rows.nodes, facets).closest(centre[fits])[2]
    found = np.asarray(centre[fits][away > AWAY * width[fits]])
    return found[_surrounded(found, rows.nodes[facets])] if len(rows.cells) else found


def _surrounded(x: Floats, facets: Floats) -> NDArray[np.bool_]:
    """Which points (k, 2) lie inside of closed loops of facets (m, 2, 2), by crossings."""
    (ax, ay), (bx, by) = facets[:, 0].T, facets[:, 1].T
    crossed = (ay > x[:, 1:]) != (by > x[:, 1:])
    rise = np.where(by == ay, 1.0, by - ay)
    beyond = x[:, :1] < ax + (x[:, 1:] - ay) / rise * (bx - ax)
    return np.asarray(np.sum(crossed & beyond, axis=1) % 2 == 1)


def _width(sizes: Floats) -> Floats:
    """The power of two between 4 h and 8 h."""
    return np.asarray(2.0 ** np.floor(np.log2(8.0 * sizes)))


def _filled(rows: Rows, inner: Floats, field: SizeField) -> tuple[Floats, Ints]:
    """Points, first those given and then those inside, and triangles: rows, and others by gmsh."""
    given = np.concatenate([rows.nodes, inner])
    used = np.concatenate([*rows.loops, len(rows.nodes) + np.arange(len(inner))])
    # gmsh has absolute tolerances, so it gets a region of size one
    origin, scale = given.min(axis=0), float(np.ptp(given, axis=0).max())
    with gmsh_session() as gmsh:
        try:
            _region(gmsh, rows.loops, inner, (given - origin) / scale)
            _background(gmsh, field, origin, scale)
            gmsh.model.mesh.generate(2)
        except Exception as error:  # gmsh raises nothing more special
            raise MeshError(f"gmsh cannot mesh the region: {error}") from error
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        _, cells = gmsh.model.mesh.getElementsByType(2)
    order = np.argsort(tags)
    points = origin + scale * coordinates.reshape(-1, 3)[order, :2]
    n = len(used)
    if len(points) < n or np.abs(points[:n] - given[used]).max() > 1e-9 * scale:
        raise MeshError("gmsh cannot mesh the region: it moved given nodes")
    number = np.concatenate([used, len(given) + np.arange(len(points) - n)])
    filled = number[np.searchsorted(tags[order], cells.reshape(-1, 3))]
    return np.concatenate([given, points[n:]]), np.concatenate([rows.cells, filled])


def _region(gmsh: Any, loops: tuple[Ints, ...], inner: Floats, given: Floats) -> None:
    """The surface; every facet is a line of its own, which gmsh cannot divide otherwise."""
    geo = gmsh.model.geo
    chains = []
    for loop in loops:
        tags = [geo.addPoint(*x, 0.0) for x in given[loop]]
        chains.append([geo.addLine(a, b) for a, b in pairwise([*tags, tags[0]])])
        for line in chains[-1]:
            geo.mesh.setTransfiniteCurve(line, 2)
    seeds = [geo.addPoint(*x, 0.0) for x in given[len(given) - len(inner) :]]
    surface = geo.addPlaneSurface([geo.addCurveLoop(lines) for lines in chains])
    geo.synchronize()
    gmsh.model.mesh.embed(0, seeds, 2, surface)


def _background(gmsh: Any, field: SizeField, origin: Floats, scale: float) -> None:
    """The sizes, as a view of the old mesh."""
    corners = ((field.points - origin) / scale)[field.cells]
    x, y = corners[..., 0], corners[..., 1]
    rows = np.hstack([x, y, np.zeros_like(x), field.sizes[field.cells] / scale])
    view = gmsh.view.add("size")
    gmsh.view.addListData(view, "ST", len(rows), rows.ravel())
    tag = gmsh.model.mesh.field.add("PostView")
    gmsh.model.mesh.field.setNumber(tag, "ViewTag", view)
    gmsh.model.mesh.field.setNumber(tag, "UseClosest", 1)  # else outside is without bound
    gmsh.model.mesh.field.setAsBackgroundMesh(tag)
    for name in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
        gmsh.option.setNumber(f"Mesh.MeshSize{name}", 0)
    gmsh.option.setNumber("Mesh.Algorithm", 6)
