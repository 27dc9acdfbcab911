"""Inf-sup constant of the multipliers of an interface.

Without a lower bound on it as meshes are refined, whatever the ratio of their facets, pressures
oscillate freely (checkerboard). For studies and tests: dense, on one rank.
"""

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg

from contactfem.common.typing import Floats
from contactfem.mechanics.bulk_system import System
from contactfem.mechanics.contact_equations import Interface
from contactfem.mortar.mortar_operators import LineOperators
from contactfem.mortar.operators import basis


def smallest_singular_value(
    coupling: sp.csr_matrix, stiffness: sp.csr_matrix, norm: sp.csr_matrix
) -> float:
    """β = min over λ of max over v of λᵀ B v / (√(λᵀ S λ) √(vᵀ K v)).

    β² is the smallest eigenvalue of B K⁻¹ Bᵀ λ = β² S λ.

    Args:
        coupling: B, shape (m, n).
        stiffness: K, symmetric and positive definite, shape (n, n).
        norm: S, symmetric and positive definite, shape (m, m).

    Returns:
        β; 0 where round-off makes β² negative.
    """
    compliance = coupling @ scipy.sparse.linalg.splu(stiffness.tocsc()).solve(coupling.T.toarray())
    values = scipy.linalg.eigh((compliance + compliance.T) / 2, norm.toarray(), eigvals_only=True)
    return float(np.sqrt(max(values[0], 0.0)))


def inf_sup(system: System, interface: Interface, operators: LineOperators) -> float:
    """Inf-sup constant of an interface in the present state of its bodies.

    Displacements are measured by the energy of the bulk tangent K, multipliers by the norm
    Σ_f h_f/E ∫ |λ|² over covered facets, which scales as the natural one of H^(-1/2) does.

    Args:
        system: The bodies, held by their conditions without contact, on one rank.
        interface: The interface.
        operators: Its operators.

    Returns:
        β [-].
    """
    A = system.create_matrix(system.pattern)
    system.assemble(A, [None] * len(system.bodies))
    indptr, indices, data = A.getValuesCSR()
    A.destroy()
    n_global, mesh = system.numbering.n_global, interface.nodes.mesh
    K = sp.csr_matrix((data, indices, indptr), (n_global, n_global))
    own = sp.diags(operators.D, shape=(mesh.n_nonmortar, mesh.n_nodes))
    pair = sp.eye(mesh.dim)
    B = sp.kron(own - operators.M, pair).tocoo()
    unknown = interface.nodes.unknown.ravel()
    at = unknown[B.col] >= 0
    B = sp.coo_matrix((B.data[at], (B.row[at], unknown[B.col[at]])), (B.shape[0], n_global)).tocsr()
    S = sp.kron(multiplier_norm(interface, operators), pair).tocsr()
    seen = mesh.has_multiplier & (operators.D > 0.0)
    rows = np.flatnonzero(mesh.free[: mesh.n_nonmortar] & seen[:, None])
    present = np.setdiff1d(np.arange(n_global), system.numbering.multipliers)
    return smallest_singular_value(B[rows][:, present], K[present][:, present], S[rows][:, rows])


def multiplier_norm(interface: Interface, operators: LineOperators) -> sp.csr_matrix:
    """S_jk = Σ_f h_f/E ∫ Φ_j Φ_k over the covered part of each facet, E the softer modulus.

    Args:
        interface: The interface.
        operators: Its operators.

    Returns:
        S [m³/N], shape (n_nonmortar, n_nonmortar).
    """
    mesh, surface, x = operators.mesh, operators.surface, operators.own_x
    segments = operators.segments
    facets, e = np.unique(segments.facets[:, 0], return_inverse=True)
    m: Floats = np.zeros((len(facets), 3))
    np.add.at(m, e, segments.integrals[:, :3])
    ends = surface.nonmortar[facets]
    h = np.hypot(*(x[ends[:, 1]] - x[ends[:, 0]]).T)
    carries = surface.has_multiplier[ends]
    functions = basis(m, carries, mesh.basis)[0] * carries[:, :, None]
    mass = functions @ m[:, [[0, 1], [1, 2]]] @ functions.transpose(0, 2, 1)
    mass *= (h / interface.contact.law.stiffness)[:, None, None]
    ends = ends if surface.fold is None else surface.fold[ends]
    rows, cols = ends.repeat(2, axis=1).ravel(), np.tile(ends, (1, 2)).ravel()
    shape = (mesh.n_nonmortar, mesh.n_nonmortar)
    return sp.coo_matrix((mass.ravel(), (rows, cols)), shape).tocsr()
