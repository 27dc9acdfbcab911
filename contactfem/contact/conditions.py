"""Contact conditions at the nonmortar nodes of one interface."""

from dataclasses import dataclass, field, replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from mpi4py import MPI

from contactfem.common.typing import Floats, Ints
from contactfem.contact.slip import Motion, motion
from contactfem.contact.state import ContactHistory, ContactState, MortarOperators
from contactfem.laws.active_set import ActiveSet, Status
from contactfem.laws.complementarity import Regularisation, stick_or_slip, trial
from contactfem.laws.edge_stabilisation import edge_compliance
from contactfem.laws.friction import FrictionLaw, SlipState, frictionless
from contactfem.mortar.interface_mesh import (
    InterfaceMesh,
    full_lengths,
    half_lengths,
)
from contactfem.mortar.normals import NormalField, nodal_normals
from contactfem.mortar.operators import D_ENTRY, GAP_ENTRY, assemble
from contactfem.mortar.segments import cut, find_pairs


@dataclass(frozen=True)
class ContactLaw:
    """Numbers of the laws of one interface.

    Attributes:
        friction: Largest traction as a function of the slip state; `frictionless` for none.
        c: Scale between gap and pressure [Pa/m], shape (n_nonmortar,).
        c_n: Factor on c in the trial pressure [-].
        c_t: Factor on c in the trial traction [-].
        stiffness: Softer Young's modulus of the two sides [Pa].
        search_radius: How far apart the surfaces look for each other [m].
        normal_compliance: 1/ε_N of a penalty (13) [m/Pa], (n_nonmortar,); zero for exact contact.
        tangential_compliance: 1/c_T of regularised friction [m/Pa], likewise.
        augmented: Whether estimates of pressure and traction take the compliance's place.
    """

    friction: FrictionLaw
    c: Floats
    c_n: float
    c_t: float
    stiffness: float
    search_radius: float
    normal_compliance: Floats = field(default_factory=lambda: np.zeros(1))
    tangential_compliance: Floats = field(default_factory=lambda: np.zeros(1))
    augmented: bool = False

    @property
    def has_friction(self) -> bool:
        """Whether there is friction."""
        return self.friction is not frictionless


class Contact:
    """One interface: evaluates the contact conditions and their tangent.

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
        """Search, cut and integrate at the positions x [m], (n_nodes, 2); collective."""
        mesh, n = self.mesh, self.mesh.n_nonmortar
        normals = nodal_normals(mesh, x)
        pairs = find_pairs(mesh, x, normals.n, self.my_facets, self.law.search_radius)
        segments = cut(mesh, x, normals.n, pairs, differentiate=False)
        mine = assemble(mesh, x, segments, normals)
        row, col, value = (
            np.concatenate(self.comm.allgather(part)) if self.comm.size > 1 else part
            for part in (mine.row, mine.col, mine.value)
        )
        D: Floats = np.bincount(row[col == D_ENTRY], value[col == D_ENTRY], n).astype(np.float64)
        weighted = np.bincount(row[col == GAP_ENTRY], value[col == GAP_ENTRY], n)
        at = col >= 0
        M = sp.coo_matrix((value[at], (row[at], col[at])), (n, mesh.n_nodes)).tocsr()
        gap = np.divide(weighted, D, out=np.full(n, np.inf), where=D > 0.0)
        full, length = full_lengths(mesh, x), half_lengths(mesh, x)
        return MortarOperators(x, normals, D, M, gap, full, length, segments, mesh)

    def conditions(
        self, operators: MortarOperators, multiplier: Floats, history: ContactHistory
    ) -> ContactState:
        """Status of every node from its trial state, and the residuals of the conditions.

        Args:
            operators: At the current positions.
            multiplier: λ_j of every node as equilibrium gives it [Pa], (n_nonmortar, 2).
            history: Operators at the start of the step.

        Returns:
            The conditions.
        """
        law = self.law
        p, t = _components(multiplier, operators.normals)
        rim, kappa, slope = self._rim(operators)
        seen = np.isfinite(operators.gap)
        gap = np.where(seen, operators.gap, 0.0)
        moved = relative_motion(operators, history)
        slip = moved.slip
        estimate = self._estimates(history)
        normal = Regularisation(law.normal_compliance, estimate[0]), Regularisation(kappa, p[rim])
        before = self._before(history, rim)
        tangential = (
            Regularisation(law.tangential_compliance, estimate[1]),
            Regularisation(kappa, t[rim] + before),
        )
        p_trial = np.where(seen, trial(p, -gap, law.c_n * law.c, normal), 0.0)
        t_trial = trial(t, slip, law.c_t * law.c, tangential)
        limit = law.friction(self._slip_state(p_trial, slip, history)).value
        found = stick_or_slip(p_trial, t_trial, limit, law.has_friction)
        status = np.where(self.mesh.has_multiplier, found.status, Status.NONE).astype(np.int8)
        return self._rows(
            operators, history, multiplier, moved, status, found.direction, (rim, kappa, slope),
        )  # fmt: skip

    def imposed(
        self,
        operators: MortarOperators,
        multiplier: Floats,
        history: ContactHistory,
        start: ActiveSet,
    ) -> ContactState:
        """As `conditions`, with a given status instead of the trial one.

        Args:
            operators: At the current positions.
            multiplier: λ_j [Pa], (n_nonmortar, 2).
            history: Operators at the start of the step.
            start: Status and slip direction; what is not covered is open all the same.

        Returns:
            The conditions.
        """
        moved = relative_motion(operators, history)
        status = np.where(operators.D > 0.0, start.status, Status.OPEN)
        status = np.where(self.mesh.has_multiplier, status, Status.NONE).astype(np.int8)
        direction = np.where(status == Status.SLIP, start.direction, 0.0)
        return self._rows(
            operators, history, multiplier, moved, status, direction, self._rim(operators)
        )

    def _rows(
        self,
        operators: MortarOperators,
        history: ContactHistory,
        multiplier: Floats,
        moved: Motion,
        status: NDArray[np.int8],
        direction: Floats,
        rim_rule: tuple[Ints, Floats, Floats],
    ) -> ContactState:
        """Residuals of the conditions that belong to a status."""
        (rim, kappa, slope), slip = rim_rule, moved.slip
        # A node that was not covered before this step has no slip: it follows its neighbour.
        new = (status > Status.OPEN) & ~moved.seen
        status = np.where(new, Status.SLIP, status).astype(np.int8)
        direction = np.where(new, direction[rim], direction)
        active = status > Status.OPEN
        multiplier = np.where(active[:, None], multiplier, 0.0)
        p, t = _components(multiplier, operators.normals)
        gap = np.where(active, operators.gap, 0.0)
        estimate = self._estimates(history)
        elastic = self.law.tangential_compliance * (t - estimate[1])
        normal_row = gap + kappa * (p - p[rim]) + self.law.normal_compliance * (p - estimate[0])
        edge_traction = t - t[rim] - self._before(history, rim)
        stick_row = slip - kappa * edge_traction - elastic
        limit = self.law.friction(self._slip_state(p, slip, history))
        slip_row = t - direction * limit.value
        tangential_row = np.where(status == Status.STICK, stick_row, slip_row)
        return ContactState(
            operators, history, multiplier, p, t, moved, np.where(active, slip, 0.0),
            np.where(active, slip - elastic, 0.0), status, direction, rim, kappa, slope,
            edge_traction,
            np.where(active, normal_row, 0.0), np.where(active, tangential_row, 0.0), limit,
        )  # fmt: skip

    def _slip_state(self, p: Floats, slip: Floats, history: ContactHistory) -> SlipState:
        """What friction may depend on."""
        temperature = np.full_like(p, history.temperature)
        return SlipState(p, np.abs(slip) / history.dt, temperature)

    def augmented(self, c: ContactState, tolerance: Floats) -> ContactHistory | None:
        """Next estimates of an augmented Lagrangian.

        Args:
            c: Conditions of the equilibrium with the present estimates.
            tolerance: Gap in contact and slip of sticking nodes that may stay [m], (n,).

        Returns:
            History with the estimates; None where they are good enough or the law has none.
        """
        if not self.law.augmented:
            return None
        gap = np.where(c.active, np.abs(c.operators.gap), 0.0)
        slip = np.where(c.status == Status.STICK, np.abs(c.slip), 0.0)
        if not ((gap > tolerance) | (slip > tolerance)).any():
            return None
        return replace(c.history, pressure=c.pressure, traction=c.traction)

    @staticmethod
    def _before(history: ContactHistory, rim: Ints) -> Floats:
        """t_j - t_k at the start of the step [Pa].

        Slip is an increment of the step, so the rim rule must tie it to an increment as well:
        under a constant load it would let a node creep otherwise.
        """
        t = np.zeros(len(rim)) if history.traction is None else history.traction
        return np.asarray(t - t[rim])

    def _estimates(self, history: ContactHistory) -> tuple[Floats, Floats]:
        """Values that compliances tie to: p̂, zero unless augmented, and t̂ [Pa]."""
        zero = np.zeros(self.mesh.n_nonmortar)
        pressure = history.pressure if self.law.augmented else None
        return (
            zero if pressure is None else pressure,
            zero if history.traction is None else history.traction,
        )

    def _rim(self, operators: MortarOperators) -> tuple[Ints, Floats, Floats]:
        """Rim rule: the better covered neighbour of every node, κ and dκ/df."""
        kappa, slope = edge_compliance(operators.coverage, self.law.c)
        own = np.arange(self.mesh.n_nonmortar)
        nodes = np.where(self.mesh.neighbours < 0, own[:, None], self.mesh.neighbours)
        coverage = np.where(self.mesh.has_multiplier, operators.coverage, -1.0)[nodes]
        coverage[nodes == own[:, None]] = -1.0
        best = np.argmax(coverage, 1)
        acts = (kappa > 0.0) & (coverage[own, best] > 0.0) & self.mesh.has_multiplier
        return np.where(acts, nodes[own, best], own), kappa * acts, slope * acts


def relative_motion(operators: MortarOperators, history: ContactHistory) -> Motion:
    """Relative motion of the two sides from the start of the step to where operators are."""
    before = history.D, history.M
    return motion(operators.x, operators.normals.tangent, operators.M, before)


def _components(multiplier: Floats, normals: NormalField) -> tuple[Floats, Floats]:
    """Pressure λ·n and traction λ·τ [Pa]."""
    return (
        np.einsum("ji,ji->j", multiplier, normals.n),
        np.einsum("ji,ji->j", multiplier, normals.tangent),
    )
