"""Equilibrium with contact, multipliers eliminated: residual and tangent over the displacements.

D is diagonal, so λ_j = -R_j / D_jj (8)/(11) with R = f_int - f_ext. The forces of nonmortar nodes
in contact move to the mortar rows, R_l + Σ_j (M_jl / D_jj) R_j, and their own rows become
α_n n_j C_n + α_t C_t, the normal and tangential contact conditions, scaled to forces.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from petsc4py import PETSc

from contactfem.common.timers import Timers
from contactfem.common.typing import Floats, Ints
from contactfem.contact.state import ContactHistory, ContactState
from contactfem.contact.tangent import RowScales, Tangent, condition_rows, linearise
from contactfem.laws.active_set import ActiveSet, Status
from contactfem.mechanics.bulk_system import System
from contactfem.mechanics.contact_equations import Interface
from contactfem.mechanics.sparsity import Coupling
from contactfem.mechanics.system_matrix import SystemMatrix
from contactfem.mortar.sparse import Sparse, Triplets, joined


class Condensed:
    """The condensed system of one load step.

    Args:
        system: The bodies.
        interfaces: The interfaces; no node with a multiplier is on two of their surfaces.
        timers: Where time is booked.
    """

    def __init__(self, system: System, interfaces: Sequence[Interface], timers: Timers) -> None:
        self.system, self.interfaces, self.timers = system, tuple(interfaces), timers
        self.eliminates_multipliers = True
        couplings = [Coupling(system, interface.nodes) for interface in self.interfaces]
        self._matrix = SystemMatrix(system, couplings)

    def evaluate(
        self,
        positions: Sequence[Floats],
        histories: Sequence[ContactHistory],
        starts: Sequence[ActiveSet | None],
        bulk: PETSc.Vec,
        out: PETSc.Vec,
    ) -> list[ContactState]:
        """As said of every `ContactEquations`."""
        bulk.copy(out)
        result = []
        for k, (interface, x) in enumerate(zip(self.interfaces, positions, strict=True)):
            operators = interface.contact.operators(x)
            force = interface.nodes.gather(bulk.array_r, self.system.numbering.first)
            covered = operators.D > 0.0
            multiplier = -force / np.where(covered, operators.D, np.inf)[:, None]
            result.append(interface.contact.state(operators, multiplier, histories[k], starts[k]))
        for interface, c in zip(self.interfaces, result, strict=True):
            self._insert(interface, c, out)
        return result

    def _insert(self, interface: Interface, c: ContactState, out: PETSc.Vec) -> None:
        """Put the rows of an interface into this rank's part of the residual."""
        unknown, n = interface.nodes.unknown, interface.nodes.mesh.n_nonmortar
        rows = condition_rows(c, row_scales(interface, c))
        local = unknown - self.system.numbering.first
        array = out.array
        mine = (local >= 0) & (local < len(array)) & (unknown >= 0)
        replaced = mine[:n] & c.active[:, None] & interface.nodes.mesh.free[:n]
        array[local[:n][replaced]] = rows[replaced]
        force = -(c.operators.M.T @ c.multiplier.vector)
        np.add.at(array, local[mine], force[mine])

    def linearise(
        self, states: Sequence[ContactState], jumps: Sequence[Floats | None]
    ) -> PETSc.Mat:
        """As said of every `ContactEquations`."""
        with self.timers.book("contact.pattern"):
            A = self._matrix.with_room(states)
        with self.timers.book("assembly"):
            self._matrix.fill_bulk(A, jumps)
        with self.timers.book("contact.tangent"):
            tangents = [
                linearise(interface.contact, c, row_scales(interface, c))
                for interface, c in zip(self.interfaces, states, strict=True)
            ]
        with self.timers.book("contact.elimination"):
            parts = [
                self._rows(A, interface, c, tangent)
                for interface, c, tangent in zip(self.interfaces, states, tangents, strict=True)
            ]
            cleared = [p[0] for p in parts] or [np.empty(0, np.int64)]
            A.zeroRows(np.concatenate(cleared).astype(np.int32), diag=0.0)
            for _, rows, values in parts:
                csr = (values.indptr.astype(np.int32), values.indices.astype(np.int32))
                A.setValuesIJV(*csr, values.data, addv=True, rowmap=rows.astype(np.int32))
            A.assemble()
        return A

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
        by_position: What is added, with respect to the positions, (rows, dim n_nodes).
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
    n, dim = mesh.n_nonmortar, mesh.dim
    by_multiplier = tangent.by_multiplier
    D = np.where(c.operators.D > 0.0, c.operators.D, np.inf)
    ratio = (c.multiplier.vector / D[:, None]).ravel()
    each = np.arange(dim * n + 1, dtype=np.int32)
    by_D = Sparse(each, each[:-1] // dim, -ratio, n)
    through_D = by_multiplier @ (by_D @ tangent.D_by_position)
    by_position = joined([tangent.by_position.triplets(), through_D.triplets()])
    replaced = (mesh.free[:n] & c.active[:, None]).ravel()
    flat = unknown[:n].ravel()
    row, column, value = by_multiplier.triplets()
    taken = replaced[column]
    row, column, value = row[taken], column[taken], value[taken]
    by_force = row, (np.cumsum(replaced) - 1)[column], -value / D[column // dim]
    targets = np.concatenate((unknown.ravel(), np.where(replaced, flat, -1)))
    return ContactRows(targets, flat[replaced], by_force, by_position)


def row_scales(interface: Interface, c: ContactState) -> RowScales:
    """Factors that make forces of C_n [m], and of C_t [m] or [Pa].

    Lengths are scaled by the softer modulus, and down where a compliance ties to p_j = -R_j / D_jj
    with a small D_jj; tractions by D_jj. Newton's step does not depend on them.

    Args:
        interface: The interface.
        c: Its contact state.
    """
    law, kappa = interface.contact.law, c.edge.compliance
    E, D = law.stiffness * c.operators.depth, np.where(c.operators.D > 0.0, c.operators.D, 1.0)
    normal = E / (1.0 + (kappa + law.normal_compliance) * E / D)
    stick = E / (1.0 + (kappa + law.tangential_compliance) * E / D)
    return RowScales(normal, np.where(c.status == Status.STICK, stick, D))


def _rows_of(A: PETSc.Mat, rows: Ints, n_cols: int) -> sp.csr_matrix:
    """Some of this rank's rows of an assembled matrix."""
    parts = [A.getRow(int(row)) for row in rows]
    indptr = np.concatenate(([0], np.cumsum([len(p[0]) for p in parts]))).astype(np.int64)
    indices = np.concatenate([p[0] for p in parts]) if parts else np.empty(0, np.int64)
    data = np.concatenate([p[1] for p in parts]) if parts else np.empty(0)
    return sp.csr_matrix((data, indices, indptr), (len(rows), n_cols))
