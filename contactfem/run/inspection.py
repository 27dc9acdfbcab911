"""Look at every state that would be accepted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING

import numpy as np

from contactfem.audit.files import heat_terms
from contactfem.audit.forces import BodyForces, ContactForces, breaches_of_heat
from contactfem.audit.loads import in_volume, means, of_pressure, on_surface
from contactfem.audit.look import AuditState, Finding, extent, look
from contactfem.audit.shapes import BodyShape, ObstacleShape
from contactfem.case.base import AXES
from contactfem.case.obstacles import Circle, Plane, Polyline, RigidCylinder, Sphere
from contactfem.case.scene import Condition
from contactfem.case.schema import Case
from contactfem.common.place_time import Varying
from contactfem.common.time_table import constant
from contactfem.common.typing import Bools, Floats, Ints
from contactfem.common.units import Given
from contactfem.contact.state import ContactState
from contactfem.discretisation.discretise import Discretisation
from contactfem.discretisation.given_data import given
from contactfem.mechanics.body import BodyProblem
from contactfem.solvers.newton import NewtonSolver

if TYPE_CHECKING:
    from contactfem.results.data import HeatStep
    from contactfem.thermomechanics.thermal_problem import Thermal

LESS = 0.7  # of what was found with twice the step: shorter steps help


class Verification:
    """Looks at every state of a run that would be accepted.

    Args:
        case: The case.
        thermal: Its heat side; None without heat.
        ramp_end: Time at which constant loads and motions are reached [s].

    Attributes:
        last: The last accepted state on the first rank; None elsewhere and before the first.
        worst: What was found of the step that is tried; empty while all is well.
    """

    def __init__(self, case: Case, thermal: Thermal | None, ramp_end: float) -> None:
        self._case, self._ramp_end = case, ramp_end
        self._inspector: Inspector | None = None
        self._said: set[str] = set()
        self._holding = _holding(case, thermal)
        self._seen: AuditState | None = None
        self.last: AuditState | None = None
        self.worst: list[Finding] = []

    def look(self, t: float, discretisation: Discretisation, solver: NewtonSolver) -> Finding:
        """What is wrong with the present state of the bodies; collective.

        Args:
            t: Its time [s].
            discretisation: The present meshes.
            solver: Of mechanics.
        """
        if self._inspector is None or self._inspector.discretisation is not discretisation:
            self._inspector = Inspector(self._case, discretisation, self._ramp_end)
        found, self._seen = self._inspector.finding(t, solver)
        self.worst = [*self.worst, found] if found.breaches else []
        return found

    @property
    def shorter_helps(self) -> bool:
        """Whether a shorter step may be right where this one was not, as far as was seen."""
        now = self.worst[-1].breaches[0]
        if len(self.worst) < 2:
            return now.measure > 0.0
        before = self.worst[-2].breaches[0]
        return now.kind != before.kind or now.measure < LESS * before.measure

    def accepted(self) -> None:
        """The state that was looked at last is accepted."""
        seen = self._seen
        self.last = None if seen is None else replace(seen, holding=self._holding)
        self.worst = []

    def new(self, finding: Finding) -> bool:
        """Whether something of a kind is found that was not said before; said from now on."""
        kinds = {breach.kind for breach in finding.breaches}
        fresh = bool(kinds - self._said)
        self._said |= kinds
        return fresh

    def of_heat(self, heat: HeatStep, t: float, dt: float) -> Finding:
        """What is wrong with the heat of a step.

        Args:
            heat: The heat.
            t: Time at its end [s].
            dt: Length of the step [s].
        """
        return Finding(t, tuple(breaches_of_heat(heat_terms(asdict(heat), dt, self._holding))))


class Inspector:
    """Looks at states of a run on one set of meshes.

    Args:
        case: The case.
        discretisation: Its meshes.
        ramp_end: Time at which constant loads and motions are reached [s].
    """

    def __init__(self, case: Case, discretisation: Discretisation, ramp_end: float) -> None:
        self._case, self.discretisation, self._ramp_end = case, discretisation, ramp_end
        self._comm = discretisation.system.comm
        self._shapes = {
            name: BodyShape(name, data.points, data.points, data.cells, data.cell_type)
            for name, body in discretisation.bodies.items()
            if (data := body.mesh.data) is not None
        }
        tables = [t for c in case.conditions for t in c.components().values()]
        tables += [t for o in case.obstacles.values() for t in o.displacement.values()]
        self._travel = max((abs(v) for table in tables for v in table.values), default=0.0)
        self._scene = extent(list(self._shapes.values()), self._obstacles(0.0))
        sources = [body.vertices[_owned(body)] for body in discretisation.bodies.values()]
        self._sources = self._comm.gather(sources)

    def finding(self, t: float, solver: NewtonSolver) -> tuple[Finding, AuditState | None]:
        """What is wrong with the present state, and that state on the first rank; collective.

        Args:
            t: Its time [s].
            solver: Of mechanics.
        """
        snapshot = self.snapshot(t, solver)
        found = Finding(t) if snapshot is None else look(snapshot)
        return (self._comm.bcast(found) if self._comm.size > 1 else found), snapshot

    def snapshot(self, t: float, solver: NewtonSolver) -> AuditState | None:
        """The present state on the first rank, None elsewhere; collective. As for `finding`."""
        bodies = self._bodies()
        supports = solver.supports()
        if self._comm.rank:
            return None
        return AuditState(
            t,
            tuple(bodies),
            self._obstacles(t),
            self._contacts(solver.conditions, solver.round_off),
            self._forces(bodies, t, supports, solver.round_off),
            self.discretisation.unrestrained,
            self._scene,
            self._travel,
            self._case.axisymmetric,
        )

    def _bodies(self) -> list[BodyShape]:
        """Bodies where they are, on the first rank; collective."""
        bodies = self.discretisation.bodies.values()
        mine = [body.u.x.array[body.vertex_dofs[_owned(body)]] for body in bodies]
        parts = self._comm.gather(mine)
        if parts is None or self._sources is None:
            return []
        result = []
        for k, shape in enumerate(self._shapes.values()):
            x = shape.X.copy()
            for vertices, part in zip(self._sources, parts, strict=True):
                x[vertices[k]] += part[k]
            result.append(shape.moved(x))
        return result

    def _obstacles(self, t: float) -> tuple[ObstacleShape, ...]:
        """Obstacles at a time [s]."""
        result = []
        for name, o in self._case.obstacles.items():
            at = np.array([x.at(t, self._ramp_end) for x in o.motion(self._case.axes)])
            if isinstance(o, Plane):
                points = np.array((np.array(o.point) + at, o.normal))
                result.append(ObstacleShape(name, "plane", points))
            elif isinstance(o, Circle | Sphere):
                centre = np.array((o.center,)) + at
                result.append(ObstacleShape(name, "circle", centre, o.radius, o.inside))
            elif isinstance(o, RigidCylinder):
                line = np.array((np.array(o.point) + at, o.axis))
                result.append(ObstacleShape(name, "cylinder", line, o.radius, o.inside))
            elif isinstance(o, Polyline):
                chain = np.array(o.points) + at
                result.append(ObstacleShape(name, "polyline", chain, closed=o.closed))
        return tuple(result)

    def _contacts(
        self, conditions: Sequence[ContactState], floor: float
    ) -> tuple[ContactForces, ...]:
        """Forces of the interfaces."""
        result = []
        for interface, c in zip(self.discretisation.interfaces, conditions, strict=True):
            sides = self._case.interfaces[interface.name]
            mesh, bound = interface.nodes.mesh, c.bound.value * c.operators.D
            carries = mesh.has_multiplier & (mesh.basis == "dual")  # else forces are shared
            carries &= interface.contact.law.tied is None  # tied nodes may be pulled
            compliance = np.maximum(interface.contact.law.normal_compliance, c.edge.compliance)
            result.append(
                ContactForces(
                    interface.name,
                    sides.nonmortar.partition(".")[0],
                    sides.mortar.partition(".")[0],
                    c.operators.x,
                    c.operators.normals.n,
                    -c.nodal_forces(),
                    np.where(carries, np.where(c.active, bound, 0.0), np.inf),
                    np.linalg.norm(c.slip, axis=1),
                    c.dissipation,
                    np.where(c.active, compliance * np.abs(c.multiplier.pressure), 0.0),
                    floor,
                )
            )
        return tuple(result)

    def _forces(
        self, bodies: Sequence[BodyShape], t: float, supports: Floats, floor: float
    ) -> tuple[BodyForces, ...]:
        """Loads and supports of the bodies; none without mechanics."""
        result = []
        for shape, support in zip(bodies, list(supports), strict=False):
            mine = [c for c in self._case.conditions if c.body == shape.name]
            parts = [self._load(c, shape, t) for c in mine]
            total: Floats = np.sum([np.zeros(len(support)), *parts], axis=0)
            size = sum(float(np.linalg.norm(part)) for part in parts)
            size += float(np.linalg.norm(support))
            result.append(BodyForces(shape.name, total, support, size, floor))
        return tuple(result)

    def _load(self, condition: Condition, shape: BodyShape, t: float) -> Floats:
        """Resultant of a condition's load [N/m], zero without one."""
        axes, around = AXES[: shape.X.shape[1]], self._case.axisymmetric
        if condition.grip is not None:
            force = condition.grip.force
            return np.array([force[a].at(t, self._ramp_end) if a in force else 0.0 for a in axes])
        mesh = self.discretisation.bodies[shape.name].mesh
        facets = mesh.groups[condition.surface] if condition.surface is not None else None
        cells = shape.simplices if facets is None else facets
        if condition.pressure is not None and facets is not None:
            x = shape.X if self._case.strain == "small" else shape.x
            pressure = self._mean(condition.pressure, shape, cells, t)
            return of_pressure(x, facets, pressure, axisymmetric=around)
        found = condition.traction or condition.body_force or {}
        zero = constant(0.0)
        density = np.column_stack([self._mean(found.get(a, zero), shape, cells, t) for a in axes])
        if facets is not None:
            return on_surface(shape.X, facets, density, axisymmetric=around)
        return in_volume(shape, density, axisymmetric=around)

    def _mean(self, value: Given, shape: BodyShape, cells: Ints, t: float) -> Floats:
        """Mean of a load over facets or simplices, as linear between their corners, (k,)."""
        found = given(self._case, value)
        if isinstance(found, Varying):
            corners = shape.X[cells].reshape(-1, shape.X.shape[1])
            values = found.at(corners, t, self._ramp_end).reshape(cells.shape)
            return means(values, shape.X, cells, axisymmetric=self._case.axisymmetric)
        return np.full(len(cells), found.at(t, self._ramp_end))


def _owned(body: BodyProblem) -> Bools:
    """Which vertices are this rank's own."""
    return np.asarray(body.vertex_dofs[:, 0] < body.n_owned)


def _holding(case: Case, thermal: Thermal | None) -> tuple[float, float]:
    """Heat capacity of all bodies [J/m/K] and their largest conductivity [W/m/K]; collective."""
    if thermal is None:
        return 0.0, 0.0
    ones = [np.ones_like(values) for values in thermal.initial]
    conductivity = max(material.conductivity or 0.0 for material in case.materials.values())
    return thermal.product(ones, ones), conductivity
