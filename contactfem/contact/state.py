"""Contact state of the nonmortar nodes, and what a step starts from."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from contactfem.common.typing import Bools, Floats, Ints
from contactfem.contact.slip import Motion
from contactfem.laws.active_set import Status
from contactfem.laws.friction import FrictionBound
from contactfem.mortar.interface_mesh import InterfaceMesh, facet_lengths
from contactfem.mortar.normals import NormalField
from contactfem.mortar.segments import Segments
from contactfem.mortar.sparse import Sparse


@dataclass(frozen=True)
class ContactHistory:
    """What a step starts from.

    Attributes:
        D: D⁰_jj at its start [m], (n,).
        M: M⁰_jl at its start [m], (n, n_nodes).
        pressure: Estimate p̂ of an augmented law [Pa], (n,); None without.
        traction: Traction, or its estimate t̂, that a regularised law starts from [Pa], (n,).
        dt: Length of the step, for the slip speed [s].
        temperature: Of the nonmortar side, for friction that depends on it [K], one value or (n,).
    """

    D: Floats
    M: sp.csr_matrix
    pressure: Floats | None = None
    traction: Floats | None = None
    dt: float = 1.0
    temperature: Floats | float = 0.0


@dataclass(frozen=True)
class MortarOperators:
    """Mortar operators at one configuration, the same on all ranks.

    Attributes:
        x: Positions [m], (n_nodes, 2).
        normals: Normal field of the nonmortar side.
        D: D_jj [m], (n,).
        M: M_jl [m], (n, n_nodes).
        gap: Mean gap g_j / D_jj [m], (n,); infinite where nothing is covered.
        full: D_jj of wholly covered facets [m], (n,).
        length: Half the length of the facets at each node [m], (n,): `full` without an axis.
        segments: This rank's segments.
        mesh: The two surfaces.
    """

    x: Floats
    normals: NormalField
    D: Floats
    M: sp.csr_matrix
    gap: Floats
    full: Floats
    length: Floats
    segments: Segments
    mesh: InterfaceMesh

    @cached_property
    def full_derivative(self) -> Sparse:
        """D full / dx [-], (n, 2 n_nodes)."""
        return facet_lengths(self.mesh, self.x)[1]

    @property
    def coverage(self) -> Floats:
        """Covered share f of each node's facets [-]."""
        return self.D / self.full

    @property
    def depth(self) -> Floats:
        """What a length of facet stands for at each node [m]: 1, or about the circumference."""
        return self.full / self.length


@dataclass(frozen=True)
class ContactState:
    """Contact conditions at one state, the same on all ranks; n nonmortar nodes.

    Attributes:
        operators: Where they were evaluated.
        history: Operators at the start of the step.
        multiplier: λ_j, zero where open [Pa], (n, 2).
        pressure: p_j [Pa], (n,).
        traction: t_j [Pa], (n,).
        motion: Of the two sides since the start of the step, of all nodes.
        slip: Slip increment of the step [m], (n,).
        plastic_slip: The part of it that dissipates [m], (n,).
        status: `Status` of each node, (n,).
        direction: Slip direction (-1, 0, 1), (n,).
        rim: Neighbour that the rim rule ties to, itself where it does not act, (n,).
        kappa: Rim compliance [m/Pa], (n,).
        kappa_slope: dκ/df [m/Pa], (n,).
        rim_traction: Change of t_j - t_k since the start of the step [Pa], (n,).
        normal_row: Residual of the normal condition [m], (n,).
        tangential_row: Residual of the tangential condition: stick [m], slip [Pa], (n,).
        limit: Largest traction and its derivatives, (n,) each.
    """

    operators: MortarOperators
    history: ContactHistory
    multiplier: Floats
    pressure: Floats
    traction: Floats
    motion: Motion
    slip: Floats
    plastic_slip: Floats
    status: NDArray[np.int8]
    direction: Floats
    rim: Ints
    kappa: Floats
    kappa_slope: Floats
    edge_traction: Floats
    normal_row: Floats
    tangential_row: Floats
    limit: FrictionBound

    @property
    def active(self) -> Bools:
        """Nodes in contact, (n,)."""
        return np.asarray(self.status > Status.OPEN)

    def nodal_forces(self) -> Floats:
        """Forces on the nodes, Gᵀλ = (D_jj λ_j, -Σ_j M_jl λ_j) [N/m], (n_nodes, 2)."""
        force = -(self.operators.M.T @ self.multiplier)
        force[: len(self.multiplier)] += self.operators.D[:, None] * self.multiplier
        return np.asarray(force)
