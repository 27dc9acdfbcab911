"""Contact of one interface: active set and contact conditions at its nodes."""

from dataclasses import dataclass, field, replace

import numpy as np

from mpi4py import MPI

from contactfem.common.typing import Bools, Floats
from contactfem.contact.slip import Motion, relative_motion, tangential, transported, transports
from contactfem.contact.state import (
    ContactHistory,
    ContactState,
    EdgeTies,
    Multiplier,
    Residuals,
)
from contactfem.laws.active_set import ActiveSet, Status
from contactfem.laws.complementarity import (
    Regularisation,
    active_set,
    lengths,
    normal_condition,
    slip_condition,
    stick_condition,
    trial_multiplier,
    unit,
)
from contactfem.laws.edge_stabilisation import edge_compliance
from contactfem.laws.friction import FrictionLaw, SlipState, frictionless
from contactfem.mortar.evaluation import operators_at
from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.mortar_operators import MortarOperators
from contactfem.mortar.search_range import SearchRange


@dataclass(frozen=True)
class ContactLaw:
    """Numbers of the laws of one interface.

    Attributes:
        friction: Largest traction as a function of the slip state; `frictionless` for none.
        c: Scale between gap and pressure [Pa/m], shape (n_nonmortar,).
        c_n: Factor on c in the trial pressure [-].
        c_t: Factor on c in the trial traction [-].
        stiffness: Softer Young's modulus of the two sides [Pa].
        reach: How far apart the surfaces look for each other.
        normal_compliance: 1/ε_N of a penalty (13) [m/Pa], (n_nonmortar,); zero for exact contact.
        tangential_compliance: 1/c_T of regularised friction [m/Pa], likewise.
        augmented: Whether estimates of pressure and traction take the compliance's place.
        initial_gap: Gap that counts as none, of tied and of adjusted nodes [m], (n_nonmortar,).
        tied: Nodes that stick to the other side in every direction (10), (n_nonmortar,); None for
            contact.
    """

    friction: FrictionLaw
    c: Floats
    c_n: float
    c_t: float
    stiffness: float
    reach: SearchRange
    normal_compliance: Floats = field(default_factory=lambda: np.zeros(1))
    tangential_compliance: Floats = field(default_factory=lambda: np.zeros(1))
    augmented: bool = False
    initial_gap: Floats = field(default_factory=lambda: np.zeros(1))
    tied: Bools | None = None

    @property
    def has_friction(self) -> bool:
        """Whether there is friction."""
        return self.friction is not frictionless


@dataclass(frozen=True)
class _Regularised:
    """What multipliers are tied to at one state: estimates p̂, t̂ and, at edge nodes, neighbours.

    Attributes:
        normal: Of the pressure: a penalty's, and the edge stabilisation.
        tangential: Of the traction: that of regularised friction, and the edge stabilisation.
    """

    normal: tuple[Regularisation, Regularisation]
    tangential: tuple[Regularisation, Regularisation]


class Contact:
    """One interface: evaluates the contact conditions.

    Args:
        comm: Ranks that share the work.
        mesh: The two surfaces.
        law: Numbers of the laws.
    """

    def __init__(self, comm: MPI.Comm, mesh: InterfaceMesh, law: ContactLaw) -> None:
        self.comm = comm
        self.mesh = mesh
        self.law = law
        k = len(mesh.nonmortar)
        self.my_facets = np.arange(k * comm.rank // comm.size, k * (comm.rank + 1) // comm.size)

    def operators(self, x: Floats) -> MortarOperators:
        """Search, cut and integrate at the positions x [m], (n_nodes, dim); collective."""
        return operators_at(self.comm, self.mesh, x, self.my_facets, self.law.reach)

    def state(
        self,
        operators: MortarOperators,
        multiplier: Floats,
        history: ContactHistory,
        start: ActiveSet | None = None,
    ) -> ContactState:
        """Active set of the nodes from their trial multipliers, and what the conditions leave over.

        Args:
            operators: At the current positions.
            multiplier: λ_j of every node as equilibrium gives it [Pa], (n_nonmortar, dim).
            history: What the step started from.
            start: Active set to take instead of that of the trial multipliers; what is not covered
                is open all the same.

        Returns:
            The state.
        """
        motion = self.motion(operators, history)
        edge = self._edge(operators)
        if self.law.tied is not None:
            status = np.where(self.law.tied & (operators.D > 0.0), Status.STICK, Status.OPEN)
            found = ActiveSet(status.astype(np.int8), np.zeros_like(motion.slip))
            turning = np.zeros(self.mesh.n_nonmortar)
        elif start is None:
            found, turning = self._trial(operators, multiplier, history, motion, edge)
        else:
            status = np.where(operators.D > 0.0, start.status, Status.OPEN)
            along = unit(tangential(start.direction, operators.normals.n))
            found = ActiveSet(status.astype(np.int8), along)
            turning = np.zeros(self.mesh.n_nonmortar)
        chosen = self._allowed(found, motion, edge)
        return self._state(operators, multiplier, history, (chosen, turning), motion, edge)

    def gap(self, operators: MortarOperators, history: ContactHistory) -> Floats:
        """Gap that the conditions see [m], (n,): less what counts as none, and the offset."""
        return np.asarray(operators.gap - self.law.initial_gap - history.offset)

    @staticmethod
    def motion(operators: MortarOperators, history: ContactHistory) -> Motion:
        """Relative motion of the two sides from the start of the step to where operators are."""
        before = history.D, history.M
        return relative_motion(operators.x, operators.normals.n, operators.M, before)

    def _trial(
        self,
        operators: MortarOperators,
        multiplier: Floats,
        history: ContactHistory,
        motion: Motion,
        edge: EdgeTies,
    ) -> tuple[ActiveSet, Floats]:
        """Active set of the trial multipliers, and how much a change of t* turns its direction."""
        law, parts = self.law, _parts(multiplier, operators.normals.n)
        tied = self._regularised(operators, parts, history, edge)
        seen = np.isfinite(operators.gap)
        gap = np.where(seen, self.gap(operators, history), 0.0)
        trial = trial_multiplier(parts.pressure, -gap, law.c_n * law.c, tied.normal)
        p_trial = np.where(seen, trial, 0.0)
        t_trial = trial_multiplier(parts.traction, motion.slip, law.c_t * law.c, tied.tangential)
        bound = law.friction(self._slip_state(p_trial, motion.slip, history)).value
        found = active_set(p_trial, t_trial, bound, law.has_friction)
        if not law.has_friction:
            return found, np.zeros(len(bound))
        weight = 1.0 + law.c_t * law.c * sum(part.compliance for part in tied.tangential)
        at = (found.status == Status.SLIP) & motion.known
        size = np.where(at, lengths(t_trial), 1.0)
        return found, np.where(at, bound / (size * weight), 0.0)

    def _allowed(self, found: ActiveSet, motion: Motion, edge: EdgeTies) -> ActiveSet:
        """The active set of nodes that have a multiplier, with a direction where they slip.

        A node that was not covered before this step has no slip: it follows its neighbour.
        """
        status = np.where(self.mesh.has_multiplier, found.status, Status.NONE)
        direction = np.where((status == Status.SLIP)[:, None], found.direction, 0.0)
        new = (status > Status.OPEN) & ~motion.known
        if new.any():
            status = np.where(new, Status.SLIP, status)
            direction[new] = edge.traction_target(direction)[new]
        return ActiveSet(status.astype(np.int8), direction)

    def _state(
        self,
        operators: MortarOperators,
        multiplier: Floats,
        history: ContactHistory,
        chosen: tuple[ActiveSet, Floats],
        motion: Motion,
        edge: EdgeTies,
    ) -> ContactState:
        """Residuals of the conditions that belong to an active set."""
        found, turning = chosen
        active = found.active
        parts = _parts(np.where(active[:, None], multiplier, 0.0), operators.normals.n)
        p, t = parts.pressure, parts.traction
        tied = self._regularised(operators, parts, history, edge)
        gap = self.gap(operators, history)
        bound = self.law.friction(self._slip_state(p, motion.slip, history))
        compliant, on_edge = tied.tangential
        stick = stick_condition(motion.slip, t, tied.tangential)
        slip = slip_condition(t, found.direction, bound.value)
        tangential_row = np.where((found.status == Status.STICK)[:, None], stick, slip)
        plastic = stick_condition(motion.slip, t, (compliant,))
        return ContactState(
            operators=operators,
            history=history,
            gap=gap,
            multiplier=parts,
            active_set=found,
            motion=motion,
            plastic_slip=np.where(active[:, None], plastic, 0.0),
            edge=edge,
            traction_change=t - on_edge.target,
            residuals=Residuals(
                np.where(active, normal_condition(np.where(active, gap, 0.0), p, tied.normal), 0.0),
                np.where(active[:, None], tangential_row, 0.0),
            ),
            bound=bound,
            turning=np.where(found.status == Status.SLIP, turning, 0.0),
        )

    def _slip_state(self, p: Floats, slip: Floats, history: ContactHistory) -> SlipState:
        """What friction may depend on."""
        temperature = np.full_like(p, history.temperature)
        speed: Floats = np.divide(lengths(slip), history.dt)
        return SlipState(p, speed, temperature)

    def augmented(self, c: ContactState, tolerance: Floats) -> ContactHistory | None:
        """Next estimates of an augmented Lagrangian.

        Args:
            c: State of the equilibrium with the present estimates.
            tolerance: Gap in contact and slip of sticking nodes that may stay [m], (n,).

        Returns:
            History with the estimates; None where they are good enough or the law has none.
        """
        if not self.law.augmented:
            return None
        # what the compliance still lets through; edge nodes keep the gap and slip of their ties
        estimate = np.zeros_like(c.multiplier.pressure)
        if c.history.pressure is not None:
            estimate = c.history.pressure
        change = np.abs(c.multiplier.pressure - estimate)
        gap = np.where(c.active, self.law.normal_compliance * change, 0.0)
        slip = np.where(c.status == Status.STICK, lengths(c.slip - c.plastic_slip), 0.0)
        if not ((gap > tolerance) | (slip > tolerance)).any():
            return None
        traction = transported(c.multiplier.traction, c.operators.normals.n, c.history.normals)
        before = c.history.before
        if before is None:  # the traction is that of the start until it becomes an estimate
            start = c.history.traction
            before = np.zeros_like(traction) if start is None else start
        return replace(c.history, pressure=c.multiplier.pressure, traction=traction, before=before)

    def _regularised(
        self,
        operators: MortarOperators,
        parts: Multiplier,
        history: ContactHistory,
        edge: EdgeTies,
    ) -> _Regularised:
        """Compliances and targets: of a penalty or an augmented law, and of edge nodes.

        Slip is an increment of the step, so edge nodes are tied by the change of the traction since
        its start as well: under a constant load they would creep otherwise.
        """
        law, p, t = self.law, parts.pressure, parts.traction
        estimate = np.zeros_like(p)
        if law.augmented and history.pressure is not None:
            estimate = history.pressure
        past, target = np.zeros_like(t), edge.traction_target(t)
        if history.traction is not None:
            past = transported(history.traction, history.normals, operators.normals.n)
        start = history.traction if history.before is None else history.before
        if start is not None:
            start = transported(start, history.normals, operators.normals.n)
            target = target + start - edge.traction_target(start)
        return _Regularised(
            normal=(
                Regularisation(law.normal_compliance, estimate),
                Regularisation(edge.compliance, edge.pressure_target(p)),
            ),
            tangential=(
                Regularisation(law.tangential_compliance, past),
                Regularisation(edge.compliance, target),
            ),
        )

    def _edge(self, operators: MortarOperators) -> EdgeTies:
        """Ties of edge nodes to the best covered of their neighbours."""
        mesh, normals = self.mesh, operators.normals.n
        kappa, slope = edge_compliance(operators.coverage, self.law.c)
        at = np.flatnonzero((kappa > 0.0) & mesh.has_multiplier)
        around = mesh.neighbours[at]
        coverage = np.where(mesh.has_multiplier, operators.coverage, -1.0)[around]
        coverage[around < 0] = -1.0
        best = np.argmax(coverage, axis=1) if len(at) else at
        tied = coverage[np.arange(len(at)), best] > 0.0
        nodes, neighbours = at[tied], around[np.arange(len(at)), best][tied]
        acts = np.zeros(mesh.n_nonmortar, bool)
        acts[nodes] = True
        turns = transports(normals[neighbours], normals[nodes])
        return EdgeTies(nodes, neighbours, turns, kappa * acts, slope * acts)


def _parts(multiplier: Floats, normals: Floats) -> Multiplier:
    """Pressure and traction of multipliers."""
    pressure = np.einsum("ji,ji->j", multiplier, normals)
    return Multiplier(multiplier, pressure, tangential(multiplier, normals))
