"""Exact tangent of the contact conditions and of the contact forces of one interface."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from contactfem.contact import Conditions, Contact, relative_motion
from contactfem.laws import Status
from contactfem.mortar import D_ENTRY, GAP_ENTRY, Mortar, assemble
from contactfem.segments import cut
from contactfem.surfaces import Bools, Floats, Ints


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

    by_multiplier: sp.csr_matrix
    by_position: sp.csr_matrix
    D_by_position: sp.csr_matrix


def linearise(contact: Contact, conditions: Conditions) -> Tangent:
    """Differentiate the contact forces and conditions at a state.

    Args:
        contact: The interface.
        conditions: The state.

    Returns:
        This rank's part of the tangent.
    """
    mesh = contact.mesh
    entries = _entries(contact, conditions)
    weights = _entry_weights(contact, conditions, entries)
    assert entries.derivative is not None
    by_position = weights @ entries.derivative
    mine = np.arange(mesh.n_nonmortar) % contact.comm.size == contact.comm.rank
    by_position += _nodal_part(contact, conditions, mine & conditions.active)
    D_rows = _select(entries, D_ENTRY, mesh.n_nonmortar) @ entries.derivative
    return Tangent(_by_multiplier(contact, conditions), by_position.tocsr(), D_rows.tocsr())


def _entries(contact: Contact, conditions: Conditions) -> Mortar:
    """Differentiated operators of this rank's facets with an active node."""
    mesh, operators = contact.mesh, conditions.operators
    needed = np.asarray(conditions.active[mesh.nonmortar].any(axis=1))
    pairs = operators.pairs[needed[operators.pairs[:, 0]]]
    segments = cut(mesh, operators.x, operators.normals.n, pairs, differentiate=True)
    return assemble(mesh, operators.x, segments, operators.normals)


def _by_multiplier(contact: Contact, c: Conditions) -> sp.csr_matrix:
    """Derivative of all rows with respect to the multipliers."""
    n, n_nodes = contact.mesh.n_nonmortar, contact.mesh.n_nodes
    normal, tangent = c.operators.normals.n, c.operators.normals.tangent
    j = np.flatnonzero(c.active)
    stick, slip = (np.flatnonzero(c.status == s) for s in (Status.STICK, Status.SLIP))
    a_n, a_t = contact.law.normal_compliance, contact.law.tangential_compliance
    first = 2 * n_nodes
    triplets = [
        _row(first + 2 * j, j, (c.kappa + a_n)[j, None] * normal[j]),
        _row(first + 2 * j, c.rim[j], -c.kappa[j, None] * normal[c.rim[j]]),
        _row(first + 2 * stick + 1, stick, -(c.kappa + a_t)[stick, None] * tangent[stick]),
        _row(first + 2 * stick + 1, c.rim[stick], c.kappa[stick, None] * tangent[c.rim[stick]]),
        _row(first + 2 * slip + 1, slip,
             tangent[slip] - (c.limit.by_pressure * c.direction)[slip, None] * normal[slip]),
    ]  # fmt: skip
    M = c.operators.M.tocoo()
    at = c.active[M.row]
    for k in (0, 1):
        triplets.append((2 * M.col[at] + k, 2 * M.row[at] + k, -M.data[at]))
    result = _matrix(triplets, (first + 2 * n, 2 * n))
    closed = np.repeat(c.active, 2).astype(float)
    return (result @ sp.diags(closed)).tocsr()


def _entry_weights(contact: Contact, c: Conditions, entries: Mortar) -> sp.csr_matrix:
    """Derivative of all rows with respect to the entries of D, M and g at fixed λ and positions."""
    n_nodes, n = contact.mesh.n_nodes, contact.mesh.n_nonmortar
    op, history = c.operators, c.history
    j, e = entries.row, np.arange(len(entries.row))
    first = 2 * n_nodes
    p, t = c.pressure - c.pressure[c.rim], c.rim_traction
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
    return _matrix(triplets, (first + 2 * n, len(e)))


def _nodal_part(contact: Contact, c: Conditions, mine: Bools) -> sp.csr_matrix:
    """Derivatives of some nodes through normals, facet lengths and positions at fixed D, M, g."""
    n_nodes, n = contact.mesh.n_nodes, contact.mesh.n_nonmortar
    op = c.operators
    a_n, a_t = contact.law.normal_compliance, contact.law.tangential_compliance
    first, rim = 2 * n_nodes, c.rim
    j = np.flatnonzero(mine)
    stick = np.flatnonzero(mine & (c.status == Status.STICK))
    slip = np.flatnonzero(mine & (c.status == Status.SLIP))
    by_slip = _by_slip(c)
    moved = np.flatnonzero(mine & (by_slip != 0.0))
    turned = np.column_stack((-c.multiplier[:, 1], c.multiplier[:, 0]))  # λ·dτ = turned·dn
    shape = (first + 2 * n, 2 * n)
    through_normals = _matrix(
        [
            _row(first + 2 * j, j, (c.kappa + a_n)[j, None] * c.multiplier[j]),
            _row(first + 2 * j, rim[j], -c.kappa[j, None] * c.multiplier[rim[j]]),
            _row(first + 2 * stick + 1, stick, -(c.kappa + a_t)[stick, None] * turned[stick]),
            _row(first + 2 * stick + 1, rim[stick], c.kappa[stick, None] * turned[rim[stick]]),
            _row(first + 2 * slip + 1, slip,
                 turned[slip]
                 - (c.limit.by_pressure * c.direction)[slip, None] * c.multiplier[slip]),
            _row(first + 2 * moved + 1, moved, (by_slip[:, None] * _slip_by_normal(c))[moved]),
        ],
        shape,
    )  # fmt: skip
    p, t = c.pressure - c.pressure[rim], c.rim_traction
    by_full = -c.kappa_slope * op.cover / op.full
    through_lengths = _matrix(
        [
            (first + 2 * j, j, (p * by_full)[j]),
            (first + 2 * stick + 1, stick, (-t * by_full)[stick]),
        ],
        (first + 2 * n, n),
    )
    return (
        through_normals @ op.normals.derivative
        + through_lengths @ op.full_derivative
        + _slip_by_position(contact, c, moved)
    )


def _by_slip(c: Conditions) -> Floats:
    """Derivative of the tangential condition with respect to slip: 1 in stick, -σ db/ds in slip."""
    seen = c.history.D > 0.0
    by_speed = -c.direction * c.limit.by_speed * np.sign(c.slip) / c.history.dt
    return np.where(c.status == Status.STICK, 1.0, np.where(seen & c.active, by_speed, 0.0))


def _slip_by_normal(c: Conditions) -> Floats:
    """D s_j / d n_j at fixed w_j: w·dτ = (-w_y, w_x)·dn, over D⁰."""
    w = relative_motion(c.operators, c.history)
    D0 = np.where(c.history.D > 0.0, c.history.D, np.inf)
    return np.asarray(np.column_stack((-w[:, 1], w[:, 0])) / D0[:, None])


def _slip_by_position(contact: Contact, c: Conditions, moved: Ints) -> sp.csr_matrix:
    """Through s_j at fixed D, M, τ: τ_j·Σ_l (M_jl - M⁰_jl)(dx_l - dx_j) / D⁰, of some nodes."""
    n_nodes, n = contact.mesh.n_nodes, contact.mesh.n_nonmortar
    chosen = np.zeros(n, bool)
    chosen[moved] = True
    change = (c.operators.M - c.history.M).tocoo()
    at = chosen[change.row]
    row, col = change.row[at].astype(np.int64), change.col[at].astype(np.int64)
    tau = c.operators.normals.tangent[row]
    value = (change.data[at] * _by_slip(c)[row] / c.history.D[row])[:, None] * tau
    rows = 2 * n_nodes + 2 * row + 1
    return _matrix([_row(rows, col, value), _row(rows, row, -value)],
                   (2 * (n_nodes + n), 2 * n_nodes))  # fmt: skip


def _select(entries: Mortar, kind: int, n: int) -> sp.csr_matrix:
    """Sum of the entries of one kind at every nonmortar node, as a matrix (n, e)."""
    at = np.flatnonzero(entries.col == kind)
    return sp.csr_matrix((np.ones(len(at)), (entries.row[at], at)), (n, len(entries.row)))


def _row(rows: Ints, nodes: Ints, values: Floats) -> tuple[Ints, Ints, Floats]:
    """Triplets of rows that act on the two components of nodes."""
    return (
        np.repeat(rows, 2),
        (2 * nodes[:, None] + np.arange(2)).ravel(),
        np.asarray(values).ravel(),
    )


def _matrix(triplets: list[tuple[Ints, Ints, Floats]], shape: tuple[int, int]) -> sp.csr_matrix:
    rows, cols, values = (np.concatenate(parts) for parts in zip(*triplets, strict=True))
    return sp.coo_matrix((values, (rows, cols)), shape=shape).tocsr()
