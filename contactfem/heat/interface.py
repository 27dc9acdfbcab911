"""Heat through one interface (15)-(17), (21)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from contactfem.common.place_time import Varying
from contactfem.common.time_table import Table
from contactfem.common.typing import Floats, Ints
from contactfem.heat.interface_nodes import HeatNodes
from contactfem.laws.conductance import ConductanceLaw
from contactfem.laws.frictional_heat import outflow
from contactfem.mortar.normals import nodal_normals
from contactfem.mortar.quadrature import (
    IntegrationPoints,
    integration_points,
    logarithmic_mean,
)
from contactfem.mortar.search_range import SearchRange
from contactfem.mortar.segments import find_segments
from contactfem.results.data import SurfaceHeat


@dataclass(frozen=True)
class HeatExchange:
    """What an interface adds to the heat problem at one configuration, the same on all ranks.

    Attributes:
        conduction: Power that leaves a node per temperature of another [W/m/K], (n, n).
        friction: Frictional power that enters the nodes [W/m], (n,).
        defect: Relative excess of the interpolated frictional power over that of mechanics, that it
            was then made equal to [-].
        means: ∫ N_j, and of the mortar side ∫ N_j ϑ_m, ∫ N_j h (ϑ_nm - ϑ_m) by temperatures and
            ∫ N_j d [W/m], for `at_nodes`.
    """

    conduction: sp.csr_matrix
    friction: Floats
    defect: float
    means: "NodalMeans"


@dataclass(frozen=True)
class NodalMeans:
    """Integrals with the nonmortar shape functions, to be divided by ∫ N_j.

    Attributes:
        weight: ∫ N_j da [m], (n_nonmortar,).
        mortar: ∫ N_j N_l∘P da [m], (n_nonmortar, n): temperature of the mortar side.
        flux: ∫ N_j h (N_k - N_l∘P) da [W/m/K], (n_nonmortar, n): conducted heat.
        dissipation: ∫ N_j d da [W/m], (n_nonmortar,).
    """

    weight: Floats
    mortar: sp.csr_matrix
    flux: sp.csr_matrix
    dissipation: Floats


@dataclass(frozen=True)
class HeatInterfaceLaw:
    """Laws of one interface.

    Attributes:
        conductance: h of pressure and gap; None where no heat passes.
        partition: Share of the frictional heat that enters the nonmortar side [-].
        reach: How far apart the surfaces look for each other.
        obstacle: Temperature of a rigid mortar side over time [K]; None if it conducts nothing.
        coefficient: That conductance is multiplied with, over time or over time and reference place
            of the nonmortar side; None for 1.
        by_pressure: Whether conductance depends on more than whether there is pressure.
    """

    conductance: ConductanceLaw | None
    partition: float
    reach: SearchRange
    obstacle: Table | None = None
    coefficient: Table | Varying | None = None
    by_pressure: bool = False


class HeatInterface:
    """One interface of the heat problem.

    Args:
        name: Its name.
        nodes: Its nodes.
        law: Its laws.
    """

    def __init__(self, name: str, nodes: HeatNodes, law: HeatInterfaceLaw) -> None:
        self.name, self.nodes, self.law = name, nodes, law
        comm, k = nodes.comm, len(nodes.mesh.nonmortar)
        self._facets = np.arange(k * comm.rank // comm.size, k * (comm.rank + 1) // comm.size)

    @property
    def conducts(self) -> bool:
        """Whether heat can pass: an obstacle needs a temperature for that."""
        there = not self.nodes.is_rigid or self.law.obstacle is not None
        return self.law.conductance is not None and there

    def obstacle_mean(self, times: Floats, weights: Floats) -> float:
        """Weighted sum of the obstacle's temperature at some times [K]; 0 without one."""
        if self.law.obstacle is None:
            return 0.0
        return float(weights @ [self.law.obstacle(float(t)) for t in times])

    def exchange(
        self,
        x: Floats,
        pressure: Floats | None,
        dissipation: Floats,
        power: float | None,
        t: float = 0.0,
    ) -> HeatExchange:
        """Conduction and frictional heat at one configuration; collective.

        ∫ h (ϑ_nm - ϑ_m) (δϑ_nm - δϑ_m) da and ∫ d (β δϑ_nm + (1 - β) δϑ_m) da (21), share β.
        Across a gap between curved surfaces the first area is the logarithmic mean of both sides'.

        Args:
            x: Positions of the nodes [m], (n, 2).
            pressure: p at the nonmortar nodes [Pa], (n_nonmortar,); None where nothing tells it:
                what touches is then in contact.
            dissipation: d at the nonmortar nodes [W/m²], (n_nonmortar,).
            power: Frictional power of mechanics, that ∫ d da is made equal to [W/m]; None to leave
                it.
            t: Time [s].

        Returns:
            The exchange.
        """
        mesh = self.nodes.mesh
        normals = nodal_normals(mesh, x)
        segments = find_segments(mesh, x, normals.n, self._facets, self.law.reach)
        points = integration_points(mesh, x, normals, segments)
        h = self._conductance(points, pressure, t)
        d = points.values(dissipation)
        raw = float(self._sum(np.array([np.sum(points.weight * d)]))[0])
        if power is not None and power > 0.0 and raw <= 0.0:  # where nothing is opposite
            d, raw = np.ones_like(d), 0.0
        scale, defect = self._scale(points.weight * d, raw, power)
        nodes, jump = points.jump()
        leaves = outflow(np.zeros_like(d), scale * d, self.law.partition)
        sides = (-leaves.nonmortar, jump[:, :, :2]), (-leaves.mortar, -jump[:, :, 2:])
        entering = np.concatenate(
            [np.einsum("sq,sqi->si", points.weight * q, N) for q, N in sides], axis=1
        )
        friction = np.bincount(nodes.ravel(), entering.ravel(), len(mesh.X)).astype(np.float64)
        conduction = self._matrix(nodes, nodes, jump, jump, points.weight * h)
        means = self._means(points, h, scale * d)
        return HeatExchange(conduction, self._sum(friction), defect, means)

    def _conductance(self, points: IntegrationPoints, pressure: Floats | None, t: float) -> Floats:
        """Conductance per nonmortar area at the points [W/m²/K], (s, q)."""
        if self.law.conductance is None or not self.conducts:
            return np.zeros_like(points.weight)
        p = points.touching.astype(np.float64) if pressure is None else points.values(pressure)
        h = self.law.conductance(p, points.gap).h
        if isinstance(self.law.coefficient, Varying):
            X = points.vectors(self.nodes.mesh.X)
            at = X.reshape(-1, X.shape[2]).T
            h = h * np.reshape(self.law.coefficient(at, t), h.shape)
        elif self.law.coefficient is not None:
            h = h * self.law.coefficient(t)
        return np.asarray(h * np.where(points.gap > 0.0, logarithmic_mean(points.ratio), 1.0))

    def _scale(self, load: Floats, raw: float, power: float | None) -> tuple[float, float]:
        """Factor that makes the frictional heat that of mechanics, and the defect before."""
        if power is None:
            return 1.0, 0.0
        total = float(self._sum(np.array([load.sum()]))[0])
        largest = max(abs(raw), abs(power))
        return (power / total if total > 0.0 else 1.0), (
            (raw - power) / largest if largest > 0.0 else 0.0
        )

    def _means(self, points: "IntegrationPoints", h: Floats, d: Floats) -> NodalMeans:
        """Integrals with the nonmortar shape functions; collective."""
        n = self.nodes.mesh.n_nonmortar
        nodes, jump = points.jump()
        rows, w = points.nonmortar, points.weight
        opposite = np.concatenate((np.zeros_like(points.N), -jump[:, :, 2:]), axis=2)
        sums = [
            np.bincount(rows.ravel(), np.einsum("sq,sqi->si", v, points.N).ravel(), n)
            for v in (w, w * d)
        ]
        return NodalMeans(
            self._sum(sums[0].astype(np.float64)),
            self._matrix(rows, nodes, points.N, opposite, w)[:n],
            self._matrix(rows, nodes, points.N, jump, w * h)[:n],
            self._sum(sums[1].astype(np.float64)),
        )

    def at_nodes(self, theta: Sequence[Floats], exchange: HeatExchange, t: float) -> SurfaceHeat:
        """Heat at the nonmortar nodes; collective.

        Args:
            theta: Temperatures of the bodies [K], flat local arrays.
            exchange: What it exchanges.
            t: Time, for an obstacle's temperature [s].
        """
        means = exchange.means
        at = self.nodes.gather(theta, self.obstacle_mean(np.array([t]), np.ones(1)))
        covered = means.weight > 0.0
        weight = np.where(covered, means.weight, np.nan)
        other = np.asarray(means.mortar @ at) / weight
        if self.nodes.is_rigid and self.law.obstacle is None:
            other = np.full_like(other, np.nan)
        flux, dissipation = np.asarray(means.flux @ at) / weight, means.dissipation / weight
        return SurfaceHeat(at[: len(weight)], other, flux, dissipation)

    def _matrix(
        self, rows: Ints, cols: Ints, left: Floats, right: Floats, weight: Floats
    ) -> sp.csr_matrix:
        """Sum of ∫ left right over all segments of all ranks, (n, n); collective."""
        comm, n = self.nodes.comm, len(self.nodes.mesh.X)
        values = np.einsum("sq,sqi,sqj->sij", weight, left, right).ravel()
        row = np.repeat(rows, cols.shape[1], axis=1).ravel()
        col = np.tile(cols, (1, rows.shape[1])).ravel()
        if comm.size > 1:
            parts = comm.allgather((values, row, col))
            values, row, col = (np.concatenate(part) for part in zip(*parts, strict=True))
        return sp.coo_matrix((values, (row, col)), (n, n)).tocsr()

    def _sum(self, values: Floats) -> Floats:
        """Sum over the ranks; collective."""
        total = np.empty_like(values)
        self.nodes.comm.Allreduce(values, total)
        return total
