"""One system of equations for several bodies: numbering, vectors and matrix.

Every scalar dof of every body has a global number, -1 where its motion is prescribed; the dofs of a
grip's free component share one number. Assembly through these maps drops and ties by itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from dolfinx import la

from mpi4py import MPI
from petsc4py import PETSc

from contactfem.errors import CaseError
from contactfem.mechanics import BodyProblem, Floats, Ints
from contactfem.tables import Table

PRESCRIBED = -1


@dataclass(frozen=True)
class Prescribed:
    """Motion of one component of some vertices of a body over time [m]."""

    body: int
    vertices: Ints
    component: int
    value: Table


@dataclass(frozen=True)
class Grip:
    """Vertices of a body that move as one in one component, under a force over time [N/m]."""

    body: int
    vertices: Ints
    component: int
    force: Table


@dataclass(frozen=True)
class Numbering:
    """Global numbers of the dofs.

    Attributes:
        unknown: Of every body's local scalar dofs, int64; -1 where prescribed.
        grips: Of the grips.
        multipliers: Of contact multipliers that are unknowns.
        first: First number of this rank.
        n_local: Numbers of this rank.
        n_global: Numbers of all ranks.
    """

    unknown: tuple[Ints, ...]
    grips: Ints
    multipliers: Ints
    first: int
    n_local: int
    n_global: int


def number(
    comm: MPI.Comm,
    bodies: Sequence[BodyProblem],
    prescribed: Sequence[Prescribed],
    grips: Sequence[Grip],
    n_multipliers: int = 0,
) -> Numbering:
    """Number all unknowns: rank by rank; on the first grips and multipliers, then body by body.

    Args:
        comm: All ranks.
        bodies: The bodies.
        prescribed: Prescribed motions.
        grips: Grips.
        n_multipliers: Number of contact multipliers.

    Returns:
        The numbering.

    Raises:
        CaseError: A vertex of a grip's free component is prescribed or in another grip.
    """
    own = [np.full(len(body.u.x.array), -2, np.int64) for body in bodies]
    for p in prescribed:
        own[p.body][bodies[p.body].dofs(p.vertices, p.component)] = PRESCRIBED
    clash = False
    for k, g in enumerate(grips):
        dofs = bodies[g.body].dofs(g.vertices, g.component)
        clash = clash or bool((own[g.body][dofs] != -2).any())
        own[g.body][dofs] = -3 - k
    if comm.allreduce(clash, MPI.LOR):
        raise CaseError("a grip's free component is held by another condition at some vertex")
    owned = [body.n_owned for body in bodies]
    counts = [int((a[:n] == -2).sum()) for a, n in zip(own, owned, strict=True)]
    others = len(grips) + n_multipliers if comm.rank == 0 else 0
    n_local = sum(counts) + others
    first = sum(comm.allgather(n_local)[: comm.rank])
    start = first + others
    unknown = []
    for body, a, n, count in zip(bodies, own, owned, counts, strict=True):
        vector = la.vector(body.V.dofmap.index_map, body.V.dofmap.index_map_bs, dtype=np.float64)
        free = np.flatnonzero(a[:n] == -2)
        vector.array[free] = np.arange(start, start + count)
        vector.scatter_forward()
        result = vector.array.astype(np.int64)
        result[a == PRESCRIBED] = PRESCRIBED
        for k in range(len(grips)):
            result[a == -3 - k] = k
        unknown.append(result)
        start += count
    multipliers = len(grips) + np.arange(n_multipliers)
    n_global = comm.allreduce(n_local)
    return Numbering(tuple(unknown), np.arange(len(grips)), multipliers, first, n_local, n_global)


class System:
    """Bodies coupled into one vector of unknowns and one matrix.

    Args:
        comm: All ranks.
        bodies: The bodies.
        prescribed: Prescribed motions.
        grips: Grips.
        n_multipliers: Number of contact multipliers that are unknowns, beside the bodies' dofs.
    """

    def __init__(
        self,
        comm: MPI.Comm,
        bodies: Sequence[BodyProblem],
        prescribed: Sequence[Prescribed],
        grips: Sequence[Grip],
        n_multipliers: int = 0,
    ) -> None:
        self.comm, self.bodies, self.grips = comm, tuple(bodies), tuple(grips)
        self.numbering = number(comm, bodies, prescribed, grips, n_multipliers)
        self.multipliers = np.zeros(n_multipliers)
        self.prescribed = tuple(prescribed)
        self._held = [
            (bodies[p.body], bodies[p.body].dofs(p.vertices, p.component), p.value)
            for p in prescribed
        ]
        self.grip_loads = np.zeros(len(grips))
        n = self.numbering
        self.x = PETSc.Vec().createMPI((n.n_local, n.n_global), comm=comm)
        self._maps, self._scatters = [], []
        for unknown in n.unknown:
            self._maps.append(PETSc.LGMap().create(unknown.astype(np.int32), comm=comm))
            free = np.flatnonzero(unknown >= 0).astype(np.int32)
            local = PETSc.Vec().createSeq(len(unknown))
            scatter = PETSc.Scatter().create(
                self.x,
                PETSc.IS().createGeneral(unknown[free].astype(np.int32), comm=PETSc.COMM_SELF),
                local,
                PETSc.IS().createGeneral(free, comm=PETSc.COMM_SELF),
            )
            self._scatters.append((scatter, local))
        self.pattern = self._bulk_pattern()

    @property
    def axisymmetric(self) -> bool:
        """Whether the bodies stand around the axis x = 0; all forces are then in N, not N/m."""
        return self.bodies[0].axisymmetric

    @property
    def is_linear(self) -> bool:
        """Whether no body's tangent depends on the state."""
        return all(body.is_linear for body in self.bodies)

    def advance(self, t: float, ramp_end: float) -> list[Floats | None]:
        """Set loads and temperatures to those of a time; prescribed motions follow.

        Args:
            t: Time [s].
            ramp_end: Time at which constant values are reached [s].

        Returns:
            The jump of every body's prescribed motions, flat local arrays [m]; None for linear
            bodies and where there is none. `residual` and `assemble` of the first Newton iteration
            take it: it is carried into the bodies linearly, as a jump of the boundary alone would
            turn the cells there inside out.
        """
        jumps = []
        for body in self.bodies:
            body.set_time(t, ramp_end)
            jumps.append(np.zeros_like(body.u.x.array))
        for p, (body, dofs, value) in zip(self.prescribed, self._held, strict=True):
            jumps[p.body][dofs] = value.at(t, ramp_end) - body.u.x.array[dofs]
        self.grip_loads[:] = [grip.force.at(t, ramp_end) for grip in self.grips]
        for body, jump in zip(self.bodies, jumps, strict=True):
            body.u.x.array[:] += jump
        pairs = zip(self.bodies, jumps, strict=True)
        moved = [bool(jump.any()) and not body.is_linear for body, jump in pairs]
        anywhere = self.comm.allreduce(np.array(moved, np.int32))
        return [jump if m else None for m, jump in zip(anywhere, jumps, strict=True)]

    def spread(self, x: PETSc.Vec) -> None:
        """Write the unknowns into the bodies' displacements and `multipliers`; collective."""
        for body, (scatter, local) in zip(self.bodies, self._scatters, strict=True):
            local.array[:] = body.u.x.array
            scatter.scatter(x, local)
            body.u.x.array[:] = local.array
        if len(self.multipliers):
            if self.comm.rank == 0:
                self.multipliers[:] = x.array_r[self.numbering.multipliers]
            self.comm.Bcast(self.multipliers)

    def residual(self, out: PETSc.Vec, jumps: Sequence[Floats | None]) -> list[Floats]:
        """Internal minus external forces without contact, over the unknowns; collective.

        Args:
            out: Receives the residual [N/m].
            jumps: Of `advance` in the first iteration, else all None.

        Returns:
            Every body's local residual, prescribed dofs included, to be summed over the ranks.
        """
        out.set(0.0)
        parts = []
        for body, jump, (scatter, local) in zip(self.bodies, jumps, self._scatters, strict=True):
            if jump is None:
                part = body.residual()
            else:
                with body.without(jump):
                    part = body.residual() + body.tangent_action(jump)
            local.array[:] = part
            scatter.scatter(local, out, addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
            parts.append(part)
        if self.comm.rank == 0 and len(self.grips):
            out.array[: len(self.grips)] -= self.grip_loads
        return parts

    def reactions(self, parts: Sequence[Floats]) -> list[float]:
        """Resultant force of every prescribed motion on its body [N/m]; collective.

        Args:
            parts: Local residuals, as `residual` returns them.
        """
        held = zip(self.prescribed, self._held, strict=True)
        mine = [float(parts[p.body][dofs].sum()) for p, (_, dofs, _) in held]
        return [float(v) for v in self.comm.allreduce(np.array(mine))] if mine else []

    def assemble(self, A: PETSc.Mat, jumps: Sequence[Floats | None]) -> None:
        """Fill a matrix with the bulk tangent; collective.

        Args:
            A: Matrix from `create_matrix`.
            jumps: Of `advance` in the first iteration, else all None.
        """
        A.zeroEntries()
        for body, jump, lgmap in zip(self.bodies, jumps, self._maps, strict=True):
            A.setLGMap(lgmap, lgmap)
            with body.without(jump):
                body.add_tangent(A)
        A.assemble()

    def create_matrix(self, pattern: sp.csr_matrix) -> PETSc.Mat:
        """Zero matrix with a pattern of this rank's rows, (n_local, n_global)."""
        n = self.numbering
        size = (n.n_local, n.n_global)
        csr = (
            pattern.indptr.astype(np.int32),
            pattern.indices.astype(np.int32),
            np.zeros(pattern.nnz),
        )
        A = PETSc.Mat().createAIJ((size, size), csr=csr, comm=self.comm)
        A.setOption(PETSc.Mat.Option.KEEP_NONZERO_PATTERN, True)
        return A

    def collect_pattern(self, rows: Ints, cols: Ints) -> sp.csr_matrix:
        """Pattern of this rank's rows from places that any rank names; collective.

        Args:
            rows: Global rows, negative ones are left out.
            cols: Global columns, likewise.

        Returns:
            Boolean-like matrix, (n_local, n_global).
        """
        n = self.numbering
        keep = (rows >= 0) & (cols >= 0)
        rows, cols = rows[keep], cols[keep]
        if self.comm.size > 1:
            ends = np.array(self.comm.allgather(n.first + n.n_local))
            owner = np.searchsorted(ends, rows, side="right")
            sent = [np.array((rows[owner == r], cols[owner == r])) for r in range(self.comm.size)]
            rows, cols = np.concatenate(self.comm.alltoall(sent), axis=1)
        data = np.ones(len(rows), np.int8)
        pattern = sp.coo_matrix((data, (rows - n.first, cols)), (n.n_local, n.n_global)).tocsr()
        pattern.data[:] = 1
        return pattern

    def _bulk_pattern(self) -> sp.csr_matrix:
        rows, cols = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
        for body, unknown in zip(self.bodies, self.numbering.unknown, strict=True):
            dofs = unknown[body.cell_dofs()]
            m = dofs.shape[1]
            rows.append(np.repeat(dofs, m, axis=1).ravel())
            cols.append(np.tile(dofs, (1, m)).ravel())
        diagonal = self.numbering.first + np.arange(self.numbering.n_local)
        rows.append(diagonal)
        cols.append(diagonal)
        return self.collect_pattern(np.concatenate(rows), np.concatenate(cols))
