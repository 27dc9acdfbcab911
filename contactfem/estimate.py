"""Estimated errors of stress and heat flux on the meshes of a run, (32)-(36), on all ranks."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contactfem.boundary_data import (
    Floats,
    Ints,
    cartesian_rows,
    heat_flows,
    tractions,
    vertex_conditions,
    vertex_normals,
)
from contactfem.case import Case
from contactfem.constrained_recovery import heat_flow_rows, with_conditions
from contactfem.contact import Conditions
from contactfem.discretise import Discretisation
from contactfem.heat_interface import HeatExchange
from contactfem.interface_recovery import (
    MechanicalState,
    Side,
    ThermalState,
    closest,
    recover_heat_flux,
    recover_stress,
)
from contactfem.mesh_view import MeshView
from contactfem.recovery import Patches, patches
from contactfem.relative_error import RelativeError
from contactfem.space_error import (
    around_axis,
    elastic_compliance,
    quadrature,
    squared_errors,
    squared_norms,
)
from contactfem.transfer import VertexValues

PLANE = (0, 1, 2, 3)  # xx, yy, zz, xy of the six stress components


@dataclass(frozen=True)
class BodyErrors:
    """Errors of the cells of one body's mesh, the same on all ranks.

    Attributes:
        view: The mesh.
        errors: ‖e‖² of each cell, (m,).
        norms: ‖v‖² of each cell, (m,).
    """

    view: MeshView
    errors: Floats
    norms: Floats

    @property
    def total(self) -> RelativeError:
        """Of the whole body."""
        return RelativeError(float(self.errors.sum()), float(self.norms.sum()))


def total(bodies: Sequence[BodyErrors]) -> RelativeError:
    """Relative error of all bodies together, (40)."""
    return sum((body.total for body in bodies), RelativeError(0.0, 0.0))


@dataclass
class _Field:
    """A body's discrete field, its patches and their polynomials."""

    view: MeshView
    x: Floats
    samples: Floats
    patches: Patches
    coefficients: Floats

    def side(self, vertices: Ints) -> Side:
        """Patches of some vertices alone."""
        return Side(patches(self.x, self.view.data.cells, vertices), self.coefficients[vertices])

    def errors(self, metric: Floats, *, axisymmetric: bool) -> BodyErrors:
        """Distance of the recovered field from the discrete one."""
        cells = self.view.data.cells
        rule = quadrature(self.x, cells)
        rule = around_axis(rule) if axisymmetric else rule
        recovered = self.coefficients[:, 0]
        return BodyErrors(
            self.view,
            squared_errors(rule, cells, recovered, self.samples, metric),
            squared_norms(rule, self.samples, metric),
        )


class StressEstimator:
    """Errors of the stress in the complementary energy norm, σ·C⁻¹σ per current volume.

    Args:
        case: The case.
        discretisation: Its bodies and interfaces.
    """

    def __init__(self, case: Case, discretisation: Discretisation) -> None:
        self._case, self._discretisation = case, discretisation
        comm, bodies = discretisation.system.comm, discretisation.bodies
        self._views = {name: MeshView.of(comm, body.mesh) for name, body in bodies.items()}
        self._u = {
            name: VertexValues(comm, body.mesh, body.vertex_space) for name, body in bodies.items()
        }

    def __call__(self, conditions: Sequence[Conditions], t: float) -> list[BodyErrors]:
        """Errors at the bodies' present displacement, per body; collective.

        Args:
            conditions: Of every interface.
            t: Time [s].
        """
        case, fields = self._case, {}
        for name, body in self._discretisation.bodies.items():
            view = self._views[name]
            x = view.data.points
            if case.strain == "finite":
                x = x + self._u[name].replicate(body.u.x.array)
            samples = view.cells(body.cell_stress()[:, PLANE])
            field = _fitted(view, x, samples)
            known = tractions(case, name, view, x, t)
            rows = vertex_conditions(view.boundary, x, known, cartesian_rows, len(PLANE))
            field.coefficients = with_conditions(field.patches, field.coefficients, rows)
            fields[name] = field
        for interface, c in zip(self._discretisation.interfaces, conditions, strict=True):
            self._join(interface.name, c, fields)
        result = []
        for name, field in fields.items():
            material = case.materials[case.bodies[name].material]
            metric = elastic_compliance(material.E, material.nu)
            result.append(field.errors(metric, axisymmetric=case.axisymmetric))
        return result

    def _join(self, name: str, c: Conditions, fields: dict[str, _Field]) -> None:
        """Fit both sides of an interface together, (34) and (36)."""
        case = self._case
        sides = case.interfaces[name]
        n = len(c.status)
        touched = np.asarray(c.operators.M.T @ c.active.astype(np.float64))[n:] > 0.0
        active = {sides.nonmortar: c.active, sides.mortar: touched}
        rubs = sides.friction is not None
        on_bodies = [side for side in (sides.nonmortar, sides.mortar) if side not in case.obstacles]
        places = {side: _place(fields, side) for side in on_bodies}
        for side in on_bodies:
            field, vertices, normals = places[side]
            state = MechanicalState(normals, active[side], np.full(len(vertices), not rubs))
            other = next((s for s in on_bodies if s != side), None)
            if other is None:
                _free_of_traction(field, vertices, state)
                continue
            opposite = places[other]
            fit = recover_stress(field.side(vertices), opposite[0].side(opposite[1]), state)
            field.coefficients[vertices, 0] = fit.standard.values


class FluxEstimator:
    """Errors of the heat flux in the norm q·q/k per current volume.

    Args:
        case: The case.
        discretisation: Its heat side.
    """

    def __init__(self, case: Case, discretisation: Discretisation) -> None:
        assert discretisation.heat is not None
        self._case, self._thermal = case, discretisation.heat
        comm = discretisation.system.comm
        bodies = self._thermal.bodies
        self._views = {body.name: MeshView.of(comm, body.mesh) for body in bodies}
        self._u = [VertexValues(comm, body.mesh, body.displacement_space) for body in bodies]
        self._theta = [VertexValues(comm, body.mesh, body.V) for body in bodies]

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
            view = self._views[body.name]
            x = view.data.points
            if body.deforms:
                x = x + self._u[k].replicate(body.u.x.array)
            body.theta.x.array[:] = theta[k]
            field = _fitted(view, x, view.cells(body.cell_flux()))
            known = heat_flows(case, body.name, view, self._theta[k].replicate(theta[k])[:, 0], t)
            rows = vertex_conditions(view.boundary, x, known, heat_flow_rows, x.shape[1])
            field.coefficients = with_conditions(field.patches, field.coefficients, rows)
            fields[body.name] = field
        for link, exchange in zip(self._thermal.interfaces, exchanges, strict=True):
            self._join(link.heat.name, exchange, fields)
        return [
            fields[body.name].errors(
                np.asarray(np.eye(2) / body.law.conductivity), axisymmetric=case.axisymmetric
            )
            for body in self._thermal.bodies
        ]

    def _join(self, name: str, exchange: HeatExchange, fields: dict[str, _Field]) -> None:
        """Fit both sides of an interface together, (35) and (36)."""
        case = self._case
        sides = case.interfaces[name]
        if sides.mortar in case.obstacles:
            return
        means = exchange.means
        weight = np.where(means.weight > 0.0, means.weight, 1.0)
        d = means.dissipation / weight
        active = (np.abs(means.flux).sum(axis=1).A1 > 0.0) | (d > 0.0)
        first, second = (_place(fields, side) for side in (sides.nonmortar, sides.mortar))
        partner = closest(second[0].x[second[1]], first[0].x[first[1]])
        states = (d, active), (d[partner], active[partner])
        for own, other, (heat, passes) in zip(
            (first, second), (second, first), states, strict=True
        ):
            field, vertices, normals = own
            state = ThermalState(normals, passes, heat, np.zeros(len(vertices)))
            fit = recover_heat_flux(field.side(vertices), other[0].side(other[1]), state)
            field.coefficients[vertices, 0] = fit.standard.values


def _fitted(view: MeshView, x: Floats, samples: Floats) -> _Field:
    found = patches(x, view.data.cells)
    return _Field(view, x, samples, found, found.fit(samples))


def _place(fields: dict[str, _Field], side: str) -> tuple[_Field, Ints, Floats]:
    """Field, vertices and normals of one side "body.surface"."""
    owner, _, surface = side.partition(".")
    field = fields[owner]
    group = field.view.data.groups[surface]
    vertices = field.view.data.surface(surface).vertices
    return field, vertices, vertex_normals(group, field.x, vertices)


def _free_of_traction(field: _Field, vertices: Ints, state: MechanicalState) -> None:
    """On an obstacle: no traction where open, no tangential one without friction."""
    from contactfem.constrained_recovery import Conditions as Known
    from contactfem.constrained_recovery import traction_rows

    rows = traction_rows(state.normals)
    known = np.column_stack((~state.active, ~state.active | state.frictionless)).ravel()
    conditions = Known(
        np.repeat(vertices, 2)[known], rows.reshape(-1, rows.shape[2])[known], np.zeros(known.sum())
    )
    field.coefficients = with_conditions(field.patches, field.coefficients, conditions)
