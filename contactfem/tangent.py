"""Exact tangent of the contact conditions and of the contact forces of one interface."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from contactfem.contact import Conditions, Contact, relative_motion
from contactfem.laws import Status
from contactfem.mortar import D_ENTRY, GAP_ENTRY, Mortar, assemble
from contactfem.segments import cut
from contactfem.surfaces import Bools, Floats, Ints

Triplets = tuple[Ints, Ints, Floats]
Part = tuple[list[Triplets], sp.csr_matrix]  # weights of some quantities, and their derivative


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
    n, n_nodes = mesh.n_nonmortar, mesh.n_nodes
    entries = _entries(contact, conditions)
    assert entries.derivative is not None
    mine = np.arange(n) % contact.comm.size == contact.comm.rank
    parts = [
        _by_entries(contact, conditions, entries),
        *_nodal_parts(contact, conditions, mine & conditions.active),
    ]
    first, size = 2 * (n_nodes + n), 3 * n + 2 * n_nodes
    is_D = np.flatnonzero(entries.col == D_ENTRY)
    parts[0][0].append((first + entries.row[is_D], is_D, np.ones(len(is_D))))
    rows = _product([part for part in parts if part[0]], (size, 2 * n_nodes))
    return Tangent(_by_multiplier(contact, conditions), rows[:first], rows[first:])


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
    rows, cols, values = _joined(triplets)
    keep = c.active[cols // 2]
    return sp.coo_matrix((values[keep], (rows[keep], cols[keep])), (first + 2 * n, 2 * n)).tocsr()


def _by_entries(contact: Contact, c: Conditions, entries: Mortar) -> Part:
    """Derivative of all rows with respect to the entries of D, M and g at fixed λ and positions."""
    n_nodes = contact.mesh.n_nodes
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
    return triplets, entries.derivative


def _nodal_parts(contact: Contact, c: Conditions, mine: Bools) -> list[Part]:
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
            _row(first + 2 * j, j, (c.kappa + a_n)[j, None] * c.multiplier[j]),
            _row(first + 2 * j, rim[j], -c.kappa[j, None] * c.multiplier[rim[j]]),
            _row(first + 2 * stick + 1, stick, -(c.kappa + a_t)[stick, None] * turned[stick]),
            _row(first + 2 * stick + 1, rim[stick], c.kappa[stick, None] * turned[rim[stick]]),
            _row(first + 2 * slip + 1, slip,
                 turned[slip]
                 - (c.limit.by_pressure * c.direction)[slip, None] * c.multiplier[slip]),
            _row(first + 2 * moved + 1, moved, (by_slip[:, None] * _slip_by_normal(c))[moved]),
    ]  # fmt: skip
    p, t = c.pressure - c.pressure[rim], c.rim_traction
    by_full = -c.kappa_slope * op.cover / op.full
    parts: list[Part] = [
        (through_normals, op.normals.derivative),
        (_slip_by_position(contact, c, moved), sp.eye(2 * n_nodes, format="csr")),
    ]
    if by_full.any():  # only where the rim rule acts
        through_lengths = [
            (first + 2 * j, j, (p * by_full)[j]),
            (first + 2 * stick + 1, stick, (-t * by_full)[stick]),
        ]
        parts.append((through_lengths, op.full_derivative))
    return parts


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


def _slip_by_position(contact: Contact, c: Conditions, moved: Ints) -> list[Triplets]:
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
    return [_row(rows, col, value), _row(rows, row, -value)]


def _row(rows: Ints, nodes: Ints, values: Floats) -> Triplets:
    """Triplets of rows that act on the two components of nodes."""
    return (
        np.repeat(rows, 2),
        (2 * nodes[:, None] + np.arange(2)).ravel(),
        np.asarray(values).ravel(),
    )


def _joined(triplets: list[Triplets]) -> Triplets:
    rows, cols, values = (np.concatenate(parts) for parts in zip(*triplets, strict=True))
    return rows, cols, values


def _product(parts: list[Part], shape: tuple[int, int]) -> sp.csr_matrix:
    """Σ W_k D_k over parts, as the one product (W_1, W_2, ...) (D_1; D_2; ...)."""
    heights = [derivative.shape[0] for _, derivative in parts]
    starts = np.cumsum([0, *heights])
    shifted = []
    for (triplets, _), start in zip(parts, starts, strict=False):
        rows, cols, values = _joined(triplets)
        shifted.append((rows, cols + start, values))
    rows, cols, values = _joined(shifted)
    weights = sp.coo_matrix((values, (rows, cols)), (shape[0], starts[-1])).tocsr()
    return weights @ _stacked([derivative for _, derivative in parts])


def _stacked(matrices: list[sp.csr_matrix]) -> sp.csr_matrix:
    """Matrices below each other."""
    ends = np.cumsum([0, *(m.nnz for m in matrices)])
    indptr = [m.indptr[1:] + end for m, end in zip(matrices, ends, strict=False)]
    data, indices = (
        np.concatenate([getattr(m, name) for m in matrices]) for name in ("data", "indices")
    )
    shape = (sum(m.shape[0] for m in matrices), matrices[0].shape[1])
    return sp.csr_matrix((data, indices, np.concatenate(([0], *indptr))), shape)
