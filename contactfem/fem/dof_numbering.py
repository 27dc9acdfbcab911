"""Global numbers of the unknowns of several bodies.

Every scalar dof of every body has a global number, -1 where its value is prescribed; the dofs of a
grip's free component share one number. Assembly through these maps drops and ties by itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.sparse as sp
from dolfinx import fem, la

from mpi4py import MPI
from petsc4py import PETSc

from contactfem.common.place_time import Varying
from contactfem.common.time_table import Table
from contactfem.common.typing import Floats, Ints
from contactfem.errors import CaseError

PRESCRIBED = -1


class Field(Protocol):
    """A body's finite element function, as far as numbering needs to know it.

    Attributes:
        V: Space of all its unknowns.
        n_owned: Scalar dofs of this rank; those of ghosts follow.
        n_dofs: Owned and ghost ones.
    """

    V: fem.FunctionSpace
    n_owned: int

    @property
    def n_dofs(self) -> int:
        """Scalar dofs of this rank, owned and ghost."""

    def dofs(self, vertices: Ints, component: int) -> Ints:
        """Local scalar dofs of one component at some input vertices, (m,)."""

    def cell_dofs(self) -> Ints:
        """Scalar dofs of every owned cell, (cells, dofs)."""


class Place(Protocol):
    """One component of some vertices of a body."""

    @property
    def body(self) -> int:
        """Number of the body."""

    @property
    def vertices(self) -> Ints:
        """Input vertices."""

    @property
    def component(self) -> int:
        """Number of the component."""


@dataclass(frozen=True)
class Prescribed:
    """Motion of one component of some vertices of a body over time [m]."""

    body: int
    vertices: Ints
    component: int
    value: Table | Varying


@dataclass(frozen=True)
class TiedDofs:
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
        tied: Of the tied dofs.
        multipliers: Of contact multipliers that are unknowns.
        first: First number of this rank.
        n_local: Numbers of this rank.
        n_global: Numbers of all ranks.
    """

    unknown: tuple[Ints, ...]
    tied: Ints
    multipliers: Ints
    first: int
    n_local: int
    n_global: int


def number(
    comm: MPI.Comm,
    fields: Sequence[Field],
    prescribed: Sequence[Place],
    tied: Sequence[TiedDofs],
    n_multipliers: int = 0,
) -> Numbering:
    """Number all unknowns: rank by rank; on the first tied dofs, multipliers, then body by body.

    Args:
        comm: All ranks.
        fields: The bodies' fields.
        prescribed: Where values are prescribed.
        tied: Dofs of grips that move as one.
        n_multipliers: Number of contact multipliers.

    Returns:
        The numbering.

    Raises:
        CaseError: A vertex of a grip's free component is prescribed or in another grip.
    """
    own = [np.full(field.n_dofs, -2, np.int64) for field in fields]
    for p in prescribed:
        own[p.body][fields[p.body].dofs(p.vertices, p.component)] = PRESCRIBED
    clash = False
    for k, g in enumerate(tied):
        dofs = fields[g.body].dofs(g.vertices, g.component)
        clash = clash or bool((own[g.body][dofs] != -2).any())
        own[g.body][dofs] = -3 - k
    if comm.allreduce(clash, MPI.LOR):
        raise CaseError("a grip's free component is held by another condition at some vertex")
    owned = [field.n_owned for field in fields]
    counts = [int((a[:n] == -2).sum()) for a, n in zip(own, owned, strict=True)]
    others = len(tied) + n_multipliers if comm.rank == 0 else 0
    n_local = sum(counts) + others
    first = sum(comm.allgather(n_local)[: comm.rank])
    start = first + others
    unknown = []
    for field, a, n, count in zip(fields, own, owned, counts, strict=True):
        dofmap = field.V.dofmap
        vector = la.vector(dofmap.index_map, dofmap.index_map_bs, dtype=np.float64)
        free = np.flatnonzero(a[:n] == -2)
        vector.array[free] = np.arange(start, start + count)
        vector.scatter_forward()
        result = vector.array.astype(np.int64)
        result[a == PRESCRIBED] = PRESCRIBED
        for k in range(len(tied)):
            result[a == -3 - k] = k
        unknown.append(result)
        start += count
    multipliers = len(tied) + np.arange(n_multipliers)
    n_global = comm.allreduce(n_local)
    return Numbering(tuple(unknown), np.arange(len(tied)), multipliers, first, n_local, n_global)


def pairs(dofs: Ints) -> tuple[Ints, Ints]:
    """Rows and columns of all entries of element matrices.

    Args:
        dofs: Dofs of every cell, (cells, m).

    Returns:
        Both, (cells m m,).
    """
    m = dofs.shape[1]
    return np.repeat(dofs, m, axis=1).ravel(), np.tile(dofs, (1, m)).ravel()


class Unknowns:
    """Vector and matrix of the unknowns of several bodies.

    Args:
        comm: All ranks.
        fields: The bodies' fields.
        prescribed: Prescribed values.
        tied: Dofs of grips that move as one.
        n_multipliers: Number of contact multipliers that are unknowns, beside the bodies' dofs.
    """

    def __init__(
        self,
        comm: MPI.Comm,
        fields: Sequence[Field],
        prescribed: Sequence[Place],
        tied: Sequence[TiedDofs],
        n_multipliers: int = 0,
    ) -> None:
        self.comm = comm
        self.numbering = n = number(comm, fields, prescribed, tied, n_multipliers)
        self.x = PETSc.Vec().createMPI((n.n_local, n.n_global), comm=comm)
        self.maps, self.scatters = [], []
        for unknown in n.unknown:
            self.maps.append(PETSc.LGMap().create(unknown.astype(np.int32), comm=comm))
            free = np.flatnonzero(unknown >= 0).astype(np.int32)
            local = PETSc.Vec().createSeq(len(unknown))
            scatter = PETSc.Scatter().create(
                self.x,
                PETSc.IS().createGeneral(unknown[free].astype(np.int32), comm=PETSc.COMM_SELF),
                local,
                PETSc.IS().createGeneral(free, comm=PETSc.COMM_SELF),
            )
            self.scatters.append((scatter, local))
        self.pattern = self._bulk_pattern(fields)

    def to_fields(self, x: PETSc.Vec, arrays: Sequence[Floats]) -> None:
        """Write the unknowns into the bodies' local arrays; prescribed values stay; collective."""
        for array, (scatter, local) in zip(arrays, self.scatters, strict=True):
            local.array[:] = array
            scatter.scatter(x, local)
            array[:] = local.array

    def from_fields(self, arrays: Sequence[Floats], x: PETSc.Vec) -> None:
        """Write the bodies' local arrays into a vector of the unknowns; collective.

        Args:
            arrays: One per body, flat over local dofs.
            x: The vector; multipliers in it stay.
        """
        n = self.numbering
        tied = np.full(len(n.tied), -np.inf)
        for unknown, array in zip(n.unknown, arrays, strict=True):
            inside = (unknown >= 0) & (unknown < len(tied))
            tied[unknown[inside]] = array[inside]
            own = (unknown >= max(n.first, len(tied))) & (unknown < n.first + n.n_local)
            x.array[unknown[own] - n.first] = array[own]
        self.comm.Allreduce(MPI.IN_PLACE, tied, MPI.MAX)
        if self.comm.rank == 0:
            x.array[: len(tied)] = tied

    def add_fields(self, parts: Sequence[Floats], out: PETSc.Vec) -> None:
        """Add the bodies' local arrays of all ranks to a vector of the unknowns; collective."""
        for part, (scatter, local) in zip(parts, self.scatters, strict=True):
            local.array[:] = part
            scatter.scatter(local, out, addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)

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

    def _bulk_pattern(self, fields: Sequence[Field]) -> sp.csr_matrix:
        diagonal = self.numbering.first + np.arange(self.numbering.n_local)
        entries: list[tuple[Ints, Ints]] = [(diagonal, diagonal)]
        for field, unknown in zip(fields, self.numbering.unknown, strict=True):
            entries.append(pairs(unknown[field.cell_dofs()]))
        rows, cols = (np.concatenate(part) for part in zip(*entries, strict=True))
        return self.collect_pattern(rows, cols)
