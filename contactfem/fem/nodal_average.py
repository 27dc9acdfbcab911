"""Nodal averages of cell values."""

from __future__ import annotations

import dolfinx
import numpy as np
from dolfinx import fem

from contactfem.common.typing import Floats


def nodal_average(V: fem.FunctionSpace, cell_values: Floats) -> fem.Function:
    """Average cell values at the vertices, over the cells around each, on whatever rank they are.

    Args:
        V: space of degree one with as many components as there are values per cell.
        cell_values: values of the cells of this rank, owned ones first (m, k).

    Returns:
        The averages.
    """
    owned = V.mesh.topology.index_map(V.mesh.topology.dim).size_local
    dofs = V.dofmap.list[:owned]
    total, count = fem.Function(V), fem.Function(V)
    block = V.dofmap.index_map_bs
    values = np.repeat(cell_values[:owned, None, :], dofs.shape[1], axis=1)
    np.add.at(total.x.array.reshape(-1, block), dofs, values)
    np.add.at(count.x.array.reshape(-1, block), dofs, 1.0)
    for part in (total, count):
        part.x.scatter_reverse(dolfinx.la.InsertMode.add)
        part.x.scatter_forward()
    total.x.array[:] /= np.maximum(count.x.array, 1.0)
    return total
