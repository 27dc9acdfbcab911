"""Multipliers of nodes that have none, from those of their neighbours."""

import numpy as np
import scipy.sparse as sp

from contactfem.common.typing import Bools, Ints


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
