"""Differences between dolfinx 0.9, 0.10 and 0.11."""

import ctypes
from functools import cache

import basix
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
import ufl
from dolfinx import fem
from dolfinx.cpp.fem import pack_coefficients, pack_constants
from dolfinx.cpp.fem.petsc import assemble_matrix as _assemble_matrix
from dolfinx.mesh import GhostMode, Mesh, create_cell_partitioner
from dolfinx.mesh import create_mesh as _create_mesh
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.apply_derivatives import apply_derivatives
from ufl.algorithms.transformer import strip_variables

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


def cell_nodes(mesh: Mesh) -> npt.NDArray[np.int32]:
    """Geometry nodes of all local cells, (cells, nv); the mesh has one kind of cells."""
    geometry = mesh.geometry
    nodes = geometry.dofmaps[0] if hasattr(geometry, "dofmaps") else geometry.dofmap
    return np.asarray(nodes)


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


def local_matrix(form: fem.Form) -> sp.csr_matrix:
    """A bilinear form over this rank's cells, by its local dofs, owned and ghost; collective.

    Args:
        form: compiled bilinear form on a space without blocks.
    """
    whole = fem.assemble_matrix(form).to_scipy(ghosted=True)
    return whole[:, : whole.shape[0]]  # the columns that follow belong to other ranks' rows


class CellExpression:
    """An expression at the same points of all local cells, compiled once.

    Args:
        mesh: the mesh.
        expression: scalar or vector expression.
        points: points of the reference cell (q, dim); its midpoint without.
    """

    def __init__(
        self,
        mesh: Mesh,
        expression: ufl.core.expr.Expr,
        points: npt.NDArray[np.float64] | None = None,
    ) -> None:
        midpoint = basix.geometry(mesh.basix_cell()).mean(axis=0)[None, :]
        self._points = midpoint if points is None else points
        self._mesh = mesh
        self._compiled = fem.Expression(_without_variables(expression), self._points)
        self._components = int(np.prod(expression.ufl_shape))

    def values(self) -> npt.NDArray[np.float64]:
        """Values with the present coefficients, (cells, q, components)."""
        cells = self._mesh.topology.index_map(self._mesh.topology.dim)
        n = cells.size_local + cells.num_ghosts
        found = self._compiled.eval(self._mesh, np.arange(n, dtype=np.int32))
        # also on a rank without cells
        return np.asarray(found).reshape(n, len(self._points), self._components)


def _without_variables(expression: ufl.core.expr.Expr) -> ufl.core.expr.Expr:
    """The same with derivatives taken: what is left of ufl.variable has a number of its own.

    ffcx puts that number into the name of what it compiles (for forms it does not), so that equal
    expressions would be compiled anew for every mesh.
    """
    return strip_variables(apply_derivatives(apply_algebra_lowering(expression)))


@cache
def petsc_library() -> ctypes.CDLL:
    """PETSc itself, for the few functions that petsc4py does not wrap."""
    try:
        from dolfinx.fem.petsc import get_petsc_lib
    except ImportError:
        from dolfinx.utils import get_petsc_lib
    return ctypes.CDLL(str(get_petsc_lib()))


def has_package(name: str) -> bool:
    """Whether PETSc was built with another library, such as "mumps" or "hypre"."""
    return bool(PETSc.Sys.hasExternalPackage(name))


def unlock(vector: PETSc.Vec) -> None:
    """Give back the locks that an error inside PETSc left on a vector: it could not be written.

    Args:
        vector: The vector.
    """
    library, handle, locks = petsc_library(), ctypes.c_void_p(vector.handle), ctypes.c_int()
    library.VecLockGet(handle, ctypes.byref(locks))
    for _ in range(locks.value):
        library.VecLockReadPop(handle)
