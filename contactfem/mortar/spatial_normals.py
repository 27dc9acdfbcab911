"""Averaged nodal normals of surfaces in space, and their derivative (1)."""

import numpy as np

from contactfem.common.typing import Bools, Floats, Ints


def averaged_normals(
    facets: Ints, x: Floats, free: Bools, around: Ints
) -> tuple[Floats, Floats, Floats]:
    """Nodal normals n_j = Σ c / |Σ c|, c = a × b / (|a|² |b|²) over the facets at each node.

    a and b are a facet's edges from the node, to the next and to the previous one. Such normals are
    exact where the facets around a node lie on a sphere. Components that are prescribed at a node
    are left out: it lies on a symmetry plane, whose mirrored facets would cancel them.

    Args:
        facets: Facets, counter-clockwise seen from outside, (k, 4).
        x: Positions of the nodes [m], (n_nodes, 3).
        free: Components that a node's normal may have, (n, 3).
        around: Neighbours of each node, -1 for none, (n, w).

    Returns:
        Unit normals, (n, 3), and their derivatives by the node's own position and then by those of
        its neighbours [1/m], (n, 3, 1 + w, 3); and the length of the sums [1/m²], (n,).
    """
    n, width = len(free), 1 + around.shape[1]
    total = np.zeros((n, 3))
    slopes = np.zeros((n, width, 3, 3))
    for node, after, before in corners(facets):
        a, b = x[after] - x[node], x[before] - x[node]
        a2, b2 = (np.einsum("ki,ki->k", e, e)[:, None] for e in (a, b))
        c = np.cross(a, b) / (a2 * b2)
        np.add.at(total, node, c)
        by_a = -_skew(b) / (a2 * b2)[..., None] - 2.0 * c[:, :, None] * (a / a2)[:, None, :]
        by_b = _skew(a) / (a2 * b2)[..., None] - 2.0 * c[:, :, None] * (b / b2)[:, None, :]
        for other, block in ((after, by_a), (before, by_b)):
            place = np.asarray(1 + np.argmax(around[node] == other[:, None], axis=1))
            np.add.at(slopes, (node, place), block)
            np.add.at(slopes, (node, np.zeros_like(node)), -block)
    total *= free
    length = np.sqrt(np.einsum("ji,ji->j", total, total))
    size = np.where(length > 0.0, length, 1.0)
    normals = total / size[:, None]
    plane = np.eye(3) - np.einsum("ji,jk->jik", normals, normals)
    project = plane / size[:, None, None] * free[:, None, :]
    return normals, np.einsum("jik,jwkc->jiwc", project, slopes), length


def corners(facets: Ints) -> list[tuple[Ints, Ints, Ints]]:
    """Corners of facets, some at a time.

    Args:
        facets: Facets, (k, 4).

    Returns:
        Node, next and previous node of each corner.
    """
    result = []
    triangle = facets[:, 2] == facets[:, 3]
    for count, some in ((3, facets[triangle]), (4, facets[~triangle])):
        for k in range(count):
            result.append((some[:, k], some[:, (k + 1) % count], some[:, (k - 1) % count]))
    return result


def _skew(vectors: Floats) -> Floats:
    """Matrices [v]× with [v]× w = v × w, (n, 3, 3)."""
    x, y, z = vectors.T
    zero = np.zeros(len(vectors))
    rows = ((zero, -z, y), (z, zero, -x), (-y, x, zero))
    return np.moveaxis(np.array(rows), -1, 0)
