"""Triangles in a region bounded by lines and arcs."""

from collections.abc import Sequence
from math import ceil, dist
from typing import Any

import numpy as np

from contactfem.common.typing import Floats, Ints
from contactfem.errors import MeshError
from contactfem.meshes.curves import Edge
from contactfem.meshes.data import MeshData, mesh_data
from contactfem.meshes.gmsh_session import gmsh_session


def triangulate(edges: Sequence[Edge], size: float, growth: float, coarse: float) -> MeshData:
    """Frontal-Delaunay mesh with cell size min(coarse, size + growth * distance to the fine edges).

    Args:
        edges: closed boundary, counter-clockwise.
        size: length of the facets of fine edges, at most [m].
        growth: increase of the cell size per distance [-].
        coarse: largest cell size [m].

    Returns:
        The mesh, the same for the same arguments; nodes of arcs lie exactly on them.

    Raises:
        MeshError: the region cannot be meshed.
    """
    with gmsh_session() as gmsh:
        try:
            curves = _geometry(gmsh, edges, size)
            _sizes(gmsh, edges, curves, size, growth, coarse)
            gmsh.model.mesh.generate(2)
        except Exception as error:  # gmsh raises nothing more special
            raise MeshError(f"gmsh cannot mesh the region: {error}") from error
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        order = np.argsort(tags)
        points = coordinates.reshape(-1, 3)[order, :2]
        _, cells = gmsh.model.mesh.getElementsByType(2)
        if not len(cells):  # newer versions do not complain
            raise MeshError("gmsh cannot mesh the region: no triangles came out")
        lines = [gmsh.model.mesh.getElements(1, curve)[2][0].reshape(-1, 2) for curve in curves]
    number = tags[order]
    facets = [np.searchsorted(number, line) for line in lines]
    groups: dict[str, list[Ints]] = {}
    for edge, part in zip(edges, facets, strict=True):
        _exact(edge, points, np.unique(part))
        for name in edge.groups:
            groups.setdefault(name, []).append(part)
    return mesh_data(
        points,
        np.searchsorted(number, cells.reshape(-1, 3)),
        "triangle",
        {name: np.concatenate(parts) for name, parts in groups.items()},
    )


def doubled(data: MeshData, axis: str) -> MeshData:
    """Mesh and its mirror image in the line x = 0, joined along the group `axis`, which disappears.

    Raises:
        MeshError: the group is missing or empty.
    """
    joint = data.surface(axis).vertices
    points = data.points.copy()
    points[joint, 0] = 0.0
    image = len(points) + np.arange(len(points))
    image[joint] = joint
    both = np.concatenate([points, points * [-1.0, 1.0]])
    groups = {
        name: np.concatenate([facets, image[facets]])
        for name, facets in data.groups.items()
        if name != axis
    }
    return mesh_data(both, np.concatenate([data.cells, image[data.cells]]), data.cell_type, groups)


def _geometry(gmsh: Any, edges: Sequence[Edge], size: float) -> list[int]:
    """Points, curves and the surface; returns the curves."""
    geo = gmsh.model.geo
    corners = [geo.addPoint(*edge.start, 0.0) for edge in edges]
    centres = {e.centre: geo.addPoint(*e.centre, 0.0) for e in edges if e.centre is not None}
    curves = []
    for k, edge in enumerate(edges):
        a, b = corners[k], corners[(k + 1) % len(edges)]
        if edge.centre is None:
            curves.append(geo.addLine(a, b))
        else:
            curves.append(geo.addCircleArc(a, centres[edge.centre], b))
        if edge.fine:
            facets = ceil(edge.length() / size - 1e-9)
            geo.mesh.setTransfiniteCurve(curves[-1], facets + 1)
    geo.addPlaneSurface([geo.addCurveLoop(curves)])
    geo.synchronize()
    return curves


def _sizes(
    gmsh: Any, edges: Sequence[Edge], curves: list[int], size: float, growth: float, coarse: float
) -> None:
    """Background field of the cell size."""
    field = gmsh.model.mesh.field
    fine = [curve for curve, edge in zip(curves, edges, strict=True) if edge.fine]
    longest = max(edge.length() for edge in edges if edge.fine)
    distance = field.add("Distance")
    field.setNumbers(distance, "CurvesList", fine)
    field.setNumber(distance, "Sampling", 2 * ceil(longest / size))
    threshold = field.add("Threshold")
    numbers = {
        "InField": distance,
        "SizeMin": size,
        "SizeMax": coarse,
        "DistMin": 0.0,
        "DistMax": (coarse - size) / growth,
    }
    for name, value in numbers.items():
        field.setNumber(threshold, name, value)
    field.setAsBackgroundMesh(threshold)
    for name in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
        gmsh.option.setNumber(f"Mesh.MeshSize{name}", 0)
    gmsh.option.setNumber("Mesh.Algorithm", 6)


def _exact(edge: Edge, points: Floats, nodes: Ints) -> None:
    """Put an edge's nodes in place to the last digit: on the arc, and evenly if it is fine."""
    away = points[nodes] - np.array(edge.start)
    inner = nodes[np.argsort(np.hypot(*away.T))][1:-1]
    if edge.fine:
        points[inner] = edge.at(np.arange(1, len(nodes) - 1) / (len(nodes) - 1))
    elif edge.centre is not None:
        spokes = points[inner] - np.array(edge.centre)
        radius = dist(edge.start, edge.centre)
        points[inner] = edge.centre + radius * spokes / np.hypot(*spokes.T)[:, None]
