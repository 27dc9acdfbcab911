"""Exact tangent of contact conditions and contact forces."""

from dataclasses import dataclass

import numpy as np

from contactfem.common.typing import Bools, Floats, Ints
from contactfem.contact.conditions import Contact
from contactfem.contact.state import ContactState
from contactfem.laws.active_set import Status
from contactfem.mortar.normals import NormalField
from contactfem.mortar.operators import D_ENTRY, GAP_ENTRY, Mortar, assemble
from contactfem.mortar.segments import differentiated
from contactfem.mortar.sparse import Sparse, Triplets, joined


@dataclass(frozen=True)
class Tangent:
    """Linearisation of the forces on the nodes and of the conditions at the nonmortar nodes.

    Rows: first the mortar part of the contact forces, -Σ_j M_jl λ_j, 2 per node (n_nodes); then the
    normal and the tangential condition of every nonmortar node, 2 per node (n). The conditions are
    those of active nodes; all other rows are empty.

    Attributes:
        by_multiplier: With respect to λ, columns 2 per nonmortar node; the same on all ranks.
        by_position: With respect to the positions at fixed λ, columns 2 per node; the ranks' parts
            add up.
        D_by_position: d D_jj / dx of the active nodes, (n, 2 n_nodes); the ranks' parts add up.
    """

    by_multiplier: Sparse
    by_position: Sparse
    D_by_position: Sparse


def linearise(contact: Contact, conditions: ContactState) -> Tangent:
    """Differentiate the contact forces and conditions at a state.

    Args:
        contact: The interface.
        conditions: The state.

    Returns:
        This rank's part of the tangent.
    """
    mesh = contact.mesh
    n, n_nodes = mesh.n_nonmortar, mesh.n_nodes
    entries = _entries(contact, conditions)
    assert entries.derivative is not None
    mine = np.arange(n) % contact.comm.size == contact.comm.rank
    first, size = 2 * (n_nodes + n), 3 * n + 2 * n_nodes
    is_D = np.flatnonzero(entries.col == D_ENTRY)
    weights = _by_entries(contact, conditions, entries)
    weights.append((first + entries.row[is_D], is_D, np.ones(len(is_D))))
    by_entries = Sparse.of_triplets(joined(weights), (size, len(entries.row)))
    nodal = _by_nodes(contact, conditions, mine & conditions.active)
    triplets = joined([(by_entries @ entries.derivative).triplets(), *nodal])
    rows = Sparse.of_triplets(triplets, (size, 2 * n_nodes))
    by_multiplier = _by_multiplier(contact, conditions)
    return Tangent(by_multiplier, rows.part(0, first), rows.part(first, size))


def _entries(contact: Contact, conditions: ContactState) -> Mortar:
    """Differentiated operators of this rank's facets with an active node."""
    mesh, operators = contact.mesh, conditions.operators
    needed = np.asarray(conditions.active[mesh.nonmortar].any(axis=1))
    chosen = needed[operators.segments.facets[:, 0]]
    segments = differentiated(mesh, operators.x, operators.normals.n, operators.segments, chosen)
    return assemble(mesh, operators.x, segments, operators.normals)


def _by_multiplier(contact: Contact, c: ContactState) -> Sparse:
    """Derivative of all rows with respect to the multipliers."""
    n, n_nodes = contact.mesh.n_nonmortar, contact.mesh.n_nodes
    normal, tangent = c.operators.normals.n, c.operators.normals.tangent
    j = np.flatnonzero(c.active)
    stick, slip = (np.flatnonzero(c.status == s) for s in (Status.STICK, Status.SLIP))
    a_n, a_t = contact.law.normal_compliance, contact.law.tangential_compliance
    first = 2 * n_nodes
    vectors = [
        (first + 2 * j, j, (c.kappa + a_n)[j, None] * normal[j]),
        (first + 2 * j, c.rim[j], -c.kappa[j, None] * normal[c.rim[j]]),
        (first + 2 * stick + 1, stick, -(c.kappa + a_t)[stick, None] * tangent[stick]),
        (first + 2 * stick + 1, c.rim[stick], c.kappa[stick, None] * tangent[c.rim[stick]]),
        (first + 2 * slip + 1, slip,
             tangent[slip] - (c.limit.by_pressure * c.direction)[slip, None] * normal[slip]),
    ]  # fmt: skip
    rows, nodes, values = joined(vectors)
    triplets = [_on_components(rows, nodes, values)]
    j, other, value = Sparse.of(c.operators.M).triplets()
    at = c.active[j]
    for k in (0, 1):
        triplets.append((2 * other[at] + k, 2 * j[at] + k, -value[at]))
    rows, cols, values = joined(triplets)
    keep = c.active[cols // 2]
    kept = rows[keep], cols[keep], values[keep]
    return Sparse.of_triplets(kept, (first + 2 * n, 2 * n))


def _by_entries(contact: Contact, c: ContactState, entries: Mortar) -> list[Triplets]:
    """Derivative of all rows with respect to the entries of D, M and g at fixed λ and positions."""
    n_nodes = contact.mesh.n_nodes
    op, history = c.operators, c.history
    j, e = entries.row, np.arange(len(entries.row))
    first = 2 * n_nodes
    p, t = c.pressure - c.pressure[c.rim], c.edge_traction
    slope = c.kappa_slope / op.full
    active, stick = c.active[j], (c.status == Status.STICK)[j]
    is_D, is_gap, is_M = entries.col == D_ENTRY, entries.col == GAP_ENTRY, entries.col >= 0
    D = np.where(op.D > 0.0, op.D, 1.0)
    gap = np.where(c.active, op.gap, 0.0)
    D0 = np.where(history.D > 0.0, history.D, 1.0)
    triplets = []
    at = is_D & active
    triplets.append((first + 2 * j[at], e[at], (-gap / D + p * slope)[j[at]]))
    at = is_D & stick
    triplets.append((first + 2 * j[at] + 1, e[at], (-t * slope)[j[at]]))
    at = is_gap & active
    triplets.append((first + 2 * j[at], e[at], (1.0 / D)[j[at]]))
    by_slip = _by_slip(c)
    at = is_M & (by_slip != 0.0)[j]
    reach = op.x[entries.col[at]] - op.x[j[at]]
    along = np.einsum("ei,ei->e", op.normals.tangent[j[at]], reach)
    triplets.append((first + 2 * j[at] + 1, e[at], along * (by_slip / D0)[j[at]]))
    at = is_M & active
    for k in (0, 1):
        triplets.append((2 * entries.col[at] + k, e[at], -c.multiplier[j[at], k]))
    return triplets


def _by_nodes(contact: Contact, c: ContactState, mine: Bools) -> list[Triplets]:
    """Derivatives of some nodes through normals, facet lengths and positions at fixed D, M, g."""
    n_nodes, op = contact.mesh.n_nodes, c.operators
    a_n, a_t = contact.law.normal_compliance, contact.law.tangential_compliance
    first, rim = 2 * n_nodes, c.rim
    j = np.flatnonzero(mine)
    stick = np.flatnonzero(mine & (c.status == Status.STICK))
    slip = np.flatnonzero(mine & (c.status == Status.SLIP))
    by_slip = _by_slip(c)
    moved = np.flatnonzero(mine & (by_slip != 0.0))
    turned = np.column_stack((-c.multiplier[:, 1], c.multiplier[:, 0]))  # λ·dτ = turned·dn
    through_normals = [
        (first + 2 * j, j, (c.kappa + a_n)[j, None] * c.multiplier[j]),
        (first + 2 * j, rim[j], -c.kappa[j, None] * c.multiplier[rim[j]]),
        (first + 2 * stick + 1, stick, -(c.kappa + a_t)[stick, None] * turned[stick]),
        (first + 2 * stick + 1, rim[stick], c.kappa[stick, None] * turned[rim[stick]]),
        (first + 2 * slip + 1, slip,
         turned[slip] - (c.limit.by_pressure * c.direction)[slip, None] * c.multiplier[slip]),
        (first + 2 * moved + 1, moved, (by_slip[:, None] * _slip_by_normal(c))[moved]),
    ]  # fmt: skip
    parts = [
        _on_normals(op.normals, *joined(through_normals)),
        _slip_by_position(contact, c, moved),
    ]
    p, t = c.pressure - c.pressure[rim], c.edge_traction
    by_full = -c.kappa_slope * op.coverage / op.full
    if by_full.any():  # only where the rim rule acts
        through_lengths = joined(
            [
                (first + 2 * j, j, (p * by_full)[j]),
                (first + 2 * stick + 1, stick, (-t * by_full)[stick]),
            ]
        )
        weights = Sparse.of_triplets(through_lengths, (first + 2 * len(rim), len(rim)))
        parts.append((weights @ op.full_derivative).triplets())
    return parts


def _by_slip(c: ContactState) -> Floats:
    """Derivative of the tangential condition with respect to slip: 1 in stick, -σ db/ds in slip."""
    seen = c.history.D > 0.0
    by_speed = -c.direction * c.limit.by_speed * np.sign(c.slip) / c.history.dt
    return np.where(c.status == Status.STICK, 1.0, np.where(seen & c.active, by_speed, 0.0))


def _slip_by_normal(c: ContactState) -> Floats:
    """D s_j / d n_j at fixed w_j: w·dτ = (-w_y, w_x)·dn, over D⁰."""
    w = c.motion.w
    D0 = np.where(c.history.D > 0.0, c.history.D, np.inf)
    return np.asarray(np.column_stack((-w[:, 1], w[:, 0])) / D0[:, None])


def _slip_by_position(contact: Contact, c: ContactState, moved: Ints) -> Triplets:
    """Through s_j at fixed D, M, τ: τ_j·Σ_l (M_jl - M⁰_jl)(dx_l - dx_j) / D⁰, of some nodes."""
    chosen = np.zeros(contact.mesh.n_nonmortar, bool)
    chosen[moved] = True
    row, col, change = (part[chosen[c.motion.change[0]]] for part in c.motion.change)
    tau = c.operators.normals.tangent[row]
    value = (change * _by_slip(c)[row] / c.history.D[row])[:, None] * tau
    rows = 2 * contact.mesh.n_nodes + 2 * row + 1
    return _on_components(*joined([(rows, col, value), (rows, row, -value)]))


def _on_components(rows: Ints, nodes: Ints, values: Floats) -> Triplets:
    """Triplets of rows that act on the two components of nodes, (k, 2)."""
    return (
        np.repeat(rows, 2),
        (2 * nodes[:, None] + np.arange(2)).ravel(),
        values.ravel(),
    )


def _on_normals(normals: NormalField, rows: Ints, nodes: Ints, values: Floats) -> Triplets:
    """Triplets of rows that act on the normals at nodes, (k, 2), by the positions around these."""
    by_around = np.einsum("ki,kij->kj", values, normals.blocks.reshape(-1, 2, 6)[nodes])
    around = 2 * normals.around[nodes][:, :, None] + np.arange(2)
    return np.repeat(rows, 6), around.ravel(), by_around.ravel()
