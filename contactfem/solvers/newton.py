"""Newton's method for one load step."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mpi4py import MPI
from petsc4py import PETSc

from contactfem.common.timers import Timers
from contactfem.common.typing import Floats
from contactfem.contact.state import ContactHistory, ContactState
from contactfem.fem.compat import unlock
from contactfem.fem.petsc_options import MECHANICS, configure
from contactfem.laws.active_set import ActiveSet, Status
from contactfem.mechanics.bulk_system import System
from contactfem.mechanics.condensed import Condensed, Interface
from contactfem.mechanics.saddle_point import Saddle
from contactfem.solvers.choice import linear_solver
from contactfem.solvers.diagnosis import trust_check
from contactfem.solvers.direct import Direct
from contactfem.solvers.interface import Iterate

CONVERGED, DIVERGED_LINEAR, DIVERGED_NAN, DIVERGED_ITERATIONS = 2, -3, -4, -5
# Residual that round-off leaves, over stiffness times size: always reached, and where it may stall
ROUND_OFF, STALLED = 4 * np.finfo(float).eps, 64 * np.finfo(float).eps
TURNED_OVER = (
    "the residual is not a number: a cell was turned inside out (shorter steps or other facets "
    "where it happens may help)"
)
UNSETTLED = (
    ", as the contact status does not settle (shorter steps may help, or a c_factor of the "
    "interface and its friction nearer to 1)"
)
LOST = 4  # iterations without the contact that alone holds a body after which it has flown away
AUGMENTATIONS = 40  # passes of an augmented Lagrangian at most
AUGMENTED_GAP = 1e-8  # penetration and slip that may stay, over the facet length


@dataclass(frozen=True)
class SolveReport:
    """How a solve ended; the same on all ranks.

    Attributes:
        converged: Whether the residual is small and the contact status stands.
        reason: In words, empty when converged.
        iterations: Newton iterations.
        residuals: Scaled residual before each iteration and after the last [-].
        doubt: Why a smaller step would be better though this one converged, in words; else empty.
    """

    converged: bool
    reason: str
    iterations: int
    residuals: tuple[float, ...]
    doubt: str = ""


@dataclass(frozen=True)
class StepInput:
    """What a step starts from.

    Attributes:
        t: Time at its end [s].
        ramp_end: Time at which constant loads are reached [s].
        histories: Operators at its start, per interface.
        starts: Contact status of the first iteration, per interface; None for trial states.
        known: Whether that is the status of an equilibrium found before, not a guess.
        alone: Numbers of the interfaces that alone hold a body.
        cautious: Whether nodes stick for an iteration before they slip the other way round.
    """

    t: float
    ramp_end: float
    histories: tuple[ContactHistory, ...]
    starts: tuple[ActiveSet | None, ...]
    known: bool
    alone: frozenset[int] = frozenset()
    cautious: bool = False


class NewtonSolver:
    """Solves load steps of a system with contact.

    Args:
        system: The bodies.
        interfaces: The interfaces.
        tolerance: Of the scaled residual [-].
        max_iterations: Newton iterations at most.
        options: PETSc options for the linear solver, over the defaults.
        reuse: Whether factors may serve longer than one iteration; not with options of one's own.
        timers: Where time is booked.
    """

    def __init__(
        self,
        system: System,
        interfaces: Sequence[Interface],
        tolerance: float,
        max_iterations: int,
        options: Mapping[str, str],
        timers: Timers,
        reuse: bool = False,
    ) -> None:
        self.system, self.timers = system, timers
        kept = len(system.numbering.multipliers) > 0
        self.equations = (Saddle if kept else Condensed)(system, interfaces, timers)
        self.linear = linear_solver(self.equations, options, timers, reuse)
        self.tolerance, self.max_iterations = tolerance, max_iterations
        with timers.book("jit"):
            for body in system.bodies:
                body.compile()
        self._stiffness = _stiffness(system)
        self._snes = self._create()

    @property
    def reuses(self) -> bool:
        """Whether a factor may serve longer than one iteration."""
        return type(self.linear) is not Direct

    def _create(self) -> PETSc.SNES:
        snes = PETSc.SNES().create(self.system.comm)
        snes.setType("newtonls")
        snes.setFunction(self._function, self.system.x.duplicate())
        snes.setConvergenceTest(self._test)
        snes.setTolerances(stol=0.0, max_it=self.max_iterations + 1)  # only our test says the end
        options = {"snes_linesearch_type": "basic"} | dict(self.linear.options)
        configure(snes, MECHANICS, options, "solver.petsc")
        snes.setJacobian(self._jacobian, self.linear.attach(snes))
        return snes

    def solve(self, step: StepInput) -> SolveReport:
        """Solve a step from the present unknowns and displacements; collective.

        Augmented interfaces are solved again with better estimates until these stand.

        Args:
            step: What it starts from.

        Returns:
            How it ended; `conditions` and the bodies' displacements are those of the end.
        """
        report = self._solve_once(step)
        for _ in range(AUGMENTATIONS):
            better = self._augmented(step) if report.converged else None
            if better is None:
                if report.converged:
                    interfaces = self.equations.interfaces
                    return replace(report, doubt=trust_check(interfaces, self.conditions))
                return report
            step = better
            again = self._solve_once(step)
            report = replace(
                again,
                iterations=report.iterations + again.iterations,
                residuals=report.residuals + again.residuals,
            )
        return replace(
            report, converged=False, reason=f"no end to the augmentation in {AUGMENTATIONS} passes"
        )

    def _augmented(self, step: StepInput) -> StepInput | None:
        """The same step with better estimates of augmented laws; None if they stand."""
        histories, improved = list(step.histories), False
        for k, (interface, c) in enumerate(
            zip(self.equations.interfaces, self.conditions, strict=True)
        ):
            better = interface.contact.augmented(c, AUGMENTED_GAP * c.operators.length)
            histories[k] = better or histories[k]
            improved |= better is not None
        starts = tuple(ActiveSet(c.status, c.direction) for c in self.conditions)
        new = replace(step, histories=tuple(histories), starts=starts, known=True)
        return new if improved else None

    def _solve_once(self, step: StepInput) -> SolveReport:
        """One run of Newton's method."""
        self._step, self._reason = step, ""
        self._seen: dict[bytes, int] = {}
        self._residuals: list[float] = []
        self._statuses: list[bytes] = []
        self.history: list[list[ContactState]] = []
        self.conditions: list[ContactState] = []
        self._first_jumps = self.system.advance(step.t, step.ramp_end)
        self._evaluations = 0
        self.linear.begin()
        self._solve_started = 0.0
        try:
            with self.timers.book("newton"):
                self._snes.solve(None, self.system.x)
        except PETSc.Error as error:
            why = str(error).strip().rpartition("] ")[2]
            reason = f"linear solver failed (PETSc error {error.ierr}): {why}"
            unlock(self.system.x)
            self._snes = self._create()  # the old one keeps vectors of its own locked
            return SolveReport(False, reason, len(self._residuals) - 1, tuple(self._residuals))
        code = self._snes.getConvergedReason()
        if converged := code == CONVERGED:
            with self.timers.book("newton"):
                self.linear.finish(self.system.x)
        elif not self._reason and not np.isfinite(self._snes.getFunction()[0].norm()):
            self._reason = TURNED_OVER  # newer versions of PETSc do not ask our test then
        reason = self._reason or f"PETSc SNES reason {code}"
        reason = "" if converged else f"{reason}; {self._reached()}"
        return SolveReport(converged, reason, len(self._residuals) - 1, tuple(self._residuals))

    def _reached(self) -> str:
        """How far the residual got."""
        found = [residual for residual in self._residuals if np.isfinite(residual)]
        if not found:
            return "no residual before that"
        last = f"the last residual is {found[-1]:.1e}, the smallest {min(found):.1e}"
        return f"{last}, and {self.tolerance:.0e} is asked for"

    def _function(self, snes: PETSc.SNES, x: PETSc.Vec, out: PETSc.Vec) -> None:
        """Residual with contact."""
        first = self._evaluations == 0
        if not first:  # between the factorisation and here SNES did one solve and one update
            self.timers.add("solve", time.perf_counter() - self._solve_started)
        self._evaluations += 1
        with self.timers.book("residual"):
            self._jumps = self._first_jumps if first else [None] * len(self.system.bodies)
            self.linear.residual(x, out, self._jumps)
        with self.timers.book("contact.conditions"):
            positions = self.positions()
            starts = self._step.starts if first else (None,) * len(positions)
            found = self.equations.evaluate(positions, self._step.histories, starts, out)
            self._kept = self._lost(found)
            rather = self._kept | self._reversed(found)
            if rather:
                starts = tuple(rather.get(k, starts[k]) for k in range(len(starts)))
                self.equations.bulk.copy(out)
                found = self.equations.evaluate(positions, self._step.histories, starts, out)
            self.conditions = found
            self.history.append(found)

    def _lost(self, found: Sequence[ContactState]) -> dict[int, ActiveSet]:
        """Interfaces that alone hold a body and have just lost all contact, by their number.

        For one iteration more they keep the contact they had: without it the body would be free.
        """
        return {
            k: ActiveSet(before.status, before.direction)
            for k, (before, now) in enumerate(zip(self.conditions, found, strict=False))
            if k in self._step.alone and before.active.any() and not now.active.any()
        }

    def _reversed(self, found: Sequence[ContactState]) -> dict[int, ActiveSet]:
        """Interfaces with nodes that would slip the other way round than before, by their number.

        With caution these stick for one iteration: where a tangential motion turns round, the node
        moved back far too much as long as its traction was held, and turning that round as well
        leads away from the solution. Where much slip turns round it is a detour.
        """
        if not self._step.cautious:
            return {}
        result = {}
        for k, (before, now) in enumerate(zip(self.conditions, found, strict=False)):
            turned = before.direction * now.direction < 0.0
            if turned.any():
                status = np.where(turned, Status.STICK, now.status).astype(np.int8)
                result[k] = ActiveSet(status, np.where(turned, 0.0, now.direction))
        return result

    def reactions(self) -> list[float]:
        """Resultant of every prescribed motion on its body at the last state [N/m]; collective.

        Contact forces on prescribed nodes are carried by their support as well.
        """
        result = self.linear.reactions()
        for interface, c in zip(self.equations.interfaces, self.conditions, strict=True):
            nodes, force = interface.nodes, c.nodal_forces()
            for k, p in enumerate(self.system.prescribed):
                at = (nodes.body == p.body) & np.isin(nodes.vertex, p.vertices)
                result[k] += float(force[at, p.component].sum())
        return result

    def supports(self) -> Floats:
        """What prescribed motions exert on each body [N/m], (bodies, axes); collective."""
        result = self.linear.supports()
        for interface, c in zip(self.equations.interfaces, self.conditions, strict=True):
            nodes = interface.nodes
            carried = np.where(nodes.unknown < 0, c.nodal_forces(), 0.0)
            at = nodes.body >= 0
            np.add.at(result, nodes.body[at], carried[at])
        return result

    @property
    def round_off(self) -> float:
        """Force that round-off may leave over in a body [N/m]."""
        return float(STALLED * self._stiffness * np.sqrt(self.system.numbering.n_global))

    def positions(self) -> list[Floats]:
        """Current positions of the nodes of every interface [m]; collective."""
        t, ramp_end = self._step.t, self._step.ramp_end
        return [i.nodes.positions(t, ramp_end) for i in self.equations.interfaces]

    def _test(self, snes: PETSc.SNES, its: int, norms: tuple[float, float, float]) -> int | None:
        """Converged when the scaled residual is small and the status stands."""
        norm = norms[2]
        if its == 0:
            self._initial = norm if np.isfinite(norm) else 0.0
        scale = max(self._initial, self._forces())
        self._residuals.append(norm / scale if scale > 0.0 else 0.0)
        status = b"".join(
            c.status.tobytes() + c.direction.astype(np.int8).tobytes() for c in self.conditions
        )
        stands = bool(self._statuses and self._statuses[-1] == status) or (
            its == 0 and self._step.known
        )
        # A node on the limit of friction or of contact may change status by round-off for ever:
        # if the residual is small with either status, both describe the same equilibrium.
        small = self._residuals[-2:]
        stands = stands or (len(small) == 2 and max(small) <= self.tolerance)
        idle = max(norm, self._forces()) <= ROUND_OFF * self._stiffness  # touches without force
        stands = bool(stands and (not self._kept or idle))
        self._seen[status] = self._seen.get(status, 0) + 1
        self._statuses.append(status)
        if self.linear.failure:
            self._reason = self.linear.failure
            return DIVERGED_LINEAR
        if not np.isfinite(norm):
            self._reason = TURNED_OVER
            return DIVERGED_NAN
        if norm <= max(self.tolerance * scale, ROUND_OFF * self._stiffness) and stands:
            return CONVERGED
        stalled = len(self._residuals) > 1 and self._residuals[-1] > 0.5 * self._residuals[-2]
        if norm <= STALLED * self._stiffness and stands and stalled:
            return CONVERGED
        recent = self.history[-LOST:]
        if len(recent) == LOST and any(
            not any(c[k].active.any() for c in recent) for k in self._step.alone
        ):
            self._reason = f"contact that alone holds a body is lost for {LOST} iterations"
            return DIVERGED_ITERATIONS
        if its >= self.max_iterations:
            self._reason = f"no convergence in {its} iterations{'' if stands else UNSETTLED}"
            return DIVERGED_ITERATIONS
        return None

    def _forces(self) -> float:
        """Size of the forces that the residual is compared with [N/m]."""
        contact = [np.linalg.norm(c.operators.D[:, None] * c.multiplier) for c in self.conditions]
        support = [np.linalg.norm(r) for r in self.linear.reactions()]
        return float(max([*contact, *support, *np.abs(self.system.grip_loads), 0.0]))

    def _jacobian(self, snes: PETSc.SNES, x: PETSc.Vec, J: PETSc.Mat, P: PETSc.Mat) -> None:
        """Tangent with contact."""
        residuals, settled = tuple(self._residuals), len(set(self._statuses[-2:])) == 1
        at = Iterate(
            self.conditions, self._jumps, self._damping(), residuals, self.tolerance, settled
        )
        A = self.linear.linearise(at)
        snes.setJacobian(self._jacobian, A, A)
        self._solve_started = time.perf_counter()

    def _damping(self) -> float:
        """Half a step where a status set that was left comes back: it would cycle."""
        last = self._statuses[-1]
        left = len(self._statuses) > 1 and self._statuses[-2] != last
        return 0.5 if left and self._seen[last] > 1 else 1.0


def _stiffness(system: System) -> float:
    """Stiffness that round-off in strains or positions is multiplied with [N/m], with an axis [N].

    In plane strain the largest modulus times the largest size; with an axis times the circumference
    as well, which can only be that of the same body.
    """
    moduli = [body.law.youngs_modulus for body in system.bodies]
    extents = _extents(system)
    if not system.axisymmetric:
        return max(moduli) * float(extents.max())
    return float(np.max(2 * np.pi * np.array(moduli) * extents**2))


def _extents(system: System) -> Floats:
    """Largest coordinate of every body [m]."""
    sizes = [float(np.abs(body.mesh.mesh.geometry.x).max(initial=0.0)) for body in system.bodies]
    largest = np.array(sizes)
    system.comm.Allreduce(MPI.IN_PLACE, largest, MPI.MAX)
    return largest
