"""Continuous pressure with the moments of the multipliers (10)."""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from mpi4py import MPI

from contactfem.common.typing import Bools, Floats
from contactfem.contact.state import ContactState
from contactfem.mortar.mortar_operators import LineOperators

COVERED = 0.5  # covered share of a node's facets below which its pressure is that of its multiplier


def contact_pressure(c: ContactState) -> Floats:
    """Pressure of the multipliers at the nonmortar nodes, zero where open [Pa], (n_nonmortar,)."""
    return np.asarray(np.maximum(np.where(c.active, c.pressure, 0.0), 0.0))


def continuous_pressure(c: ContactState, comm: MPI.Comm) -> Floats:
    """Pressure p = Σ N_k p_k of the standard basis with the same moments, ∫ N_j p da = D_jj p_j.

    The multiplier of a dual basis is a mean: over the facets of a node, at an end of contact over
    one facet alone, so that as a value at the node it is of first order there. At a node next to
    an open one and at a barely covered one it is taken all the same: contact ends near there.

    Args:
        c: Contact state.
        comm: Ranks that share its segments; collective.

    Returns:
        Pressure at the nonmortar nodes, zero where open [Pa], (n_nonmortar,).
    """
    mesh, mean = c.operators.mesh, contact_pressure(c)
    operators = c.operators
    if mesh.basis == "standard" or not isinstance(operators, LineOperators):
        return mean
    active, carries = c.active, mesh.has_multiplier
    if not active.any():
        return mean
    mass, n = _mass(operators, comm), mesh.n_nonmortar
    trial, test = _extended(c, slope=True), _extended(c, slope=False)
    matrix, right = sp.csr_matrix(test.T @ mass @ trial), c.operators.D * mean
    lumped = ~active | (c.operators.coverage < COVERED) | _beside_open(c)
    keep = sp.diags((~lumped & carries).astype(np.float64))
    own = sp.diags((lumped | ~carries).astype(np.float64))
    values = spsolve(sp.csc_matrix(keep @ matrix + own), np.where(lumped, mean, right * carries))
    return np.asarray(np.maximum(trial @ np.reshape(values, n), 0.0))


def _mass(operators: LineOperators, comm: MPI.Comm) -> sp.csr_matrix:
    """∫ N_j N_k da over the covered part of the nonmortar surface [m], (n, n); collective."""
    mesh, segments = operators.mesh, operators.segments
    facets = segments.facets[:, 0]
    sums: Floats = np.zeros((len(mesh.nonmortar), 3))
    np.add.at(sums, facets, segments.integrals[:, :3])
    comm.Allreduce(MPI.IN_PLACE, sums)
    a, b = mesh.nonmortar.T
    values = np.concatenate((sums[:, 0], sums[:, 1], sums[:, 1], sums[:, 2]))
    places = np.concatenate((a, a, b, b)), np.concatenate((a, b, a, b))
    n = mesh.n_nonmortar
    return sp.coo_matrix((values, places), (n, n)).tocsr()


def _extended(c: ContactState, *, slope: bool) -> sp.csr_matrix:
    """Values at all nodes from those with a multiplier: the neighbour's, or with its slope."""
    mesh = c.operators.mesh
    carries, neighbours = mesh.has_multiplier, mesh.neighbours
    matrix = sp.lil_matrix((mesh.n_nonmortar, mesh.n_nonmortar))
    matrix.setdiag(carries.astype(np.float64))
    for j in np.flatnonzero(~carries):
        beside = [k for k in neighbours[j] if k >= 0 and carries[k]]
        for k in beside:
            matrix[j, k] += 1.0 / len(beside)
            further = [m for m in neighbours[k] if m not in (j, -1) and carries[m]]
            if slope and len(beside) == 1 and further and c.active[further[0]]:
                matrix[j, k] += 1.0
                matrix[j, further[0]] -= 1.0
    return matrix.tocsr()


def _beside_open(c: ContactState) -> Bools:
    """Nodes with an open neighbour that could carry pressure, (n,)."""
    mesh = c.operators.mesh
    open_ = ~c.active & mesh.has_multiplier
    neighbours = mesh.neighbours
    return np.asarray((open_[neighbours] & (neighbours >= 0)).any(axis=1))
