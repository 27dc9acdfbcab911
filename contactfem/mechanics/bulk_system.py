"""Mechanics of several bodies as one system: residual and tangent (18)."""

from collections.abc import Iterable, Sequence

import numpy as np

from mpi4py import MPI
from petsc4py import PETSc

from contactfem.common.place_time import Varying
from contactfem.common.typing import Floats, Ints
from contactfem.fem.dof_numbering import Prescribed, TiedDofs, Unknowns
from contactfem.mechanics.body import BodyProblem


class System(Unknowns):
    """Bodies coupled into one vector of unknowns and one matrix.

    Args:
        comm: All ranks.
        bodies: The bodies.
        prescribed: Prescribed motions.
        tied: Dofs of grips that move as one.
        n_multipliers: Number of contact multipliers that are unknowns, beside the bodies' dofs.
    """

    def __init__(
        self,
        comm: MPI.Comm,
        bodies: Sequence[BodyProblem],
        prescribed: Sequence[Prescribed],
        tied: Sequence[TiedDofs],
        n_multipliers: int = 0,
    ) -> None:
        super().__init__(comm, bodies, prescribed, tied, n_multipliers)
        self.bodies, self.tied = tuple(bodies), tuple(tied)
        self.multipliers = np.zeros(n_multipliers)
        self.prescribed = tuple(prescribed)
        self._held = [
            (bodies[p.body], bodies[p.body].dofs(p.vertices, p.component), p.value)
            for p in prescribed
        ]
        self.grip_loads = np.zeros(len(tied))
        self._supported = {  # each dof once, though several conditions may prescribe it
            (body, component): _distinct(
                dofs
                for p, (_, dofs, _) in zip(prescribed, self._held, strict=True)
                if (p.body, p.component) == (body, component)
            )
            for body, component in {(p.body, p.component) for p in prescribed}
        }

    @property
    def dim(self) -> int:
        """Dimension of space."""
        return int(self.bodies[0].mesh.mesh.geometry.dim)

    @property
    def axisymmetric(self) -> bool:
        """Whether the bodies stand around the axis x = 0; all forces are then in N, not N/m."""
        return self.bodies[0].axisymmetric

    @property
    def is_linear(self) -> bool:
        """Whether no body's tangent depends on the state."""
        return all(body.is_linear for body in self.bodies)

    @property
    def is_symmetric(self) -> bool:
        """Whether every body's tangent is symmetric."""
        return all(body.is_symmetric for body in self.bodies)

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
            if isinstance(value, Varying):
                there: Floats | float = value.at(body.places(p.vertices), t, ramp_end)
            else:
                there = value.at(t, ramp_end)
            jumps[p.body][dofs] = there - body.u.x.array[dofs]
        self.grip_loads[:] = [grip.force.at(t, ramp_end) for grip in self.tied]
        for body, jump in zip(self.bodies, jumps, strict=True):
            body.u.x.array[:] += jump
        pairs = zip(self.bodies, jumps, strict=True)
        moved = [bool(jump.any()) and not body.is_linear for body, jump in pairs]
        anywhere = self.comm.allreduce(np.array(moved, np.int32))
        return [jump if m else None for m, jump in zip(anywhere, jumps, strict=True)]

    def spread(self, x: PETSc.Vec) -> None:
        """Write the unknowns into the bodies' displacements and `multipliers`; collective."""
        self.to_fields(x, [body.u.x.array for body in self.bodies])
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
        for body, jump in zip(self.bodies, jumps, strict=True):
            if jump is None:
                part = body.residual()
            else:
                with body.without(jump):
                    part = body.residual() + body.tangent_action(jump)
            parts.append(part)
        self.add_fields(parts, out)
        if self.comm.rank == 0 and len(self.tied):
            out.array[: len(self.tied)] -= self.grip_loads
        return parts

    def reactions(self, parts: Sequence[Floats]) -> list[float]:
        """Resultant force of every prescribed motion on its body [N/m]; collective.

        Args:
            parts: Local residuals, as `residual` returns them.
        """
        held = zip(self.prescribed, self._held, strict=True)
        mine = [float(parts[p.body][dofs].sum()) for p, (_, dofs, _) in held]
        return [float(v) for v in self.comm.allreduce(np.array(mine))] if mine else []

    def supports(self, parts: Sequence[Floats]) -> Floats:
        """Sum of what all prescribed motions exert on each body [N/m], (bodies, axes); collective.

        Unlike `reactions`, a dof that several conditions hold counts once.

        Args:
            parts: Local residuals, as `residual` returns them.
        """
        total = np.zeros((len(self.bodies), self.bodies[0].mesh.mesh.geometry.dim))
        for (body, component), dofs in self._supported.items():
            total[body, component] = parts[body][dofs].sum()
        self.comm.Allreduce(MPI.IN_PLACE, total)
        return total

    def assemble(self, A: PETSc.Mat, jumps: Sequence[Floats | None]) -> None:
        """Fill a matrix with the bulk tangent; collective.

        Args:
            A: Matrix from `create_matrix`.
            jumps: Of `advance` in the first iteration, else all None.
        """
        A.zeroEntries()
        for body, jump, lgmap in zip(self.bodies, jumps, self.maps, strict=True):
            A.setLGMap(lgmap, lgmap)
            with body.without(jump):
                body.add_tangent(A)
        A.assemble()


def _distinct(parts: Iterable[Ints]) -> Ints:
    """Numbers that are in any of some arrays, each once."""
    return np.asarray(np.unique(np.concatenate(list(parts))), np.int64)
