"""Recovered and discrete field of one body, and their distance."""

from dataclasses import dataclass
from functools import cached_property

from contactfem.adaptivity.recovery.constraints import ConstraintRows, with_conditions
from contactfem.adaptivity.recovery.interface import JointFit, Side
from contactfem.adaptivity.recovery.norms import (
    Quadrature,
    around_axis,
    quadrature,
    squared_errors,
    squared_norms,
)
from contactfem.adaptivity.recovery.patches import Patches, patches
from contactfem.common.typing import Floats, Ints
from contactfem.fem.gathered_mesh import MeshView
from contactfem.results.relative_error import RelativeError


@dataclass(frozen=True, eq=False)
class BodyErrors:
    """Errors of the cells of one body's mesh, the same on all ranks.

    Attributes:
        name: Name of the body.
        view: The mesh.
        errors: ‖e‖² of each cell, (m,).
        norms: ‖v‖² of each cell, (m,).
    """

    name: str
    view: MeshView
    errors: Floats
    norms: Floats

    @cached_property
    def total(self) -> RelativeError:
        """Of the whole body."""
        return RelativeError(float(self.errors.sum()), float(self.norms.sum()))


class BodyRecovery:
    """What recovery needs of one mesh, made once.

    Polynomials are fitted over reference positions, where the discrete solution superconverges, so
    that their patches stay while the body deforms. Only surfaces that meet those of other bodies
    are fitted in their present place.

    Args:
        name: Name of the body.
        view: Its mesh.
        metric: M of the norm, (c, c).
        axisymmetric: Whether the mesh is a section through a body around the axis x = 0.
    """

    def __init__(self, name: str, view: MeshView, metric: Floats, *, axisymmetric: bool) -> None:
        self.name, self.view, self.metric = name, view, metric
        self._axisymmetric = axisymmetric
        self._sides: dict[str, Patches] = {}

    @property
    def points(self) -> Floats:
        """Reference positions of the vertices [m], (n, 2)."""
        return self.view.data.points

    @cached_property
    def patches(self) -> Patches:
        """Those of all vertices."""
        return patches(self.points, self.view.data.cells)

    @cached_property
    def _reference(self) -> Quadrature:
        return self._quadrature(self.points)

    def rule(self, x: Floats) -> Quadrature:
        """Quadrature of all cells with their vertices at x [m], (n, 2)."""
        return self._reference if x is self.points else self._quadrature(x)

    def _quadrature(self, x: Floats) -> Quadrature:
        rule = quadrature(x, self.view.data.cells)
        return around_axis(rule) if self._axisymmetric else rule

    def side(self, surface: str, x: Floats) -> Patches:
        """Patches of the vertices of a surface with all vertices at x [m], (n, 2)."""
        vertices = self.view.data.surface(surface).vertices
        if x is not self.points:
            return patches(x, self.view.data.cells, vertices)
        if surface not in self._sides:
            self._sides[surface] = self.patches.at(vertices)
        return self._sides[surface]


class RecoveredField:
    """A field of a body.

    Args:
        recovery: The body's mesh.
        x: Positions of its vertices [m], (n, 2); the reference ones where nothing moves much.
        values: The discrete field at the sample points of all cells, (m, q, c).
    """

    def __init__(self, recovery: BodyRecovery, x: Floats, values: Floats) -> None:
        self.recovery, self.x = recovery, x
        self._samples = values[:, 0]
        self._discrete = values[:, 1:] if values.shape[1] > 1 else values
        self._coefficients = recovery.patches.fit(self._samples)

    def require(self, conditions: ConstraintRows) -> None:
        """Make it obey what is known at vertices."""
        found = with_conditions(self.recovery.patches, self._coefficients, conditions)
        self._coefficients = found

    def side(self, surface: str) -> Side:
        """Polynomials of the vertices of a surface, fitted without anything known."""
        found = self.recovery.side(surface, self.x)
        return Side(found, found.fit(self._samples))

    def join(self, vertices: Ints, fit: JointFit) -> None:
        """Take values at vertices that were fitted together with another body."""
        self._coefficients[vertices, 0] = fit.standard.values

    def errors(self) -> BodyErrors:
        """Distance of the recovered field from the discrete one."""
        recovery = self.recovery
        rule = recovery.rule(self.x)
        return BodyErrors(
            recovery.name,
            recovery.view,
            squared_errors(
                rule, recovery.view.data.cells, self._coefficients[:, 0], self._discrete,
                recovery.metric,
            ),
            squared_norms(rule, self._discrete, recovery.metric),
        )  # fmt: skip
