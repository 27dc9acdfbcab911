"""Differences between dolfinx 0.9 and 0.11; no other module asks for the version."""

import ctypes
from functools import cache

import basix
import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import fem
from dolfinx.cpp.fem import pack_coefficients, pack_constants
from dolfinx.cpp.fem.petsc import assemble_matrix as _assemble_matrix
from dolfinx.mesh import GhostMode, Mesh, create_cell_partitioner
from dolfinx.mesh import create_mesh as _create_mesh

from mpi4py import MPI
from petsc4py import PETSc


def create_mesh(
    comm: MPI.Comm,
    cells: npt.NDArray[np.int64],
    points: npt.NDArray[np.float64],
    domain: ufl.Mesh,
) -> Mesh:
    """Mesh from every rank's share of cells and points; neighbours over shared facets are ghosts.

    Args:
        comm: communicator.
        cells: (m, nv) in dolfinx order, by global point number.
        points: (n, dim) [m].
        domain: coordinate element.

    Returns:
        The distributed mesh.
    """
    mode = GhostMode.shared_facet
    try:
        # Newer versions ask how many cells may meet in a facet: two, in a body.
        partitioner = create_cell_partitioner(mode, 2)
    except TypeError:
        partitioner = create_cell_partitioner(mode)
    # By name: the order of the arguments differs.
    return _create_mesh(comm, cells=cells, x=points, e=domain, partitioner=partitioner)


def assemble_into(A: PETSc.Mat, form: fem.Form) -> None:
    """Add a bilinear form to a matrix through its local-to-global maps, dof by dof.

    Entries whose row or column maps to -1 are dropped.

    Args:
        A: matrix with local-to-global maps of the form's scalar dofs.
        form: compiled bilinear form.
    """
    constants = pack_constants(form._cpp_object)
    coefficients = pack_coefficients(form._cpp_object)
    _assemble_matrix(A, form._cpp_object, constants, coefficients, [], True)


def cell_values(mesh: Mesh, expression: ufl.core.expr.Expr) -> npt.NDArray[np.float64]:
    """Values of an expression at the midpoints of all local cells.

    Args:
        mesh: the mesh.
        expression: scalar or vector expression.

    Returns:
        (cells, components).
    """
    midpoint = basix.geometry(mesh.basix_cell()).mean(axis=0)[None, :]
    compiled = fem.Expression(expression, midpoint)
    tdim = mesh.topology.dim
    cells = mesh.topology.index_map(tdim)
    n = cells.size_local + cells.num_ghosts
    values = compiled.eval(mesh, np.arange(n, dtype=np.int32))
    # also on a rank without cells
    return np.asarray(values).reshape(n, int(np.prod(expression.ufl_shape)))


@cache
def petsc_library() -> ctypes.CDLL:
    """PETSc itself, for the few functions that petsc4py does not wrap."""
    try:
        from dolfinx.fem.petsc import get_petsc_lib
    except ImportError:
        from dolfinx.utils import get_petsc_lib
    return ctypes.CDLL(str(get_petsc_lib()))
