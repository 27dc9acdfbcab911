"""Contact state of the nonmortar nodes, and what a step starts from."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from contactfem.common.typing import Bools, Floats, Ints
from contactfem.contact.slip import Motion, tangential
from contactfem.laws.active_set import ActiveSet, Status
from contactfem.laws.friction import FrictionBound
from contactfem.mortar.mortar_operators import MortarOperators

BARELY = 1e-3  # coverage below which λ_j = -R_j / D_jj has lost its digits


@dataclass(frozen=True)
class ContactHistory:
    """What a step starts from.

    Attributes:
        D: D⁰_jj at its start, (n,).
        M: M⁰_jl at its start, (n, n_nodes).
        normals: Unit normals at its start, that the traction is tangential to, (n, dim).
        x: Positions of the nodes of both sides at its start [m], (n_nodes, dim).
        pressure: Estimate p̂ of an augmented law [Pa], (n,); None without.
        traction: Traction, or its estimate t̂, that a regularised law starts from [Pa], (n, dim);
            None for zero.
        before: Traction at its start where `traction` is an estimate [Pa], (n, dim); else None.
        dt: Length of the step, for the slip speed [s].
        temperature: Of the nonmortar side, for friction that depends on it [K], one value or (n,).
        offset: By how much the surfaces stand farther out than their meshes at the end of the step
            [m]: an interference, or if negative a clearance.
    """

    D: Floats
    M: sp.csr_matrix
    normals: Floats
    x: Floats
    pressure: Floats | None = None
    traction: Floats | None = None
    before: Floats | None = None
    dt: float = 1.0
    temperature: Floats | float = 0.0
    offset: float = 0.0

    @staticmethod
    def at(operators: MortarOperators) -> "ContactHistory":
        """That of a step which starts from some positions, without tractions."""
        return ContactHistory(operators.D, operators.M, operators.normals.n, operators.x)


@dataclass(frozen=True)
class Multiplier:
    """Contact traction λ_j as equilibrium or the unknowns give it, zero where open.

    Attributes:
        vector: λ_j [Pa], (n, dim).
        pressure: p_j = n_j·λ_j [Pa], (n,).
        traction: t_j = λ_j - p_j n_j [Pa], (n, dim).
    """

    vector: Floats
    pressure: Floats
    traction: Floats


@dataclass(frozen=True)
class EdgeTies:
    """Edge stabilisation: which nodes are tied to which, and how.

    Attributes:
        nodes: Edge nodes that are tied, (m,).
        neighbours: The better covered node that each is tied to, (m,).
        turns: Turns of tangential vectors of the neighbours into the planes of the nodes,
            (m, dim, dim).
        compliance: κ of all nodes, zero where they are not tied [m/Pa], (n,).
        slope: dκ/df [m/Pa], (n,).
    """

    nodes: Ints
    neighbours: Ints
    turns: Floats
    compliance: Floats
    slope: Floats

    def pressure_target(self, p: Floats) -> Floats:
        """The neighbour's pressure, or a node's own [Pa], (n,)."""
        result = p.copy()
        result[self.nodes] = p[self.neighbours]
        return result

    def traction_target(self, t: Floats) -> Floats:
        """The neighbour's traction in the node's plane, or a node's own [Pa], (n, dim)."""
        result = t.copy()
        result[self.nodes] = np.einsum("mik,mk->mi", self.turns, t[self.neighbours])
        return result


@dataclass(frozen=True)
class Residuals:
    """What is left of the conditions of nodes in contact.

    Attributes:
        normal: Of the normal condition [m], (n,).
        tangential: Of the tangential condition: stick [m], slip [Pa], (n, dim).
    """

    normal: Floats
    tangential: Floats


@dataclass(frozen=True)
class ContactState:
    """Contact at one configuration, the same on all ranks; n nonmortar nodes.

    Attributes:
        operators: Where it was evaluated.
        history: What the step started from.
        gap: Gap that the conditions see [m], (n,); infinite where nothing is covered.
        multiplier: λ_j and its parts, as the equations see them.
        active_set: Status and slip direction.
        motion: Of the two sides since the start of the step, of all nodes.
        plastic_slip: The part of the slip that dissipates [m], (n, dim).
        edge: Ties of edge nodes.
        traction_change: t_j - T t_k of tied nodes since the start of the step [Pa], (n, dim).
        residuals: Of the conditions.
        bound: Largest traction and its derivatives, (n,) each.
        turning: Share ε of the change of t* across the slip direction that turns it [-], (n,).
    """

    operators: MortarOperators
    history: ContactHistory
    gap: Floats
    multiplier: Multiplier
    active_set: ActiveSet
    motion: Motion
    plastic_slip: Floats
    edge: EdgeTies
    traction_change: Floats
    residuals: Residuals
    bound: FrictionBound
    turning: Floats

    @property
    def status(self) -> NDArray[np.int8]:
        """`Status` of each node, (n,)."""
        return self.active_set.status

    @cached_property
    def active(self) -> Bools:
        """Nodes in contact, (n,)."""
        return self.active_set.active

    @property
    def slip(self) -> Floats:
        """Slip increment of the step of nodes in contact [m], (n, dim)."""
        return np.where(self.active[:, None], self.motion.slip, 0.0)

    @cached_property
    def _barely(self) -> Bools:
        """Which of the tied nodes are barely covered, so that λ_j = -R_j / D_jj has no digits."""
        at = self.edge.nodes
        return np.asarray(self.active[at] & (self.operators.coverage[at] < BARELY))

    @cached_property
    def pressure(self) -> Floats:
        """Pressure, of barely covered nodes p_k - g_j/κ_j as they are tied [Pa], (n,).

        λ_j = -R_j / D_jj loses all digits as D_jj ~ coverage² vanishes; the tie, exact at
        convergence, does not.
        """
        at, k = self.edge.nodes[self._barely], self.edge.neighbours[self._barely]
        p = self.multiplier.pressure
        result = p.copy()
        result[at] = p[k] - self.operators.gap[at] / self.edge.compliance[at]
        return result

    @cached_property
    def traction(self) -> Floats:
        """Traction, of barely covered nodes that of the neighbour [Pa], (n, dim).

        The terms of slip that the tie would add vanish with 1/κ_j.
        """
        at = self.edge.nodes[self._barely]
        result = self.multiplier.traction.copy()
        result[at] = self.edge.traction_target(self.multiplier.traction)[at]
        return result

    @property
    def dissipation(self) -> Floats:
        """Frictional work of the step, D_jj t_j·v_j, with the traction of the equations, (n,).

        v is the motion that friction works on, `rubbed`.
        """
        along = np.einsum("ji,ji->j", self.multiplier.traction, self.rubbed)
        return np.asarray(self.operators.D * along)

    @cached_property
    def rubbed(self) -> Floats:
        """Motion of both sides in the step that friction works on [m], (n, dim).

        v_j = (1 - n nᵀ) (Δx_j - Σ_l M_jl Δx_l / D_jj) less its elastic part: force times v is what
        both sides lose, also where a node was not covered when the step began. It is the slip from
        the other end of the step; where it points against the traction, by a turn within the step,
        slip stands for it. Nodes that stick dissipate nothing.
        """
        op, covered = self.operators, self.operators.D > 0.0
        D = np.where(covered, op.D, 1.0)[:, None]
        moved = op.x - self.history.x
        across = moved[: len(D)] - op.M @ moved / D
        elastic = self.motion.slip - self.plastic_slip
        path = tangential(across, op.normals.n) - elastic
        slip = self.plastic_slip * self.history.D[:, None] / D
        forward = np.einsum("ji,ji->j", self.multiplier.traction, path) >= 0.0
        rubs = self.active_set.direction.any(axis=1)  # without friction slip has no direction
        slides = self.active & (self.status == Status.SLIP) & covered & rubs
        return np.where(slides[:, None], np.where(forward[:, None], path, slip), 0.0)

    def nodal_forces(self) -> Floats:
        """Forces on the nodes, Gᵀλ = (D_jj λ_j, -Σ_j M_jl λ_j), (n_nodes, dim)."""
        force = -(self.operators.M.T @ self.multiplier.vector)
        force[: len(self.active)] += self.operators.D[:, None] * self.multiplier.vector
        return np.asarray(force)

    def as_history(self) -> ContactHistory:
        """What the next step starts from."""
        op = self.operators
        pressure, traction = self.multiplier.pressure, self.multiplier.traction
        return ContactHistory(op.D, op.M, op.normals.n, op.x, pressure, traction)
