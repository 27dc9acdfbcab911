"""Areas of facets in space, shared among their nodes."""

import numpy as np

from contactfem.common.typing import Bools, Floats, Ints
from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.sparse import Sparse, joined

# Of each triangle's area, what every node of a quadrilateral gets: the two that are its corners a
# third, and all a quarter of a third, as the mean of the nodes is the third corner.
_QUADRILATERAL = np.array(
    [[(5.0 if k in (s, (s + 1) % 4) else 1.0) / 12.0 for k in range(4)] for s in range(4)]
)
_TRIANGLE = np.array([1.0, 1.0, 1.0, 0.0]) / 3.0
# Triangle s of a quadrilateral: positions of its corners by those of the nodes
_CORNERS = np.array(
    [
        [np.eye(4)[s], np.eye(4)[(s + 1) % 4], np.full(4, 0.25)]
        for s in range(4)
    ]
)  # fmt: skip


def is_triangle(facets: Ints) -> Bools:
    """Which facets are triangles: they have their last node twice, (k,)."""
    return np.asarray(facets[:, 2] == facets[:, 3])


def _triangles(facets: Ints, x: Floats) -> tuple[Ints, Floats, Floats, Floats]:
    """Facets as triangles.

    Returns:
        Facet of each, (t,), its corners [m], (t, 3, 3), those by the facet's nodes [-], (t, 3, 4),
        and the share of its area that each node gets [-], (t, 4).
    """
    plain = np.flatnonzero(is_triangle(facets))
    quads = np.flatnonzero(~is_triangle(facets))
    facet = np.concatenate((plain, np.repeat(quads, 4)))
    corners = np.concatenate(
        (np.tile(np.eye(3, 4), (len(plain), 1, 1)), np.tile(_CORNERS, (len(quads), 1, 1)))
    )
    shares = np.concatenate(
        (np.tile(_TRIANGLE, (len(plain), 1)), np.tile(_QUADRILATERAL, (len(quads), 1)))
    )
    return facet, corners @ x[facets[facet]], corners, shares


def _area_vectors(points: Floats) -> Floats:
    return np.asarray(0.5 * np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]))


def areas(facets: Ints, x: Floats) -> Floats:
    """Areas of facets: a quadrilateral, flat or not, as four triangles around its nodes' mean.

    Args:
        facets: Facets, shape (k, 4).
        x: Positions of the nodes [m], shape (n, 3).

    Returns:
        Areas [m²], shape (k,).
    """
    facet, points, _, _ = _triangles(facets, x)
    size = np.linalg.norm(_area_vectors(points), axis=1)
    return np.bincount(facet, size, len(facets)).astype(np.float64)


def full_areas(mesh: InterfaceMesh, x: Floats) -> Floats:
    """∫ N_j over the whole facets at each nonmortar node, D_jj of full coverage.

    Args:
        mesh: The interface.
        x: Current positions [m], shape (n_nodes, 3).

    Returns:
        Areas [m²], shape (n_nonmortar,).
    """
    facet, points, _, shares = _triangles(mesh.nonmortar, x)
    parts = np.linalg.norm(_area_vectors(points), axis=1)[:, None] * shares
    nodes = mesh.nonmortar[facet]
    return np.bincount(nodes.ravel(), parts.ravel(), mesh.n_nonmortar).astype(np.float64)


def full_areas_derivative(mesh: InterfaceMesh, x: Floats) -> Sparse:
    """Derivative of `full_areas` by the positions.

    Args:
        mesh: The interface.
        x: Current positions [m], shape (n_nodes, 3).

    Returns:
        Derivative [m], (n_nonmortar, 3 n_nodes).
    """
    facet, points, corners, shares = _triangles(mesh.nonmortar, x)
    vectors = _area_vectors(points)
    normals = vectors / np.linalg.norm(vectors, axis=1)[:, None]
    opposite = np.roll(points, -2, axis=1) - np.roll(points, -1, axis=1)
    by_corner = 0.5 * np.cross(normals[:, None, :], opposite)  # moving a corner along its height
    by_node = np.einsum("tpk,tpc->tkc", corners, by_corner)
    nodes = mesh.nonmortar[facet]
    values = shares[:, :, None, None] * by_node[:, None, :, :]
    rows = np.broadcast_to(nodes[:, :, None, None], values.shape)
    columns = np.broadcast_to((3 * nodes[:, :, None] + np.arange(3))[:, None], values.shape)
    triplets = joined([(rows.ravel(), columns.ravel(), values.ravel())])
    return Sparse.of_triplets(triplets, (mesh.n_nonmortar, 3 * mesh.n_nodes))
