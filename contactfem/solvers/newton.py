"""Newton's method for one load step."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from mpi4py import MPI
from petsc4py import PETSc

from contactfem.common.timers import Timers
from contactfem.common.typing import Floats
from contactfem.contact.state import ContactHistory, ContactState
from contactfem.fem.compat import unlock
from contactfem.fem.dof_numbering import Place
from contactfem.fem.petsc_options import MECHANICS, configure
from contactfem.laws.active_set import ActiveSet, Status
from contactfem.mechanics.bulk_system import System
from contactfem.mechanics.contact_equations import Interface
from contactfem.solvers.body_rows import BodyRows
from contactfem.solvers.choice import contact_equations, linear_solver
from contactfem.solvers.convergence import (
    CONVERGED,
    DIVERGED_LINEAR,
    STALLED,
    TURNED_OVER,
    Balance,
    Convergence,
    Criteria,
    Outcome,
)
from contactfem.solvers.diagnosis import trust_check
from contactfem.solvers.interface import Iterate, SupportForces

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
        self.equations = contact_equations(system, interfaces, timers)
        self.linear = linear_solver(self.equations, options, timers, reuse)
        self.tolerance, self.max_iterations = tolerance, max_iterations
        with timers.book("jit"):
            for body in system.bodies:
                body.compile()
        self._stiffness = _stiffness(system)
        self._rows = BodyRows(system, self.equations.interfaces)
        self._bulk = system.x.duplicate()
        self._run: _Run | None = None
        self._snes = self._create()

    @property
    def reuses(self) -> bool:
        """Whether a factor may serve longer than one iteration."""
        return self.linear.reuses

    @property
    def conditions(self) -> list[ContactState]:
        """Contact state of every interface at the last iteration; empty before the first."""
        return self.history[-1] if self.history else []

    @property
    def history(self) -> list[list[ContactState]]:
        """Contact state of every interface at every iteration of the last solve."""
        return [] if self._run is None else self._run.states

    def reactions(self) -> list[float]:
        """Resultant of every prescribed motion on its body at the last iteration [N/m].

        Contact forces on prescribed nodes are carried by their support as well.
        """
        result = [] if self._run is None else list(self._run.supports.reactions)
        for interface, c in zip(self.equations.interfaces, self.conditions, strict=True):
            nodes, force = interface.nodes, c.nodal_forces()
            for k, p in enumerate(self.system.prescribed):
                at = (nodes.body == p.body) & np.isin(nodes.vertex, p.vertices)
                result[k] += float(force[at, p.component].sum())
        return result

    def supports(self) -> Floats:
        """What prescribed motions exert on each body at the last iteration [N/m], (bodies, dim)."""
        result = self._running.supports.by_body.copy()
        for interface, c in zip(self.equations.interfaces, self.conditions, strict=True):
            nodes = interface.nodes
            carried = np.where(nodes.unknown < 0, c.nodal_forces(), 0.0)
            at = nodes.body >= 0
            np.add.at(result, nodes.body[at], carried[at])
        return result

    @property
    def round_off(self) -> float:
        """Force that round-off may leave over in a body [N/m]."""
        return float(STALLED * self._stiffness.max() * np.sqrt(1 + self.system.numbering.n_global))

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
            better = interface.contact.augmented(c, AUGMENTED_GAP * c.operators.size)
            histories[k] = better or histories[k]
            improved |= better is not None
        starts = tuple(c.active_set for c in self.conditions)
        new = replace(step, histories=tuple(histories), starts=starts, known=True)
        return new if improved else None

    def _solve_once(self, step: StepInput) -> SolveReport:
        """One run of Newton's method."""
        criteria = Criteria(self.tolerance, self.max_iterations, step.known, step.alone)
        jumps = self.system.advance(step.t, step.ramp_end)
        self._run = run = _Run(step, Convergence(criteria), jumps)
        self.linear.begin()
        residuals = run.convergence.residuals
        try:
            with self.timers.book("newton"):
                self._snes.solve(None, self.system.x)
        except PETSc.Error as error:
            why = str(error).strip().rpartition("] ")[2]
            reason = f"linear solver failed (PETSc error {error.ierr}): {why}"
            unlock(self.system.x)
            self._snes = self._create()  # the old one keeps vectors of its own locked
            return SolveReport(False, reason, len(residuals) - 1, tuple(residuals))
        code = self._snes.getConvergedReason()
        if converged := code == CONVERGED:
            with self.timers.book("newton"):
                self.linear.finish(self.system.x)
        elif not run.reason and not np.isfinite(self._snes.getFunction()[0].norm()):
            run.reason = TURNED_OVER  # newer versions of PETSc do not ask our test then
        reason = run.reason or f"PETSc SNES reason {code}"
        reason = "" if converged else f"{reason}; {run.convergence.reached()}"
        return SolveReport(converged, reason, len(residuals) - 1, tuple(residuals))

    @property
    def _running(self) -> "_Run":
        """The solve that PETSc asks about."""
        if self._run is None:
            raise RuntimeError("no solve has begun")
        return self._run

    def _function(self, snes: PETSc.SNES, x: PETSc.Vec, out: PETSc.Vec) -> None:
        """Residual with contact."""
        run = self._running
        first = not run.states
        if not first:  # between the factorisation and here SNES did one solve and one update
            self.timers.add("solve", time.perf_counter() - run.solve_started)
            run.jumps = [None] * len(self.system.bodies)
        with self.timers.book("residual"):
            run.supports = self.linear.residual(x, self._bulk, run.jumps)
        with self.timers.book("contact.conditions"):
            step = run.step
            positions = [
                i.nodes.positions(step.t, step.ramp_end) for i in self.equations.interfaces
            ]
            starts = step.starts if first else (None,) * len(positions)
            evaluate = partial(self.equations.evaluate, positions, step.histories)
            found = evaluate(starts, self._bulk, out)
            kept = self._lost(found)
            rather = kept | self._reversed(found)
            if rather:
                starts = tuple(rather.get(k, starts[k]) for k in range(len(starts)))
                found = evaluate(starts, self._bulk, out)
            run.contact_kept = bool(kept)
            run.states.append(found)

    def _lost(self, found: Sequence[ContactState]) -> dict[int, ActiveSet]:
        """Interfaces that alone hold a body and have just lost all contact, by their number.

        For one iteration more they keep the contact they had: without it the body would be free.
        """
        return {
            k: before.active_set
            for k, (before, now) in enumerate(zip(self.conditions, found, strict=False))
            if k in self._running.step.alone and before.active.any() and not now.active.any()
        }

    def _reversed(self, found: Sequence[ContactState]) -> dict[int, ActiveSet]:
        """Interfaces with nodes that would slip the other way round than before, by their number.

        With caution these stick for one iteration: where a tangential motion turns round, the node
        moved back far too much as long as its traction was held, and turning that round as well
        leads away from the solution. Where much slip turns round it is a detour.
        """
        if not self._running.step.cautious:
            return {}
        result = {}
        for k, (before, now) in enumerate(zip(self.conditions, found, strict=False)):
            turned = now.active_set.turned_from(before.active_set)
            if turned.any():
                status = np.where(turned, Status.STICK, now.status).astype(np.int8)
                direction = np.where(turned[:, None], 0.0, now.active_set.direction)
                result[k] = ActiveSet(status, direction)
        return result

    def _test(self, snes: PETSc.SNES, its: int, norms: tuple[float, float, float]) -> int | None:
        """PETSc's code for how the solve ends; None to go on."""
        run = self._running
        squares = self._rows.squares(snes.getFunction()[0].array_r)
        joined = self._rows.joined(self.conditions)
        balance = Balance(squares, self._forces(), self._stiffness, joined)
        run.convergence.add(balance, self.conditions, run.contact_kept)
        found = run.convergence.outcome()
        if self.linear.failure:
            found = Outcome(DIVERGED_LINEAR, self.linear.failure)
        if found is None:
            return None
        run.reason = found.reason
        return found.code

    def _forces(self) -> Floats:
        """Size of the forces that each body's residual is compared with [N/m], (bodies,)."""
        result = np.zeros(len(self.system.bodies))
        for (first, second), c in zip(self._rows.pairs, self.conditions, strict=True):
            size = np.linalg.norm(c.operators.D[:, None] * c.multiplier.vector)
            at = [first] if second < 0 else [first, second]
            result[at] = np.maximum(result[at], size)
        places: list[Place] = [*self.system.prescribed, *self.system.tied]
        forces = [*self._running.supports.reactions, *self.system.grip_loads]
        for place, force in zip(places, forces, strict=True):
            result[place.body] = max(float(result[place.body]), abs(float(force)))
        return result

    def _jacobian(self, snes: PETSc.SNES, x: PETSc.Vec, J: PETSc.Mat, P: PETSc.Mat) -> None:
        """Tangent with contact."""
        run = self._running
        sets = run.convergence.active_sets
        A = self.linear.linearise(
            Iterate(
                states=self.conditions,
                jumps=run.jumps,
                damping=0.5 if sets.comes_back else 1.0,  # it would cycle
                residuals=tuple(run.convergence.residuals),
                tolerance=self.tolerance,
                settled=sets.settled,
            )
        )
        snes.setJacobian(self._jacobian, A, A)
        run.solve_started = time.perf_counter()


@dataclass
class _Run:
    """One run of Newton's method.

    Attributes:
        step: What it starts from.
        convergence: Its course.
        jumps: Of prescribed motions that the bulk has not followed yet, in the first iteration.
        states: Contact state of every interface at every iteration.
        supports: What prescribed motions exert at the last iteration.
        contact_kept: Whether contact that was just lost is kept for this iteration.
        solve_started: When PETSc began to solve the last linear system [s].
        reason: Why it failed, in words.
    """

    step: StepInput
    convergence: Convergence
    jumps: list[Floats | None]
    states: list[list[ContactState]] = field(default_factory=list)
    supports: SupportForces = field(default_factory=lambda: SupportForces([], np.empty(0)))
    contact_kept: bool = False
    solve_started: float = 0.0
    reason: str = ""


def _stiffness(system: System) -> Floats:
    """Stiffness that round-off in strains or positions is multiplied with, (bodies,).

    In plane strain the modulus times the size [N/m]; with an axis times the circumference [N].
    """
    moduli = np.array([body.law.youngs_modulus for body in system.bodies])
    extents = _extents(system)
    return np.asarray(2 * np.pi * moduli * extents**2 if system.axisymmetric else moduli * extents)


def _extents(system: System) -> Floats:
    """Largest coordinate of every body [m]."""
    sizes = [float(np.abs(body.mesh.mesh.geometry.x).max(initial=0.0)) for body in system.bodies]
    largest = np.array(sizes)
    system.comm.Allreduce(MPI.IN_PLACE, largest, MPI.MAX)
    return largest
