"""Exact tangent of contact conditions and contact forces of one interface.

Conditions stand as rows of forces, α_n n_j C_n + α_t C_t with the normal condition C_n and the
tangential one C_t, dim rows per node. So do their derivatives, α_n n_j dC_n + α_t P_j dC_t with
P_j = 1 - n_j n_jᵀ. What this leaves out are multiples of C_n and C_t, which vanish: Newton's method
stays quadratic, and in two dimensions it is that of the conditions along n and τ.
"""

from dataclasses import dataclass

import numpy as np

from contactfem.common.typing import Bools, Floats, Ints
from contactfem.contact.conditions import Contact
from contactfem.contact.state import ContactState
from contactfem.laws.active_set import Status
from contactfem.laws.complementarity import unit
from contactfem.mortar.mortar_operators import Weights, on_blocks
from contactfem.mortar.normals import NormalField
from contactfem.mortar.sparse import Sparse, Triplets, joined

ROUND_OFF = 1e-12  # entry of 1 - n nᵀ - d dᵀ that is none: in two dimensions nothing is across


@dataclass(frozen=True)
class RowScales:
    """Factors that make forces of conditions.

    Attributes:
        normal: α_n, of C_n [m], (n,).
        tangential: α_t, of C_t: stick [m], slip [Pa], (n,).
    """

    normal: Floats
    tangential: Floats


@dataclass(frozen=True)
class Tangent:
    """Linearisation of the forces on the nodes and of the conditions at the nonmortar nodes.

    Rows: first the mortar part of the contact forces, -Σ_j M_jl λ_j, dim per node (n_nodes); then
    the conditions of every nonmortar node, dim per node (n). The conditions are those of active
    nodes; all other rows are empty.

    Attributes:
        by_multiplier: With respect to λ, columns dim per nonmortar node; the same on all ranks.
        by_position: With respect to the positions at fixed λ, columns dim per node; the ranks'
            parts add up.
        D_by_position: d D_jj / dx of the active nodes, (n, dim n_nodes); the ranks' parts add up.
    """

    by_multiplier: Sparse
    by_position: Sparse
    D_by_position: Sparse


def condition_rows(c: ContactState, scales: RowScales) -> Floats:
    """Conditions as forces, α_n n_j C_n + α_t C_t, (n, dim)."""
    normal = (scales.normal * c.residuals.normal)[:, None] * c.operators.normals.n
    return np.asarray(normal + scales.tangential[:, None] * c.residuals.tangential)


def linearise(contact: Contact, c: ContactState, scales: RowScales) -> Tangent:
    """Differentiate the contact forces and conditions at a state.

    Args:
        contact: The interface.
        c: The state.
        scales: Of the conditions.

    Returns:
        This rank's part of the tangent.
    """
    mesh, dim = contact.mesh, contact.mesh.dim
    n, first = mesh.n_nonmortar, mesh.dim * mesh.n_nodes
    f = _Factors.of(contact, c, scales)
    change = _coverage_factors(c, scales)
    weights = Weights(
        active=c.active,
        D=change,
        gap=f.normal,
        jump=f.slip / np.where(c.motion.known, c.history.D, 1.0)[:, None, None],
        multiplier=c.multiplier.vector,
    )
    found = c.operators.derivative(weights)
    conditions = first + dim * n
    mine = np.arange(n) % contact.comm.size == contact.comm.rank
    parts = [
        found.part(0, conditions).triplets(),
        *_by_normals(c, f, first, mine),
        *_by_history(c, weights.jump, first, mine),
        *_by_full(c, change, first, mine),
    ]
    by_position = Sparse.of_triplets(joined(parts), (conditions, first))
    return Tangent(_by_multiplier(c, f), by_position, found.part(conditions, found.height))


@dataclass(frozen=True)
class _Factors:
    """Factors of the rows of conditions, zero for nodes that are not active.

    Attributes:
        normal: α_n n_j of dC_n, (n, dim).
        pressure: Of dp_j, (n, dim).
        traction: Of the tangential part of dt_j, (n, dim, dim).
        slip: Of the tangential part of ds_j, (n, dim, dim).
        edge_pressure: Of dp_k of the neighbours that edge nodes are tied to, (m, dim).
        edge_traction: Of dt_k of these, (m, dim, dim).
    """

    normal: Floats
    pressure: Floats
    traction: Floats
    slip: Floats
    edge_pressure: Floats
    edge_traction: Floats

    @staticmethod
    def of(contact: Contact, c: ContactState, scales: RowScales) -> "_Factors":
        """Factors at a state.

        Stick: dC_t = ds - (κ + a_t) dt + κ T dt_k. Slip, in "return" form:
        dC_t = dt - d (b_p dp + b_v dv) - ε (1 - n nᵀ - d dᵀ) (dt + c ds).
        """
        law, n, d = contact.law, c.operators.normals.n, c.active_set.direction
        stick, slip = c.status == Status.STICK, c.status == Status.SLIP
        plane = np.eye(n.shape[1]) - np.einsum("ji,jk->jik", n, n)
        turn = c.turning[:, None, None] * _across(plane, d)
        compliance = c.edge.compliance + law.tangential_compliance
        normal = np.where(c.active, scales.normal, 0.0)[:, None] * n
        own = (c.edge.compliance + law.normal_compliance)[:, None] * normal
        by_bound = np.where(slip, scales.tangential, 0.0)[:, None] * d
        on_stick, on_slip = (
            np.where(at, scales.tangential, 0.0)[:, None, None] for at in (stick, slip)
        )
        speed = np.where(c.motion.known, c.bound.by_speed / c.history.dt, 0.0)
        by_speed = np.einsum("j,ji,jk->jik", speed, by_bound, unit(c.slip))
        at, kappa = c.edge.nodes, c.edge.compliance[c.edge.nodes]
        return _Factors(
            normal=normal,
            pressure=own - c.bound.by_pressure[:, None] * by_bound,
            traction=on_slip * (plane - turn) - on_stick * compliance[:, None, None] * plane,
            slip=on_stick * plane - on_slip * (law.c_t * law.c)[:, None, None] * turn - by_speed,
            edge_pressure=-kappa[:, None] * normal[at],
            edge_traction=on_stick[at] * kappa[:, None, None] * c.edge.turns,
        )


def _across(plane: Floats, d: Floats) -> Floats:
    """What of the tangent planes is across unit vectors, 1 - n nᵀ - d dᵀ, (n, dim, dim)."""
    across = plane - np.einsum("ji,jk->jik", d, d)
    return np.where(np.abs(across) < ROUND_OFF, 0.0, across)


def _coverage_factors(c: ContactState, scales: RowScales) -> Floats:
    """Factors of dD_jj in the conditions through κ, (n, dim); those of dfull are -f times them."""
    result = np.zeros_like(c.traction_change)
    at = c.edge.nodes[c.active[c.edge.nodes]]
    if not len(at):
        return result
    slope = c.edge.slope[at] / c.operators.full[at]
    p = (c.multiplier.pressure - c.edge.pressure_target(c.multiplier.pressure))[at]
    stick = np.where(c.status[at] == Status.STICK, scales.tangential[at], 0.0)
    normal = (scales.normal[at] * slope * p)[:, None] * c.operators.normals.n[at]
    result[at] = normal - (stick * slope)[:, None] * c.traction_change[at]
    return result


def _by_multiplier(c: ContactState, f: _Factors) -> Sparse:
    """Derivative of all rows with respect to the multipliers."""
    n, dim = c.multiplier.vector.shape
    op, first, at, k = c.operators, dim * len(c.operators.x), c.edge.nodes, c.edge.neighbours
    j = np.flatnonzero(c.active)
    blocks = f.traction + np.einsum("ji,jk->jik", f.pressure, op.normals.n)
    tied = np.einsum("ji,jk->jik", f.edge_pressure, op.normals.n[k])
    plane = np.eye(dim) - np.einsum("ji,jk->jik", op.normals.n[k], op.normals.n[k])
    tied += f.edge_traction @ plane
    row, other, value = Sparse.of(op.M).triplets()
    moved = c.active[row]
    forces = -value[moved, None, None] * np.eye(dim)
    keep = c.active[k]
    triplets = [
        on_blocks(first, dim, j, j, blocks[j]),
        on_blocks(first, dim, at[keep], k[keep], tied[keep]),
        on_blocks(0, dim, other[moved], row[moved], forces),
    ]
    rows, columns, values = joined(triplets)
    filled = values != 0.0
    kept = rows[filled], columns[filled], values[filled]
    return Sparse.of_triplets(kept, (first + dim * n, dim * n))


def _by_normals(c: ContactState, f: _Factors, first: int, mine: Bools) -> list[Triplets]:
    """Through the normals at fixed λ and w: dp = λ·dn, P dt = -p dn and P ds = -(w·n) dn / D⁰."""
    dim, n = c.multiplier.vector.shape[1], c.operators.normals.n
    p, vector, k = c.multiplier.pressure, c.multiplier.vector, c.edge.neighbours
    j = np.flatnonzero(mine & c.active)
    across = np.einsum("ji,ji->j", c.motion.w, n)
    turned = np.divide(across, c.history.D, out=np.zeros_like(across), where=c.motion.known)
    own = np.einsum("ji,jk->jik", f.pressure, vector)
    own -= p[:, None, None] * f.traction + turned[:, None, None] * f.slip
    tied = np.einsum("mi,mk->mik", f.edge_pressure, vector[k]) - p[k, None, None] * f.edge_traction
    at = np.flatnonzero((mine & c.active)[c.edge.nodes])
    return [
        _on_normals(c.operators.normals, dim, first, j, j, own[j]),
        _on_normals(c.operators.normals, dim, first, c.edge.nodes[at], k[at], tied[at]),
    ]


def _on_normals(
    normals: NormalField, dim: int, first: int, rows: Ints, nodes: Ints, blocks: Floats
) -> Triplets:
    """Entries of rows that act on the normals at nodes, by the positions around these."""
    width = normals.around.shape[1]
    by_around = blocks @ normals.blocks.reshape(-1, dim, width * dim)[nodes]
    row = first + dim * rows[:, None, None] + np.arange(dim)[:, None]
    column = dim * normals.around[nodes][:, :, None] + np.arange(dim)
    column = column.reshape(len(nodes), 1, width * dim)
    return (
        np.broadcast_to(row, by_around.shape).ravel(),
        np.broadcast_to(column, by_around.shape).ravel(),
        by_around.ravel(),
    )


def _by_history(c: ContactState, jump: Floats, first: int, mine: Bools) -> list[Triplets]:
    """Through w_j at fixed M: -Σ_l M⁰_jl (dx_l - dx_j), times the factors of the weighted jumps."""
    dim = jump.shape[1]
    row, column, value = Sparse.of(c.history.M).triplets()
    at = (mine & jump.any(axis=(1, 2)))[row]
    j, node, blocks = row[at], column[at], value[at, None, None] * jump[row[at]]
    return [on_blocks(first, dim, j, node, -blocks), on_blocks(first, dim, j, j, blocks)]


def _by_full(c: ContactState, change: Floats, first: int, mine: Bools) -> list[Triplets]:
    """Through the size of whole facets, in f = D / full; only where edge nodes are tied."""
    at = np.flatnonzero(mine & change.any(axis=1))
    if not change.any():
        return []
    n, dim = change.shape
    rows = (first + dim * at[:, None] + np.arange(dim)).ravel()
    values = -(c.operators.coverage[at, None] * change[at]).ravel()
    weights = Sparse.of_triplets((rows, np.repeat(at, dim), values), (first + dim * n, n))
    return [(weights @ c.operators.full_derivative).triplets()]
