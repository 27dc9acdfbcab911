"""Matrix of all stages of a heat step, factorised once."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import scipy.sparse as sp

from mpi4py import MPI
from petsc4py import PETSc

from contactfem.common.typing import Floats, Ints
from contactfem.fem.dof_numbering import Unknowns
from contactfem.fem.petsc_options import HEAT, configure
from contactfem.heat.body import HeatBody
from contactfem.heat.interface import HeatExchange, HeatInterface
from contactfem.heat.time_schemes import TimeScheme

Share = tuple[Floats, Sequence[HeatExchange]]  # at the points of the scheme, and of what
SOLVER = {
    "ksp_type": "preonly",
    "pc_factor_mat_solver_type": "mumps",
    "mat_mumps_icntl_7": "2",  # AMF, as for mechanics
    "mat_mumps_icntl_14": "60",
}


class StageMatrix:
    """Blocks rate_IJ M + dt (test trial)_IJ K of all stages I, J, an unknown's stages in a row.

    Args:
        unknowns: The unknown temperatures.
        bodies: The bodies.
        scheme: Time scheme.
        options: PETSc options, over the defaults.
    """

    def __init__(
        self,
        unknowns: Unknowns,
        bodies: Sequence[HeatBody],
        scheme: TimeScheme,
        options: Mapping[str, str],
    ) -> None:
        self._unknowns, self._bodies, self._scheme = unknowns, tuple(bodies), scheme
        n = unknowns.numbering
        self._pattern = sp.csr_matrix((n.n_local, n.n_global))
        self._keys: Ints = np.empty(0, np.int64)
        self._storage: Floats | None = None
        self._bulk: PETSc.Mat | None = None
        self._A: PETSc.Mat | None = None
        self._seen: tuple[list[Floats], list[Floats], float] | None = None
        s = len(scheme.nodes)
        size = (n.n_local * s, n.n_global * s)
        self._b = PETSc.Vec().createMPI(size, comm=unknowns.comm)
        self._x = self._b.duplicate()
        self._ksp = PETSc.KSP().create(unknowns.comm)
        kind = {"pc_type": "cholesky" if s == 1 else "lu"}  # one stage: symmetric
        configure(self._ksp, HEAT, SOLVER | kind | dict(options), "heat.petsc")
        self._ksp.setErrorIfNotConverged(True)
        self.size = 0.0

    def update(
        self, dt: float, interfaces: Sequence[HeatInterface], shares: Sequence[Share]
    ) -> None:
        """Make it the matrix of a step at the bodies' present displacement; collective.

        Args:
            dt: Length of the step [s].
            interfaces: The interfaces.
            shares: What they add, each with its share at the points of the scheme, (q,).
        """
        if self._stands(dt, shares):
            return
        coupling = [(share, self._coupling(interfaces, e)) for share, e in shares]
        self._make_room([part for _, part in coupling])
        assert self._A is not None
        self._A.setValuesCSR(*self._rows, self._blocks(dt, coupling))
        self._A.assemble()
        self._ksp.setOperators(self._A, self._A)
        self._ksp.setUp()
        diagonal = self._A.getDiagonal()
        self.size = float(diagonal.norm(PETSc.NormType.NORM_2))

    def forget(self) -> None:
        """Make it again the next time, whatever stands: its factorisation failed."""
        self._seen = None

    def vector(self, residuals: Sequence[Floats]) -> tuple[Floats, float]:
        """Residuals of all stages as one vector of this rank, and its norm; collective.

        Args:
            residuals: Of every stage's equation over this rank's unknowns, (n_local,) each.
        """
        flat = np.column_stack(residuals).ravel()
        square = self._unknowns.comm.allreduce(float(flat @ flat), MPI.SUM)
        return flat, float(np.sqrt(square))

    def solve(self, residual: Floats) -> list[Floats]:
        """Corrections of all stages, to be subtracted; collective.

        Args:
            residual: As `vector` gives it.

        Returns:
            One array per stage over this rank's unknowns, (n_local,) each [K].
        """
        self._b.array[:] = residual
        self._ksp.solve(self._b, self._x)
        stages = len(self._scheme.nodes)
        return list(self._x.array_r.reshape(-1, stages).T.copy())

    def _stands(self, dt: float, shares: Sequence[Share]) -> bool:
        """Whether nothing that it is made of has changed; collective."""
        exchanges = [e for _, part in shares for e in part]
        u = [body.u.x.array.copy() for body in self._bodies if body.deforms]
        coupling = [e.conduction.data for e in exchanges] + [
            e.conduction.indices.astype(np.float64) for e in exchanges
        ]
        now = (u, coupling, dt)
        same = self._seen is not None and all(
            len(a) == len(b) and all(np.array_equal(p, q) for p, q in zip(a, b, strict=True))
            for a, b in ((self._seen[0], u), (self._seen[1], coupling))
        )
        same = same and self._seen is not None and abs(self._seen[2] - dt) <= 1e-12 * dt
        same = bool(self._unknowns.comm.allreduce(same, MPI.LAND))
        if not same:
            self._seen = now
        return same

    def _coupling(
        self, interfaces: Sequence[HeatInterface], exchanges: Sequence[HeatExchange]
    ) -> sp.csr_matrix:
        """Conduction through all interfaces in this rank's rows, (n_local, n_global)."""
        n = self._unknowns.numbering
        total = sp.csr_matrix((n.n_local, n.n_global))
        for interface, exchange in zip(interfaces, exchanges, strict=True):
            unknown, entries = interface.nodes.unknown, exchange.conduction.tocoo()
            row, col = unknown[entries.row], unknown[entries.col]
            mine = (row >= n.first) & (row < n.first + n.n_local) & (col >= 0)
            places = (row[mine] - n.first, col[mine])
            total = total + sp.coo_matrix((entries.data[mine], places), total.shape).tocsr()
        total.sort_indices()
        return total

    def _make_room(self, couplings: Sequence[sp.csr_matrix]) -> None:
        """New matrices where the couplings leave the present pattern; collective."""
        ones = sp.csr_matrix(self._pattern.shape)
        for coupling in couplings:
            part = coupling.copy()
            part.data[:] = 1.0
            ones = ones + part
        ones.sort_indices()
        missing = np.setdiff1d(_keys(ones), self._keys, assume_unique=True)
        grown = self._A is None or len(missing) > 0
        if not self._unknowns.comm.allreduce(grown, MPI.LOR):
            return
        for old in (self._A, self._bulk):
            if old is not None:
                old.destroy()
        pattern = (self._unknowns.pattern + self._pattern + ones).tocsr()
        pattern.sort_indices()
        self._pattern, self._keys = pattern, _keys(pattern)
        pattern.data = np.arange(pattern.nnz, dtype=np.float64) + 1.0
        self._bulk = self._unknowns.create_matrix(pattern)
        self._storage = None
        n, s = self._unknowns.numbering, len(self._scheme.nodes)
        indptr, columns, self._entry, self._place = _blocked(pattern, s)
        self._rows = indptr.astype(np.int32), columns.astype(np.int32)
        size = (n.n_local * s, n.n_global * s)
        csr = (*self._rows, np.zeros(len(columns)))
        self._A = PETSc.Mat().createAIJ((size, size), csr=csr, comm=self._unknowns.comm)
        if s == 1:
            self._A.setOption(PETSc.Mat.Option.SPD, True)

    def _blocks(self, dt: float, couplings: Sequence[tuple[Floats, sp.csr_matrix]]) -> Floats:
        """Values of all stages' rows of this rank."""
        scheme = self._scheme
        by_stage = dt * (scheme.test @ scheme.trial)
        conduction = self._assembled([body.add_conduction for body in self._bodies])
        values = conduction[self._entry] * by_stage.ravel()[self._place]
        for share, coupling in couplings:
            weights = dt * ((scheme.test * share) @ scheme.trial)
            crossing = np.zeros_like(conduction)
            crossing[np.searchsorted(self._keys, _keys(coupling))] = coupling.data
            values += crossing[self._entry] * weights.ravel()[self._place]
        if not scheme.steady:
            if self._storage is None:
                self._storage = self._assembled([body.add_storage for body in self._bodies])
            values += self._storage[self._entry] * scheme.rate.ravel()[self._place]
        return np.asarray(values)

    def _assembled(self, adders: Sequence[Callable[[PETSc.Mat], None]]) -> Floats:
        """Entries of a bulk matrix in the order of the pattern; collective."""
        A = self._bulk
        assert A is not None
        A.zeroEntries()
        for add, lgmap in zip(adders, self._unknowns.maps, strict=True):
            A.setLGMap(lgmap, lgmap)
            add(A)
        A.assemble()
        return np.asarray(A.getValuesCSR()[2])


def _blocked(pattern: sp.csr_matrix, s: int) -> tuple[Ints, Ints, Ints, Ints]:
    """CSR pattern with a block of s x s in the place of every entry.

    Args:
        pattern: Sorted, (m, n).
        s: Stages.

    Returns:
        Starts of rows, columns; and of every entry the number of its old one and of its place in
        the block.
    """
    length = np.repeat(np.diff(pattern.indptr).astype(np.int64), s)  # of the new rows over s
    starts = np.concatenate(([0], np.cumsum(s * length)))
    first = np.repeat(np.repeat(pattern.indptr[:-1].astype(np.int64), s), length)
    within = np.arange(len(first)) - np.repeat(starts[:-1] // s, length)
    entry = np.repeat(first + within, s)
    trial = np.tile(np.arange(s), len(first))
    test = np.repeat(np.tile(np.arange(s), pattern.shape[0]), s * length)
    return starts, s * pattern.indices[entry].astype(np.int64) + trial, entry, s * test + trial


def _keys(matrix: sp.csr_matrix) -> Ints:
    """Places of a matrix's entries as ascending numbers."""
    place = matrix.tocoo()
    return np.asarray(place.row.astype(np.int64) * matrix.shape[1] + place.col)
