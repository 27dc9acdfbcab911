"""Equilibrium with contact over displacements and multipliers (7).

The rows of u are equilibrium with the contact forces, R + Gᵀλ [N/m]. Those of λ_j are the contact
conditions n_j C_n + τ_j C_t of a node in contact, and λ_j = 0 of any other and of components that
are prescribed. Nothing is divided by D, so it need not be diagonal: standard multipliers need this
system. The unknown of a multiplier is λ_j / c_j, a length as u is, with c_j of `contact_scale`;
with its rows scaled to forces every block of the matrix has the size of Young's modulus.
"""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from petsc4py import PETSc

from contactfem.common.timers import Timers
from contactfem.common.typing import Bools, Floats, Ints
from contactfem.contact.state import ContactHistory, ContactState
from contactfem.contact.tangent import Tangent, linearise
from contactfem.laws.active_set import ActiveSet, Status
from contactfem.mechanics.bulk_system import System
from contactfem.mechanics.condensed import Condensed, Interface
from contactfem.mechanics.sparsity import Coupling, block_pattern


class Saddle(Condensed):
    """The saddle-point system of one load step; used as the condensed one is.

    Args:
        system: The bodies, with two multipliers per nonmortar node of every interface.
        interfaces: The interfaces; no node with a multiplier is on two of their surfaces.
        timers: Where time is booked.
    """

    def __init__(self, system: System, interfaces: Sequence[Interface], timers: Timers) -> None:
        super().__init__(system, interfaces, timers)
        counts = [interface.nodes.mesh.n_nonmortar for interface in self.interfaces]
        self._nodes = np.split(np.arange(sum(counts)), np.cumsum(counts)[:-1])
        numbers = system.numbering.multipliers.reshape(-1, 2)
        self._numbers = [numbers[nodes] for nodes in self._nodes]
        self._couplings = [
            _KeptCoupling(system, interface, numbers)
            for interface, numbers in zip(self.interfaces, self._numbers, strict=True)
        ]

    def evaluate(
        self,
        positions: Sequence[Floats],
        histories: Sequence[ContactHistory],
        starts: Sequence[ActiveSet | None],
        out: PETSc.Vec,
    ) -> list[ContactState]:
        """Contact conditions of the system's multipliers, and the residual; collective.

        Args:
            positions: Of the nodes of every interface [m].
            histories: Operators at the start of the step, per interface.
            starts: Status to start from, per interface; None for trial states.
            out: Holds the bulk residual, receives the whole one [N/m].

        Returns:
            The conditions of every interface.
        """
        out.copy(self.bulk)
        result = []
        unknowns = self.system.multipliers.reshape(-1, 2)
        for k, (interface, x) in enumerate(zip(self.interfaces, positions, strict=True)):
            contact, start = interface.contact, starts[k]
            operators = contact.operators(x)
            multiplier = contact.law.c[:, None] * unknowns[self._nodes[k]]
            if start is None:
                c = contact.conditions(operators, multiplier, histories[k])
            else:
                c = contact.imposed(operators, multiplier, histories[k], start)
            self._insert_rows(k, c, multiplier, out)
            result.append(c)
        return result

    def _insert_rows(self, k: int, c: ContactState, multiplier: Floats, out: PETSc.Vec) -> None:
        """Put the forces and conditions of an interface into this rank's part of the residual."""
        interface, normals = self.interfaces[k], c.operators.normals
        n_row, t_row, open_row = row_scales(interface, c)
        rows = (n_row * c.normal_row)[:, None] * normals.n
        rows += (t_row * c.tangential_row)[:, None] * normals.tangent
        rows = np.where(_conditioned(interface, c), rows, open_row[:, None] * multiplier)
        for numbers, values in (
            (interface.nodes.unknown, c.nodal_forces()),
            (self._numbers[k], rows),
        ):
            local = numbers - self.system.numbering.first
            mine = (numbers >= 0) & (local >= 0) & (local < self.system.numbering.n_local)
            np.add.at(out.array, local[mine], values[mine])

    def fill(
        self, conditions: Sequence[ContactState], jumps: Sequence[Floats | None]
    ) -> list[Tangent]:
        """Assemble the tangent into `matrix`; collective, after `prepare`.

        Args:
            conditions: Of every interface.
            jumps: Jumps of prescribed motions that the bulk has not followed yet.

        Returns:
            The tangents of the interfaces.
        """
        A = self.tangent()
        with self.timers.book("assembly"):
            self._fill_bulk(A, jumps)
        tangents = []
        with self.timers.book("contact.tangent"):
            for k, c in enumerate(conditions):
                tangents.append(linearise(self.interfaces[k].contact, c))
                rows, values = self._kept_rows(k, c, tangents[-1])
                csr = (values.indptr.astype(np.int32), values.indices.astype(np.int32))
                A.setValuesIJV(*csr, values.data, addv=True, rowmap=rows.astype(np.int32))
            A.assemble()
        return tangents

    def _kept_rows(self, k: int, c: ContactState, tangent: Tangent) -> tuple[Ints, sp.csr_matrix]:
        """What this rank adds to the bulk tangent: global rows and values (rows, n_global)."""
        interface, n_global = self.interfaces[k], self.system.numbering.n_global
        n, n_nodes = interface.nodes.mesh.n_nonmortar, len(interface.nodes.X)
        unknown, numbers = interface.nodes.unknown.ravel(), self._numbers[k].ravel()
        scales = row_scales(interface, c)
        scaled = _scaled_rows(interface, c, scales)
        # D_jj λ_j on nonmortar nodes, beside the -Σ_j M_jl λ_j that the tangent has
        each = np.arange(2 * n)
        on_nodes = sp.csr_matrix((c.multiplier.ravel(), (each, each // 2)), (scaled.shape[0], n))
        D_by_position = tangent.D_by_position.scipy()
        by_position = scaled @ tangent.by_position.scipy() + on_nodes @ D_by_position
        result = _placed(by_position, unknown, n_global)
        free = _conditioned(interface, c).ravel()
        if self.system.comm.rank == 0:  # these are whole on every rank
            closed = np.where(np.repeat(c.active, 2), np.repeat(c.operators.D, 2), 0.0)
            D = sp.csr_matrix((closed, (each, each)), (scaled.shape[0], 2 * n))
            idle = np.where(free, 0.0, np.repeat(scales[2], 2))
            last = sp.csr_matrix((idle, (2 * n_nodes + each, each)), D.shape)
            unit = sp.diags(np.repeat(interface.contact.law.c, 2))
            by_multiplier = (scaled @ tangent.by_multiplier.scipy() + D + last) @ unit
            result = result + _placed(by_multiplier, numbers, n_global)
        targets = np.concatenate((unknown, numbers))
        keep = np.flatnonzero((targets >= 0) & (np.diff(result.indptr) > 0))
        return targets[keep], result[keep].tocsr()


class _KeptCoupling(Coupling):
    """Sticky sparsity pattern of one interface whose multipliers are unknowns."""

    def __init__(self, system: System, interface: Interface, numbers: Ints) -> None:
        super().__init__(system, interface.nodes)
        shape = (len(numbers), system.numbering.n_global)
        node = np.repeat(np.arange(len(numbers)), 2)
        ones = np.ones(numbers.size, np.int32)
        self._to_multiplier = sp.csr_matrix((ones, (node, numbers.ravel())), shape)

    def pattern(self) -> sp.csr_matrix:
        """Entries that contact may fill in this rank's rows, (n_local, n_global)."""
        rows, columns = self.reach()
        to_unknown = self._to_unknown()
        touched = rows @ to_unknown + self._to_multiplier
        across = columns @ to_unknown + self._nonmortar @ self._to_multiplier
        return block_pattern(self._system, touched, across)


def row_scales(interface: Interface, c: ContactState) -> tuple[Floats, Floats, Floats]:
    """Factors that make forces [N/m] of the rows of multipliers.

    Of C_n [m]; of C_t, [m] or [Pa]; of an open node's λ [Pa]. Lengths are scaled by the softer
    modulus, and down where a compliance, of a penalty or of the rim rule, multiplies unknowns by
    κ c; tractions by half the length of the facets, not by D, which may vanish. Newton's step
    does not depend on them.

    Args:
        interface: The interface.
        c: Its conditions.

    Returns:
        The three factors, (n_nonmortar,) each.
    """
    law, full = interface.contact.law, c.operators.full
    stiffness = law.stiffness * c.operators.depth
    normal = stiffness / (1.0 + (c.kappa + law.normal_compliance) * law.c)
    stick = stiffness / (1.0 + (c.kappa + law.tangential_compliance) * law.c)
    return np.asarray(normal), np.where(c.status == Status.STICK, stick, full), full


def _conditioned(interface: Interface, c: ContactState) -> Bools:
    """Components of multipliers that stand in contact conditions, (n_nonmortar, 2)."""
    return np.asarray(c.active[:, None] & interface.nodes.mesh.free[: len(c.active)])


def _scaled_rows(
    interface: Interface, c: ContactState, scales: tuple[Floats, Floats, Floats]
) -> sp.csr_matrix:
    """Conditions (C_n, C_t) of node j to its rows n_j C_n + τ_j C_t, scaled; forces stay."""
    normals, forces = c.operators.normals, 2 * len(interface.nodes.X)
    factors = np.stack((scales[0][:, None] * normals.n, scales[1][:, None] * normals.tangent), 2)
    factors *= _conditioned(interface, c)[:, :, None]
    n = len(factors)
    blocks = sp.bsr_matrix((factors, np.arange(n), np.arange(n + 1)), (2 * n, 2 * n))
    return sp.block_diag((sp.eye(forces), blocks), format="csr")


def _placed(matrix: sp.csr_matrix, numbers: Ints, n_global: int) -> sp.csr_matrix:
    """A matrix with its columns at global numbers; those with a negative one are dropped."""
    entries = matrix.tocoo()
    at = numbers[entries.col] >= 0
    place = (entries.row[at], numbers[entries.col[at]])
    return sp.coo_matrix((entries.data[at], place), (matrix.shape[0], n_global)).tocsr()
