"""Equilibrium with contact over displacements and multipliers (7).

The rows of u are equilibrium with the contact forces, R + Gᵀλ [N/m]. Those of λ_j are the contact
conditions α_n n_j C_n + α_t C_t of a node in contact, and λ_j = 0 of any other and of components
that are prescribed. Nothing is divided by D, so it need not be diagonal: standard multipliers need
this system. The unknown of a multiplier is λ_j / c_j, a length as u is, with c_j of
`contact_scale`; with its rows scaled to forces every block of the matrix has the size of Young's
modulus.
"""

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from petsc4py import PETSc

from contactfem.common.timers import Timers
from contactfem.common.typing import Bools, Floats, Ints
from contactfem.contact.state import ContactHistory, ContactState
from contactfem.contact.tangent import RowScales, Tangent, condition_rows, linearise
from contactfem.laws.active_set import ActiveSet, Status
from contactfem.mechanics.bulk_system import System
from contactfem.mechanics.contact_equations import Interface
from contactfem.mechanics.sparsity import Coupling, block_pattern
from contactfem.mechanics.system_matrix import SystemMatrix


class Saddle:
    """The saddle-point system of one load step.

    Args:
        system: The bodies, with two multipliers per nonmortar node of every interface.
        interfaces: The interfaces; no node with a multiplier is on two of their surfaces.
        timers: Where time is booked.
    """

    def __init__(self, system: System, interfaces: Sequence[Interface], timers: Timers) -> None:
        self.system, self.interfaces, self.timers = system, tuple(interfaces), timers
        self.eliminates_multipliers = False
        counts = [interface.nodes.mesh.n_nonmortar for interface in self.interfaces]
        self._nodes = np.split(np.arange(sum(counts)), np.cumsum(counts)[:-1])
        numbers = system.numbering.multipliers.reshape(-1, system.dim)
        self._numbers = [numbers[nodes] for nodes in self._nodes]
        couplings = [
            _KeptCoupling(system, interface, numbers)
            for interface, numbers in zip(self.interfaces, self._numbers, strict=True)
        ]
        self._matrix = SystemMatrix(system, couplings)

    def evaluate(
        self,
        positions: Sequence[Floats],
        histories: Sequence[ContactHistory],
        starts: Sequence[ActiveSet | None],
        bulk: PETSc.Vec,
        out: PETSc.Vec,
    ) -> list[ContactState]:
        """As said of every `ContactEquations`, with the system's multipliers."""
        bulk.copy(out)
        result = []
        unknowns = self.system.multipliers.reshape(-1, self.system.dim)
        for k, (interface, x) in enumerate(zip(self.interfaces, positions, strict=True)):
            contact = interface.contact
            operators = contact.operators(x)
            multiplier = contact.law.c[:, None] * unknowns[self._nodes[k]]
            c = contact.state(operators, multiplier, histories[k], starts[k])
            self._insert_rows(k, c, multiplier, out)
            result.append(c)
        return result

    def _insert_rows(self, k: int, c: ContactState, multiplier: Floats, out: PETSc.Vec) -> None:
        """Put the forces and conditions of an interface into this rank's part of the residual."""
        interface = self.interfaces[k]
        rows = condition_rows(c, row_scales(interface, c))
        open_rows = c.operators.full[:, None] * multiplier
        rows = np.where(_conditioned(interface, c), rows, open_rows)
        for numbers, values in (
            (interface.nodes.unknown, c.nodal_forces()),
            (self._numbers[k], rows),
        ):
            local = numbers - self.system.numbering.first
            mine = (numbers >= 0) & (local >= 0) & (local < self.system.numbering.n_local)
            np.add.at(out.array, local[mine], values[mine])

    def linearise(
        self, states: Sequence[ContactState], jumps: Sequence[Floats | None]
    ) -> PETSc.Mat:
        """As said of every `ContactEquations`."""
        with self.timers.book("contact.pattern"):
            A = self._matrix.with_room(states)
        with self.timers.book("assembly"):
            self._matrix.fill_bulk(A, jumps)
        with self.timers.book("contact.tangent"):
            for k, (interface, c) in enumerate(zip(self.interfaces, states, strict=True)):
                tangent = linearise(interface.contact, c, row_scales(interface, c))
                rows, values = self._kept_rows(k, c, tangent)
                csr = (values.indptr.astype(np.int32), values.indices.astype(np.int32))
                A.setValuesIJV(*csr, values.data, addv=True, rowmap=rows.astype(np.int32))
            A.assemble()
        return A

    def _kept_rows(self, k: int, c: ContactState, tangent: Tangent) -> tuple[Ints, sp.csr_matrix]:
        """What this rank adds to the bulk tangent: global rows and values (rows, n_global)."""
        interface, n_global = self.interfaces[k], self.system.numbering.n_global
        mesh = interface.nodes.mesh
        n, n_nodes, dim = mesh.n_nonmortar, mesh.n_nodes, mesh.dim
        unknown, numbers = interface.nodes.unknown.ravel(), self._numbers[k].ravel()
        free = _conditioned(interface, c).ravel()
        scaled = sp.diags(np.concatenate((np.ones(dim * n_nodes), free)).astype(np.float64))
        # D_jj λ_j on nonmortar nodes, beside the -Σ_j M_jl λ_j that the tangent has
        each, height = np.arange(dim * n), dim * (n_nodes + n)
        shape = (height, n)
        on_nodes = sp.csr_matrix((c.multiplier.vector.ravel(), (each, each // dim)), shape)
        D_by_position = tangent.D_by_position.scipy()
        by_position = scaled @ tangent.by_position.scipy() + on_nodes @ D_by_position
        result = _placed(by_position, unknown, n_global)
        if self.system.comm.rank == 0:  # these are whole on every rank
            closed = np.where(np.repeat(c.active, dim), np.repeat(c.operators.D, dim), 0.0)
            D = sp.csr_matrix((closed, (each, each)), (height, dim * n))
            idle = np.where(free, 0.0, np.repeat(c.operators.full, dim))
            last = sp.csr_matrix((idle, (dim * n_nodes + each, each)), D.shape)
            unit = sp.diags(np.repeat(interface.contact.law.c, dim))
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
        node = np.repeat(np.arange(len(numbers)), numbers.shape[1])
        ones = np.ones(numbers.size, np.int32)
        self._to_multiplier = sp.csr_matrix((ones, (node, numbers.ravel())), shape)

    def pattern(self) -> sp.csr_matrix:
        """Entries that contact may fill in this rank's rows, (n_local, n_global)."""
        rows, columns = self.reach()
        to_unknown = self._to_unknown()
        touched = rows @ to_unknown + self._to_multiplier
        across = columns @ to_unknown + self._nonmortar @ self._to_multiplier
        return block_pattern(self._system, touched, across)


def row_scales(interface: Interface, c: ContactState) -> RowScales:
    """Factors that make forces of the conditions in the rows of multipliers.

    Of C_n [m]; of C_t, [m] or [Pa]. Lengths are scaled by the softer modulus, and down where a
    compliance, of a penalty or of edge nodes, multiplies unknowns by κ c; tractions, and λ of open
    nodes, by the area of whole facets, not by D, which may vanish. Newton's step does not depend on
    them.

    Args:
        interface: The interface.
        c: Its contact state.
    """
    law, full, kappa = interface.contact.law, c.operators.full, c.edge.compliance
    stiffness = law.stiffness * c.operators.depth
    normal = stiffness / (1.0 + (kappa + law.normal_compliance) * law.c)
    stick = stiffness / (1.0 + (kappa + law.tangential_compliance) * law.c)
    return RowScales(np.asarray(normal), np.where(c.status == Status.STICK, stick, full))


def _conditioned(interface: Interface, c: ContactState) -> Bools:
    """Components of multipliers that stand in contact conditions, (n_nonmortar, dim)."""
    return np.asarray(c.active[:, None] & interface.nodes.mesh.free[: len(c.active)])


def _placed(matrix: sp.csr_matrix, numbers: Ints, n_global: int) -> sp.csr_matrix:
    """A matrix with its columns at global numbers; those with a negative one are dropped."""
    entries = matrix.tocoo()
    at = numbers[entries.col] >= 0
    place = (entries.row[at], numbers[entries.col[at]])
    return sp.coo_matrix((entries.data[at], place), (matrix.shape[0], n_global)).tocsr()
