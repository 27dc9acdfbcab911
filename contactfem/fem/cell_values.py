"""Coefficients of forms that are one number, or one for every cell."""

import numpy as np
from dolfinx import fem
from dolfinx.mesh import Mesh

from contactfem.common.typing import Floats


def coefficient(mesh: Mesh, value: float | Floats) -> fem.Constant | fem.Function:
    """A constant, or a function that is constant in every cell.

    Args:
        mesh: Mesh of a `BodyMesh`.
        value: The number, or one for every cell of the input mesh, (cells,), the same on all ranks.

    Returns:
        What stands in a form.
    """
    if np.ndim(value) == 0:
        return fem.Constant(mesh, float(value))
    function = fem.Function(fem.functionspace(mesh, ("DG", 0)))
    # the input cells are those of the first rank, which gives them all
    function.x.array[function.function_space.dofmap.list[:, 0]] = np.asarray(value)[
        mesh.topology.original_cell_index
    ]
    return function
