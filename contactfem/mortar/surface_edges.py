"""Edges of a surface: which of its nodes are neighbours, and what these pass on."""

import numpy as np
import scipy.sparse as sp

from contactfem.common.typing import Bools, Ints


def neighbours(facets: Ints, n: int) -> Ints:
    """Nodes at the other ends of the edges at each node.

    Args:
        facets: Facets of a surface in space (k, 4), a triangle with its last node twice.
        n: Number of nodes.

    Returns:
        Ascending, -1 after the last, shape (n, w) for w edges at a node at most.
    """
    ends = np.stack((facets, np.roll(facets, -1, axis=1)), axis=2).reshape(-1, 2)
    ends = ends[ends[:, 0] != ends[:, 1]]
    both = np.unique(np.vstack((ends, ends[:, ::-1])), axis=0)
    count = np.bincount(both[:, 0], minlength=n)
    result = np.full((n, max(int(count.max(initial=0)), 1)), -1, np.int64)
    place = np.arange(len(both)) - np.repeat(np.cumsum(count) - count, count)
    result[both[:, 0], place] = both[:, 1]
    return result


def extension(around: Ints, has_multiplier: Bools) -> sp.csr_matrix:
    """Extends multipliers to nodes that have none, λ_o = Σ_k E_ok λ_k, by a constant matrix.

    It is the mean over the neighbours that have one; a node without such takes what its neighbours
    got. So a facet passes its pressure on whatever is prescribed at its nodes.

    Args:
        around: Neighbours of each node, -1 for none, (n, w).
        has_multiplier: Whether the nodes have a multiplier, (n,).

    Returns:
        E, (n, n): unit rows of nodes with a multiplier; empty ones where none is within reach.
    """
    n = len(around)
    row, place = np.nonzero(around >= 0)
    near = sp.csr_matrix((np.ones(len(row)), (row, around[row, place])), (n, n))
    E = sp.diags(has_multiplier.astype(float)).tocsr()
    done = has_multiplier.copy()
    while not done.all():
        known = near @ sp.diags(done.astype(float))
        total = np.asarray(known.sum(axis=1)).ravel()
        new = ~done & (total > 0.0)
        if not new.any():
            break
        share = np.divide(1.0, total, out=np.zeros(n), where=new)
        E = (E + sp.diags(share) @ known @ E).tocsr()
        done |= new
    E.eliminate_zeros()
    return E
