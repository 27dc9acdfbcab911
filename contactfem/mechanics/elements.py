"""Finite elements of displacement and pressure."""

from collections.abc import Mapping
from dataclasses import dataclass

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem

from mpi4py import MPI

from contactfem.fem.body_mesh import BodyMesh
from contactfem.forms.mechanics import Energy, MixedEnergy


@dataclass(frozen=True)
class Element:
    """Unknowns of a body as one finite element function.

    Attributes:
        unknowns: All of them [m]; with MINI also bubbles, and mean stresses as lengths.
        displacement: u as an expression of them [m].
        virtual: δu as an expression of the test functions [m].
        vertex_space: Space or subspace of u, for the dofs at the vertices.
        energy: Free energy with the mean stress, where it is a field, put in [J/m³].
        degree: Of the quadrature of the energy.
    """

    unknowns: fem.Function
    displacement: ufl.core.expr.Expr
    virtual: ufl.core.expr.Expr
    vertex_space: fem.FunctionSpace
    energy: Energy
    degree: int


def linear(mesh: BodyMesh, energy: Energy) -> Element:
    """Linear displacement, P1 or Q1.

    Args:
        mesh: The body's mesh.
        energy: Its free energy.

    Returns:
        The element.
    """
    domain = mesh.mesh
    shape = basix.ufl.element("Lagrange", domain.basix_cell(), 1, shape=(domain.geometry.dim,))
    V = fem.functionspace(domain, shape)
    u = fem.Function(V)
    # On simplices P1 has a constant gradient: one point integrates the energy exactly.
    return Element(u, u, ufl.TestFunction(V), V, energy, 1 if _is_simplex(mesh) else 2)


def mini(
    mesh: BodyMesh, energy: MixedEnergy, parameters: Mapping[str, ufl.core.expr.Expr]
) -> Element:
    """MINI element: displacement P1 with a bubble in each cell, continuous mean stress P1.

    Its trace is P1. The mean stress is p = (μ/h) q with the unknown q [m] and the mean cell size h,
    so that all unknowns are lengths, all residuals forces, and all blocks of the matrix of size μ.

    Args:
        mesh: The body's mesh, of simplices.
        energy: Its free energy with the mean stress as a field.
        parameters: Its parameters, with "shear_modulus" [Pa].

    Returns:
        The element.

    Raises:
        ValueError: The cells are not simplices.
    """
    if not _is_simplex(mesh):
        raise ValueError("MINI is for triangles and tetrahedra")
    domain, dim = mesh.mesh, mesh.mesh.geometry.dim
    cell = domain.basix_cell()
    P1 = basix.ufl.element("Lagrange", cell, 1)
    enriched = basix.ufl.enriched_element([P1, basix.ufl.element("Bubble", cell, dim + 1)])
    vector = basix.ufl.blocked_element(enriched, shape=(dim,))
    W = fem.functionspace(domain, basix.ufl.mixed_element([vector, P1]))
    w = fem.Function(W)
    u, q = ufl.split(w)
    p = parameters["shear_modulus"] / fem.Constant(domain, cell_size(mesh)) * q

    def with_mean_stress(
        F: ufl.core.expr.Expr,
        theta: ufl.core.expr.Expr,
        parameters: Mapping[str, ufl.core.expr.Expr],
    ) -> ufl.core.expr.Expr:
        return energy(F, p, theta, parameters)

    return Element(w, u, ufl.TestFunctions(W)[0], W.sub(0), with_mean_stress, 2 * dim)


def cell_size(mesh: BodyMesh) -> float:
    """Mean size of the cells, (volume / cells)^(1/dim) [m]; collective."""
    domain = mesh.mesh
    one = fem.form(fem.Constant(domain, 1.0) * ufl.dx(domain))
    volume = domain.comm.allreduce(fem.assemble_scalar(one), MPI.SUM)
    cells = domain.topology.index_map(domain.topology.dim).size_global
    return float(np.power(volume / cells, 1.0 / domain.geometry.dim))


def _is_simplex(mesh: BodyMesh) -> bool:
    return mesh.mesh.basix_cell().name in ("triangle", "tetrahedron")
