"""Equilibrium with contact, multipliers eliminated: residual and tangent over the displacements.

D is diagonal, so λ_j = -R_j / D_jj (8)/(11) with R = f_int - f_ext. The forces of nonmortar nodes
in contact move to the mortar rows, R_l + Σ_j (M_jl / D_jj) R_j, and their own rows become
n_j C_n + τ_j C_t, the normal and tangential contact conditions, scaled to forces [N/m].
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from petsc4py import PETSc

from contactfem.common.timers import Timers
from contactfem.common.typing import Floats, Ints
from contactfem.contact.conditions import Contact
from contactfem.contact.state import ContactHistory, ContactState
from contactfem.contact.tangent import Tangent, linearise
from contactfem.laws.active_set import ActiveSet, Status
from contactfem.mechanics.bulk_system import System
from contactfem.mechanics.interface_nodes import InterfaceNodes
from contactfem.mechanics.sparsity import Coupling
from contactfem.mortar.sparse import Sparse, Triplets, joined


@dataclass(frozen=True)
class Interface:
    """One interface of the system."""

    name: str
    nodes: InterfaceNodes
    contact: Contact


class Condensed:
    """The condensed system of one load step.

    Args:
        system: The bodies.
        interfaces: The interfaces; no node with a multiplier is on two of their surfaces.
        timers: Where time is booked.
    """

    def __init__(self, system: System, interfaces: Sequence[Interface], timers: Timers) -> None:
        self.system, self.interfaces, self.timers = system, tuple(interfaces), timers
        self.bulk = system.x.duplicate()
        self.matrix: PETSc.Mat | None = None
        self._bulk_matrix: PETSc.Mat | None = None
        self._couplings = [Coupling(system, interface.nodes) for interface in self.interfaces]

    def evaluate(
        self,
        positions: Sequence[Floats],
        histories: Sequence[ContactHistory],
        starts: Sequence[ActiveSet | None],
        out: PETSc.Vec,
    ) -> list[ContactState]:
        """Contact conditions and the condensed residual from the bulk residual; collective.

        Args:
            positions: Of the nodes of every interface [m].
            histories: Operators at the start of the step, per interface.
            starts: Status to start from, per interface; None for trial states.
            out: Holds the bulk residual, receives the condensed one [N/m].

        Returns:
            The conditions of every interface.
        """
        out.copy(self.bulk)
        result = []
        for k, (interface, x) in enumerate(zip(self.interfaces, positions, strict=True)):
            operators = interface.contact.operators(x)
            force = interface.nodes.gather(self.bulk.array_r, self.system.numbering.first)
            covered = operators.D > 0.0
            multiplier = -force / np.where(covered, operators.D, np.inf)[:, None]
            start = starts[k]
            if start is None:
                c = interface.contact.conditions(operators, multiplier, histories[k])
            else:
                c = interface.contact.imposed(operators, multiplier, histories[k], start)
            result.append(c)
        for interface, c in zip(self.interfaces, result, strict=True):
            self._insert(interface, c, out)
        return result

    def _insert(self, interface: Interface, c: ContactState, out: PETSc.Vec) -> None:
        """Put the rows of an interface into this rank's part of the residual."""
        unknown, n = interface.nodes.unknown, interface.nodes.mesh.n_nonmortar
        n_row, t_row = row_scales(interface, c)
        normals = c.operators.normals
        rows = (n_row * c.normal_row)[:, None] * normals.n
        rows += (t_row * c.tangential_row)[:, None] * normals.tangent
        local = unknown - self.system.numbering.first
        array = out.array
        mine = (local >= 0) & (local < len(array)) & (unknown >= 0)
        replaced = mine[:n] & c.active[:, None] & interface.nodes.mesh.free[:n]
        array[local[:n][replaced]] = rows[replaced]
        force = -(c.operators.M.T @ c.multiplier)
        np.add.at(array, local[mine], force[mine])

    def prepare(self, conditions: Sequence[ContactState]) -> bool:
        """Make room in the matrices for the present contact.

        Args:
            conditions: Of every interface.

        Returns:
            Whether the matrices are new.
        """
        grown = self.matrix is None
        for coupling, c in zip(self._couplings, conditions, strict=True):
            grown |= coupling.include(c.operators.M + c.history.M, c.active)
        if grown:
            pattern = self.system.pattern
            for coupling in self._couplings:
                pattern = pattern + coupling.pattern()
            for old in (self.matrix, self._bulk_matrix):
                if old is not None:
                    old.destroy()
            self.matrix = self.system.create_matrix(pattern)
            self._bulk_matrix = None
        return grown

    def fill(
        self, conditions: Sequence[ContactState], jumps: Sequence[Floats | None]
    ) -> list[Tangent]:
        """Assemble the condensed tangent into `matrix`; collective, after `prepare`.

        Args:
            conditions: Of every interface.
            jumps: Jumps of prescribed motions that the bulk has not followed yet.

        Returns:
            The tangents of the interfaces.
        """
        A = self.tangent()
        with self.timers.book("assembly"):
            self._fill_bulk(A, jumps)
        with self.timers.book("contact.tangent"):
            tangents = [
                linearise(interface.contact, c)
                for interface, c in zip(self.interfaces, conditions, strict=True)
            ]
        with self.timers.book("contact.elimination"):
            parts = [
                self._rows(A, interface, c, tangent)
                for interface, c, tangent in zip(self.interfaces, conditions, tangents, strict=True)
            ]
            cleared = [p[0] for p in parts] or [np.empty(0, np.int64)]
            A.zeroRows(np.concatenate(cleared).astype(np.int32), diag=0.0)
            for _, rows, values in parts:
                csr = (values.indptr.astype(np.int32), values.indices.astype(np.int32))
                A.setValuesIJV(*csr, values.data, addv=True, rowmap=rows.astype(np.int32))
            A.assemble()
        return tangents

    def tangent(self) -> PETSc.Mat:
        """The matrix that `prepare` made room in."""
        if self.matrix is None:
            raise RuntimeError("prepare comes before the tangent")
        return self.matrix

    def _fill_bulk(self, A: PETSc.Mat, jumps: Sequence[Floats | None]) -> None:
        """Bulk tangent; where it does not depend on the state it is assembled once."""
        if not self.system.is_linear:
            self.system.assemble(A, jumps)
            return
        if self._bulk_matrix is None:
            self._bulk_matrix = A.duplicate()
            self.system.assemble(self._bulk_matrix, jumps)
        self._bulk_matrix.copy(A, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)

    def _rows(
        self, A: PETSc.Mat, interface: Interface, c: ContactState, tangent: Tangent
    ) -> tuple[Ints, Ints, sp.csr_matrix]:
        """This rank's rows to clear, and what it adds: global rows and values (rows, n_global)."""
        numbering, unknown = self.system.numbering, interface.nodes.unknown.ravel()
        rows = contact_rows(interface, c, tangent)
        row, column, value = rows.by_position
        at = unknown[column] >= 0
        shape = (len(rows.targets), numbering.n_global)
        total = sp.coo_matrix((value[at], (row[at], unknown[column[at]])), shape).tocsr()
        local = rows.replaced - numbering.first
        mine = np.flatnonzero((local >= 0) & (local < numbering.n_local))
        stiffness = _rows_of(A, rows.replaced[mine], numbering.n_global)
        by_force = Sparse.of_triplets(rows.by_force, (len(rows.targets), len(local))).scipy()
        total = (total + by_force[:, mine] @ stiffness).tocsr()
        keep = np.flatnonzero((rows.targets >= 0) & (np.diff(total.indptr) > 0))
        return rows.replaced[mine], rows.targets[keep], total[keep]


@dataclass(frozen=True)
class ContactRows:
    """What contact makes of the bulk tangent K: some of its rows move, others come.

    Attributes:
        targets: Unknown of each row; negative where there is none, (rows,).
        replaced: Unknowns of nodes in contact whose own rows of K are taken away, (m,).
        by_force: Share of the taken rows that each row gets, d/dR [-], (rows, m).
        by_position: What is added, with respect to the positions, (rows, 2 n_nodes).
    """

    targets: Ints
    replaced: Ints
    by_force: Triplets
    by_position: Triplets


def contact_rows(interface: Interface, c: ContactState, tangent: Tangent) -> ContactRows:
    """Linearised forces and conditions of an interface with λ_j = -R_j / D_jj put in.

    dλ_j = -dR_j / D_jj - λ_j dD_jj / D_jj.

    Args:
        interface: The interface.
        c: Its conditions.
        tangent: Their tangent, this rank's part.

    Returns:
        The rows; `by_position` is this rank's part.
    """
    unknown, mesh = interface.nodes.unknown, interface.nodes.mesh
    n = mesh.n_nonmortar
    to_rows = _to_force_rows(interface, c)
    by_multiplier = to_rows @ tangent.by_multiplier
    D = np.where(c.operators.D > 0.0, c.operators.D, np.inf)
    ratio = (c.multiplier / D[:, None]).ravel()
    each = np.arange(2 * n + 1, dtype=np.int32)
    by_D = Sparse(each, each[:-1] // 2, -ratio, n)
    through_D = by_multiplier @ (by_D @ tangent.D_by_position)
    by_position = joined([(to_rows @ tangent.by_position).triplets(), through_D.triplets()])
    replaced = (mesh.free[:n] & c.active[:, None]).ravel()
    flat = unknown[:n].ravel()
    row, column, value = by_multiplier.triplets()
    taken = replaced[column]
    row, column, value = row[taken], column[taken], value[taken]
    by_force = row, (np.cumsum(replaced) - 1)[column], -value / D[column // 2]
    targets = np.concatenate((unknown.ravel(), np.where(replaced, flat, -1)))
    return ContactRows(targets, flat[replaced], by_force, by_position)


def _to_force_rows(interface: Interface, c: ContactState) -> Sparse:
    """Conditions (C_n, C_t) of node j to its rows n_j C_n + τ_j C_t, scaled; forces stay."""
    n_row, t_row = row_scales(interface, c)
    normals, n_nodes = c.operators.normals, len(interface.nodes.X)
    n = len(n_row)
    scaled = np.stack((n_row[:, None] * normals.n, t_row[:, None] * normals.tangent), axis=2)
    forces = np.arange(2 * n_nodes)
    pairs = np.repeat(2 * n_nodes + 2 * np.arange(n), 4).reshape(n, 2, 2) + np.arange(2)
    values = np.concatenate((np.ones(2 * n_nodes), scaled.ravel()))
    columns = np.concatenate((forces, pairs.ravel())).astype(np.int32)
    starts = np.concatenate((forces, 2 * n_nodes + 2 * np.arange(2 * n + 1))).astype(np.int32)
    return Sparse(starts, columns, values, 2 * (n_nodes + n))


def row_scales(interface: Interface, c: ContactState) -> tuple[Floats, Floats]:
    """Factors that make forces [N/m] (with an axis [N]) of C_n [m], and of C_t [m] or [Pa].

    Lengths are scaled by the softer modulus, and down where a compliance ties to p_j = -R_j / D_jj
    with a small D_jj; tractions by D_jj. Newton's step does not depend on them.

    Args:
        interface: The interface.
        c: Its conditions.

    Returns:
        Normal and tangential factors, (n_nonmortar,) each.
    """
    law = interface.contact.law
    E, D = law.stiffness * c.operators.depth, np.where(c.operators.D > 0.0, c.operators.D, 1.0)
    normal = E / (1.0 + (c.kappa + law.normal_compliance) * E / D)
    stick = E / (1.0 + (c.kappa + law.tangential_compliance) * E / D)
    return normal, np.where(c.status == Status.STICK, stick, D)


def _rows_of(A: PETSc.Mat, rows: Ints, n_cols: int) -> sp.csr_matrix:
    """Some of this rank's rows of an assembled matrix."""
    parts = [A.getRow(int(row)) for row in rows]
    indptr = np.concatenate(([0], np.cumsum([len(p[0]) for p in parts]))).astype(np.int64)
    indices = np.concatenate([p[0] for p in parts]) if parts else np.empty(0, np.int64)
    data = np.concatenate([p[1] for p in parts]) if parts else np.empty(0)
    return sp.csr_matrix((data, indices, indptr), (len(rows), n_cols))
