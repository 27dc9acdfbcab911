"""Estimated errors of stress and heat flux (32)-(36)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from contactfem.adaptivity.body_recovery import BodyErrors, BodyRecovery, RecoveredField
from contactfem.adaptivity.boundary_data import (
    cartesian_rows,
    heat_flows,
    tractions,
    vertex_conditions,
    vertex_normals,
)
from contactfem.adaptivity.recovery.constraints import ConstraintRows, heat_flow_rows, traction_rows
from contactfem.adaptivity.recovery.interface import (
    MechanicalState,
    ThermalState,
    closest,
    recover_heat_flux,
    recover_stress,
)
from contactfem.adaptivity.recovery.norms import elastic_compliance, sample_points
from contactfem.case.schema import Case
from contactfem.common.typing import Bools, Floats, Ints
from contactfem.contact.state import ContactState
from contactfem.discretisation.discretise import Discretisation
from contactfem.fem.compat import CellExpression
from contactfem.fem.gathered_mesh import MeshView
from contactfem.fem.vertex_values import VertexValues
from contactfem.heat.body import HeatBody
from contactfem.heat.interface import HeatExchange
from contactfem.mechanics.body import BodyProblem
from contactfem.results.relative_error import RelativeError

PLANE = (0, 1, 2, 3)  # xx, yy, zz, xy of the six stress components
TOUCHED = 0.5  # share of the nonmortar nodes opposite that make a mortar node active


def total(bodies: Sequence[BodyErrors]) -> RelativeError:
    """Relative error of all bodies together, (40)."""
    return sum((body.total for body in bodies), RelativeError(0.0, 0.0))


@dataclass(frozen=True)
class _Body:
    """What estimates need of a body: recovery on its mesh, its field, and values at vertices."""

    of: BodyProblem | HeatBody
    recovery: BodyRecovery
    field: CellExpression
    u: VertexValues


class StressEstimator:
    """Errors of the stress in the complementary energy norm, σ·C⁻¹σ per current volume.

    Args:
        case: The case.
        discretisation: Its bodies and interfaces.
        before: An estimator of which is taken what was made for bodies that are the same.
    """

    def __init__(
        self, case: Case, discretisation: Discretisation, before: "StressEstimator | None" = None
    ) -> None:
        self._case, self._discretisation = case, discretisation
        known = {} if before is None else before._bodies
        self._bodies: dict[str, _Body] = {
            name: known[name]
            if name in known and known[name].of is body
            else self._made(name, body)
            for name, body in discretisation.bodies.items()
        }

    def _made(self, name: str, body: BodyProblem) -> _Body:
        case, comm = self._case, self._discretisation.system.comm
        material = case.materials[case.bodies[name].main_material]
        view = MeshView.of(comm, body.mesh)
        metric = elastic_compliance(material.E, material.nu)
        return _Body(
            body,
            BodyRecovery(name, view, metric, axisymmetric=case.axisymmetric),
            body.stress_at(sample_points(view.data.cells.shape[1])),
            VertexValues(comm, body.mesh, body.vertex_space),
        )

    def __call__(self, conditions: Sequence[ContactState], t: float) -> list[BodyErrors]:
        """Errors at the bodies' present displacement, per body; collective.

        Args:
            conditions: Of every interface.
            t: Time [s].
        """
        case, fields = self._case, {}
        for name, body in self._discretisation.bodies.items():
            own = self._bodies[name]
            recovery, x = own.recovery, own.recovery.points
            if case.strain == "finite":
                x = x + own.u.replicate(body.u.x.array)
            values = recovery.view.cells(own.field.values()[:, :, PLANE])
            field = fields[name] = RecoveredField(recovery, x, values)
            known = tractions(case, name, recovery.view, x, t)
            rows = vertex_conditions(recovery.view.boundary, x, known, cartesian_rows, len(PLANE))
            field.require(rows)
        for interface, c in zip(self._discretisation.interfaces, conditions, strict=True):
            self._join(interface.name, c, fields)
        return [field.errors() for field in fields.values()]

    def _join(self, name: str, c: ContactState, fields: Mapping[str, RecoveredField]) -> None:
        """Fit both sides of an interface together, (34) and (36)."""
        case, sides = self._case, self._case.interfaces[name]
        has_friction = sides.friction is not None
        first = _Place(fields, sides.nonmortar)
        own = MechanicalState(first.normals, c.active, np.full(len(c.active), not has_friction))
        if sides.mortar in case.obstacles:
            first.field.require(_on_obstacle(first.vertices, own))
            return
        second = _Place(fields, sides.mortar)
        touched = _touched(c)
        other = MechanicalState(second.normals, touched, np.full(len(touched), not has_friction))
        patches = first.field.side(first.surface), second.field.side(second.surface)
        fits = recover_stress(*patches, own), recover_stress(*patches[::-1], other)
        for place, fit in zip((first, second), fits, strict=True):
            place.field.join(place.vertices, fit)


class FluxEstimator:
    """Errors of the heat flux in the norm q·q/k per current volume.

    Args:
        case: The case.
        discretisation: Its heat side.
        before: An estimator of which is taken what was made for bodies that are the same.
    """

    def __init__(
        self, case: Case, discretisation: Discretisation, before: "FluxEstimator | None" = None
    ) -> None:
        assert discretisation.heat is not None
        self._case, self._thermal = case, discretisation.heat
        known = {} if before is None else {id(own.of): own for own in before._bodies}
        self._bodies: list[_Body] = [
            known[id(body)] if id(body) in known else self._made(body)
            for body in self._thermal.bodies
        ]
        comm = discretisation.system.comm
        self._theta = [VertexValues(comm, body.mesh, body.V) for body in self._thermal.bodies]

    def _made(self, body: HeatBody) -> _Body:
        case, comm = self._case, self._thermal.system.comm
        view = MeshView.of(comm, body.mesh)
        metric = np.asarray(np.eye(2) / body.law.conductivity)
        return _Body(
            body,
            BodyRecovery(body.name, view, metric, axisymmetric=case.axisymmetric),
            body.flux_at(sample_points(view.data.cells.shape[1])),
            VertexValues(comm, body.mesh, body.displacement_space),
        )

    def __call__(
        self, theta: Sequence[Floats], exchanges: Sequence[HeatExchange], t: float
    ) -> list[BodyErrors]:
        """Errors of temperatures in the present configuration, per body; collective.

        Args:
            theta: Temperatures [K], flat local arrays of the bodies.
            exchanges: Heat through the interfaces.
            t: Time [s].
        """
        case, fields = self._case, {}
        for k, body in enumerate(self._thermal.bodies):
            own = self._bodies[k]
            recovery, x = own.recovery, own.recovery.points
            if body.deforms:
                x = x + own.u.replicate(body.u.x.array)
            body.theta.x.array[:] = theta[k]
            values = recovery.view.cells(own.field.values())
            field = fields[body.name] = RecoveredField(recovery, x, values)
            at_vertices = self._theta[k].replicate(theta[k])[:, 0]
            known = heat_flows(case, body.name, recovery.view, at_vertices, t)
            rows = vertex_conditions(recovery.view.boundary, x, known, heat_flow_rows, 2)
            field.require(rows)
        for link, exchange in zip(self._thermal.interfaces, exchanges, strict=True):
            if not link.heat.nodes.is_rigid:
                self._join(link.heat.name, exchange, fields)
        return [field.errors() for field in fields.values()]

    def _join(
        self, name: str, exchange: HeatExchange, fields: Mapping[str, RecoveredField]
    ) -> None:
        """Fit both sides of an interface together, (35) and (36)."""
        sides, means = self._case.interfaces[name], exchange.means
        first, second = (_Place(fields, side) for side in (sides.nonmortar, sides.mortar))
        n = len(first.vertices)
        heat = means.dissipation / np.where(means.weight > 0.0, means.weight, 1.0)
        moved = abs(means.flux) + abs(means.mortar).multiply(abs(heat)[:, None])
        passes = moved.sum(axis=1).A1 > 0.0, moved.sum(axis=0).A1[n:] > 0.0
        opposite = heat[closest(second.x, first.x)]
        patches = first.field.side(first.surface), second.field.side(second.surface)
        fits = (
            recover_heat_flux(*patches, _thermal_state(first, passes[0], heat)),
            recover_heat_flux(*patches[::-1], _thermal_state(second, passes[1], opposite)),
        )
        for place, fit in zip((first, second), fits, strict=True):
            place.field.join(place.vertices, fit)


class _Place:
    """One side "body.surface" of an interface: field, vertices, their positions and normals."""

    def __init__(self, fields: Mapping[str, RecoveredField], side: str) -> None:
        owner, _, self.surface = side.partition(".")
        self.field = fields[owner]
        data = self.field.recovery.view.data
        self.vertices = data.surface(self.surface).vertices
        self.x = self.field.x[self.vertices]
        self.normals = vertex_normals(data.groups[self.surface], self.field.x, self.vertices)


def _thermal_state(place: _Place, passes: Bools, heat: Floats) -> ThermalState:
    return ThermalState(place.normals, passes, heat, np.zeros(len(place.vertices)))


def _touched(c: ContactState) -> Bools:
    """Mortar nodes that touch: at least half of what is opposite does."""
    M = c.operators.M[:, len(c.status) :]
    share, whole = M.T @ c.active.astype(np.float64), np.asarray(M.sum(axis=0)).ravel()
    return np.asarray((whole > 0.0) & (share > TOUCHED * whole))


def _on_obstacle(vertices: Ints, state: MechanicalState) -> ConstraintRows:
    """On an obstacle: no traction where open, no tangential one without friction."""
    rows = traction_rows(state.normals)
    known = np.column_stack((~state.active, ~state.active | state.frictionless)).ravel()
    flat = rows.reshape(-1, rows.shape[2])[known]
    return ConstraintRows(np.repeat(vertices, 2)[known], flat, np.zeros(int(known.sum())))
