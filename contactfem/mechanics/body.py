"""One body's mechanical problem: displacement, residual and tangent."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import ufl
from dolfinx import fem

from petsc4py import PETSc

from contactfem.common.place_time import Varying
from contactfem.common.time_table import Table
from contactfem.common.typing import Floats, Ints
from contactfem.fem.body_mesh import BodyMesh, dofs_at_vertices
from contactfem.fem.cell_values import coefficient
from contactfem.fem.compat import CellExpression, assemble_into
from contactfem.forms.kinematics import circumference, deformation_gradient, hoop_strain
from contactfem.forms.mechanics import (
    Energy,
    MixedEnergy,
    cauchy_stress,
    dead_load,
    follower_pressure,
    internal_work,
    small_strain_stress,
)
from contactfem.mechanics.elements import linear, mini


@dataclass(frozen=True)
class Law:
    """Constitutive law of a body.

    Attributes:
        energy: Free energy ψ(F, ϑ, parameters) [J/m³].
        parameters: Its parameters by name, each a number or one for every input cell [SI].
        youngs_modulus: Stiffness that scales contact and the residual [Pa].
        small_strain: Whether ψ depends on the strain of the undeformed body.
        linear: Whether stress is linear in the displacement, so that one tangent serves for ever.
        mixed: The energy with the mean stress as a field: the body gets MINI elements; None for
            linear displacements alone.
        reference: Temperature of the stress-free state, that expansion counts from [K].
    """

    energy: Energy
    parameters: Mapping[str, float | Floats]
    youngs_modulus: float
    small_strain: bool
    linear: bool
    mixed: MixedEnergy | None = None
    reference: float = 0.0

    @property
    def shear_modulus(self) -> float:
        """Size of the shear modulus, of several the geometric mean [Pa]."""
        return float(np.exp(np.mean(np.log(self.parameters["shear_modulus"]))))


@dataclass(frozen=True)
class Load:
    """A load on a body: a traction or pressure on a group, or a body force.

    Attributes:
        group: Name of the surface; None for a body force.
        components: One value per component [N/m² or N/m³], over time or over place and time; a
            single one is a pressure [Pa].
    """

    group: str | None
    components: tuple[Table | Varying, ...]

    @property
    def is_pressure(self) -> bool:
        """Whether it acts along the normal."""
        return self.group is not None and len(self.components) == 1


class BodyProblem:
    """Mechanics of one body on its mesh.

    Args:
        name: Name of the body.
        mesh: Its mesh.
        law: Its law.
        theta: Temperature over time [K]; None where heat is solved for.
        loads: Loads on it.
        axisymmetric: Whether the mesh is a section through a body around the axis x = 0, whose
            forces are those of the whole circumference; else it is one metre deep.

    Attributes:
        temperature: Temperature [K] where heat is solved for, linear on this mesh.
        u: All unknowns: displacements, and what the element adds to them [m].
        vertex_space: Space of the displacements, or the subspace of `u` that they are.
        vertex_dofs: Local scalar dofs of the displacement at the vertices, (vertices, dim).
        vertices: Input numbers of these vertices, owned and ghost, ascending.
        n_owned: Scalar dofs of this rank; those of ghosts follow.
    """

    def __init__(
        self,
        name: str,
        mesh: BodyMesh,
        law: Law,
        theta: Table | None,
        loads: Sequence[Load],
        axisymmetric: bool = False,
    ) -> None:
        self.name, self.mesh, self.law, self.axisymmetric = name, mesh, law, axisymmetric
        self._tables: list[tuple[fem.Constant, tuple[Table, ...], bool]] = []
        self._fields: list[tuple[fem.Function, Ints, Floats, Table | Varying]] = []
        self.temperature: fem.Function | None = None
        if theta is None:
            P1 = fem.functionspace(mesh.mesh, ("Lagrange", 1))
            self.temperature = fem.Function(P1)
            self._theta: ufl.core.expr.Expr = self.temperature
        else:
            uniform = fem.Constant(mesh.mesh, 0.0)
            self._tables.append((uniform, (theta,), False))
            self._theta = uniform
        if law.reference:  # the energy takes the rise above the stress-free state
            self._theta = self._theta - fem.Constant(mesh.mesh, law.reference)
        self._parameters = {k: coefficient(mesh.mesh, v) for k, v in law.parameters.items()}
        self._element = (
            linear(mesh, law.energy)
            if law.mixed is None
            else mini(mesh, law.mixed, law.shear_modulus)
        )
        self.u = self._element.unknowns
        self.V = self.u.function_space
        self.n_owned = self.V.dofmap.index_map.size_local * self.V.dofmap.index_map_bs
        self.vertex_space = self._element.vertex_space
        self.vertex_dofs, self.vertices = dofs_at_vertices(mesh.mesh, self.vertex_space)
        self._residual_ufl = self._residual_form(loads)
        self.is_linear = law.linear and not any(load.is_pressure for load in loads)
        self.is_symmetric = law.small_strain or not any(load.is_pressure for load in loads)

    def compile(self) -> None:
        """Have the forms ready, which wait until they are needed otherwise; collective."""
        _ = self._residual, self._tangent
        if not self.is_linear:
            _ = self._action

    @cached_property
    def _residual(self) -> fem.Form:
        return fem.form(self._residual_ufl)

    @cached_property
    def _tangent(self) -> fem.Form:
        trial = ufl.TrialFunction(self.V)
        return fem.form(ufl.derivative(self._residual_ufl, self.u, trial))

    @cached_property
    def _action(self) -> fem.Form:
        return fem.form(ufl.derivative(self._residual_ufl, self.u, self._increment))

    @cached_property
    def _increment(self) -> fem.Function:
        return fem.Function(self.V)

    def _residual_form(self, loads: Sequence[Load]) -> ufl.Form:
        """Internal minus external virtual work (19)."""
        u, v = self._element.displacement, self._element.virtual
        x = ufl.SpatialCoordinate(self.mesh.mesh)
        depth, current_depth = (
            (circumference(x), circumference(x + u)) if self.axisymmetric else (1.0, 1.0)
        )
        degree = max(self._element.degree, 2) if self.axisymmetric else self._element.degree
        dx = ufl.Measure("dx", self.mesh.mesh, metadata={"quadrature_degree": degree})
        density = self._element.energy(self._F(), self._theta, self._parameters)
        form = internal_work(density, depth, self.u, dx)
        for load in loads:
            value = self._load_value(load)
            if load.group is None:
                form -= dead_load(depth * value, v, ufl.Measure("dx", self.mesh.mesh))
                continue
            ds = self.mesh.ds(load.group, degree=2)
            if not load.is_pressure:
                form -= dead_load(depth * value, v, ds)
            elif self.law.small_strain:
                normal = ufl.FacetNormal(self.mesh.mesh)
                form -= dead_load(-depth * value[0] * normal, v, ds)
            else:
                form -= follower_pressure(value[0], u, v, ds, current_depth)
        return form

    def _load_value(self, load: Load) -> ufl.core.expr.Expr:
        """Components of a load: a constant, or functions where one varies over place."""
        tables = tuple(c for c in load.components if isinstance(c, Table))
        if len(tables) == len(load.components):
            value = fem.Constant(self.mesh.mesh, np.zeros(len(tables)))
            self._tables.append((value, tables, True))
            return value
        V = fem.functionspace(self.mesh.mesh, ("Lagrange", 1))
        dofs, vertices = dofs_at_vertices(self.mesh.mesh, V)
        if load.group is not None:  # elsewhere a user's function may not even be defined
            dofs = dofs[np.isin(vertices, self.mesh.surface(load.group).vertices)]
        functions = [fem.Function(V) for _ in load.components]
        places = V.tabulate_dof_coordinates()[dofs[:, 0], : self.mesh.mesh.geometry.dim]
        for function, component in zip(functions, load.components, strict=True):
            self._fields.append((function, dofs[:, 0], places, component))
        return ufl.as_vector(functions)

    def places(self, vertices: Ints) -> Floats:
        """Reference places of the dofs of one component at some input vertices [m], (m, dim)."""
        return self._places[np.isin(self.vertices, vertices)]

    @cached_property
    def _places(self) -> Floats:
        """Reference places of this rank's vertices [m], (vertices, dim)."""
        V = fem.functionspace(self.mesh.mesh, ("Lagrange", 1))
        dofs = dofs_at_vertices(self.mesh.mesh, V)[0][:, 0]
        return np.asarray(V.tabulate_dof_coordinates()[dofs, : self.mesh.mesh.geometry.dim])

    @property
    def n_dofs(self) -> int:
        """Scalar dofs of this rank, owned and ghost."""
        return len(self.u.x.array)

    @property
    def displacement(self) -> fem.Function:
        """Displacement [m], the whole or a part of `u`, for interpolation at the vertices."""
        return self.u if self.law.mixed is None else self.u.sub(0)

    def _F(self) -> ufl.core.expr.Expr:
        """Deformation gradient."""
        u, x = self._element.displacement, ufl.SpatialCoordinate(self.mesh.mesh)
        return deformation_gradient(u, hoop_strain(u, x) if self.axisymmetric else 0.0)

    def set_time(self, t: float, ramp_end: float) -> None:
        """Set temperature and loads to those of a time.

        Args:
            t: Time [s].
            ramp_end: Time at which constant loads are reached [s].
        """
        for constant, tables, ramped in self._tables:
            values = [table.at(t, ramp_end) if ramped else table(t) for table in tables]
            constant.value[...] = np.reshape(values, constant.value.shape)
        for function, dofs, places, value in self._fields:
            if isinstance(value, Varying):
                function.x.array[dofs] = value.at(places, t, ramp_end)
            else:
                function.x.array[dofs] = value.at(t, ramp_end)

    def residual(self) -> Floats:
        """Internal minus external forces of this rank's cells [N/m], flat over local dofs."""
        result: Floats = np.zeros_like(self.u.x.array)
        fem.assemble_vector(result, self._residual)
        return result

    def add_tangent(self, A: PETSc.Mat) -> None:
        """Add this rank's part of the tangent to a matrix whose local numbering is this body's.

        Args:
            A: Matrix with the body's local-to-global map set.
        """
        assemble_into(A, self._tangent)

    @contextmanager
    def without(self, jump: Floats | None) -> Iterator[None]:
        """Take a displacement increment back for the time inside [m]."""
        if jump is not None:
            self.u.x.array[:] -= jump
        try:
            yield
        finally:
            if jump is not None:
                self.u.x.array[:] += jump

    def tangent_action(self, du: Floats) -> Floats:
        """Tangent times a displacement increment, this rank's cells [N/m], flat local.

        Args:
            du: Increment, flat over owned and ghost dofs [m].
        """
        action = self._action
        self._increment.x.array[:] = du
        result: Floats = np.zeros_like(self.u.x.array)
        fem.assemble_vector(result, action)
        return result

    def dofs(self, vertices: Ints, component: int) -> Ints:
        """Local scalar dofs of one displacement component at some input vertices.

        Args:
            vertices: Input vertex numbers.
            component: 0, 1 or 2.

        Returns:
            Owned and ghost dofs of this rank, (m,).
        """
        return np.asarray(self.vertex_dofs[np.isin(self.vertices, vertices), component])

    def cell_dofs(self) -> Ints:
        """Scalar dofs of every owned cell, (cells, dofs)."""
        bs = self.V.dofmap.index_map_bs
        owned = self.mesh.mesh.topology.index_map(self.mesh.mesh.topology.dim).size_local
        blocks = self.V.dofmap.list[:owned].astype(np.int64)
        dofs = bs * blocks[:, :, None] + np.arange(bs)
        return np.asarray(dofs.reshape(owned, bs * blocks.shape[1]))  # a rank may own no cell

    def cell_stress(self) -> Floats:
        """Cauchy stress at the cells' midpoints, owned and ghost: xx, yy, zz, xy, yz, xz [Pa]."""
        return self._stress.values()[:, 0]

    @cached_property
    def _stress(self) -> CellExpression:
        return self.stress_at(None)

    def stress_at(self, points: Floats | None) -> CellExpression:
        """Cauchy stress at points of the reference cell, (q, dim); its midpoint without [Pa]."""
        stress: Callable[..., ufl.core.expr.Expr] = (
            small_strain_stress if self.law.small_strain else cauchy_stress
        )
        s = stress(self._F(), self._theta, self._element.energy, self._parameters)
        places = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
        components = ufl.as_vector([s[i, j] for i, j in places])
        return CellExpression(self.mesh.mesh, components, points)
