"""One body's heat problem: temperature, storage, conduction, sources and surface fluxes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import basix.ufl
import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem
from dolfinx.mesh import Mesh
from ufl.core.expr import Expr

from petsc4py import PETSc

from contactfem.common.place_time import PlaceTime
from contactfem.common.time_table import Table
from contactfem.common.typing import Floats, Ints
from contactfem.fem.body_mesh import BodyMesh, dofs_at_vertices
from contactfem.fem.compat import CellExpression, assemble_into, local_matrix
from contactfem.forms.heat import conduction, elastic_cooling, heat_flux, storage, surface_ratio
from contactfem.forms.kinematics import circumference, deformation_gradient, hoop_strain


@dataclass(frozen=True)
class HeatLaw:
    """What a material says of heat.

    Attributes:
        conductivity: k [W/m/K].
        capacity: ρ₀ c [J/m³/K]; zero where nothing is stored.
        cooling: 3 α K of the term that straining takes [Pa/K]; None to leave it out.
    """

    conductivity: float
    capacity: float
    cooling: float | None = None


@dataclass(frozen=True)
class HeatLoad:
    """Heat that enters: through a group of facets, or in the volume.

    Attributes:
        group: Name of the surface; None for a source.
        value: Flux through the current surface [W/m²] or source per reference volume [W/m³], over
            time, or over place and time; for convection the surroundings' temperature [K].
        coefficient: Of convection [W/m²/K], otherwise None.
    """

    group: str | None
    value: Table | PlaceTime
    coefficient: float | None = None


class HeatBody:
    """Heat of one body on its mesh.

    Args:
        name: Name of the body.
        mesh: Its mesh.
        law: What its material says.
        loads: Heat that enters it.
        axisymmetric: Whether the mesh is a section through a body around the axis x = 0.
        deforms: Whether heat is conducted in the deformed configuration (finite strain).

    Attributes:
        theta: Temperature [K].
        u: Displacement at the end of the step, linear on this mesh [m]; zero where nothing moves.
    """

    def __init__(
        self,
        name: str,
        mesh: BodyMesh,
        law: HeatLaw,
        loads: Sequence[HeatLoad],
        *,
        axisymmetric: bool = False,
        deforms: bool = True,
    ) -> None:
        self.name, self.mesh, self.law, self.deforms = name, mesh, law, deforms
        domain = mesh.mesh
        P1 = basix.ufl.element("Lagrange", domain.basix_cell(), 1)
        self.V = fem.functionspace(domain, P1)
        shape = basix.ufl.blocked_element(P1, shape=(domain.geometry.dim,))
        self.displacement_space = fem.functionspace(domain, shape)
        self.theta = fem.Function(self.V)
        self.u = fem.Function(self.displacement_space)
        self.n_owned = self.V.dofmap.index_map.size_local
        self.vertex_dofs, self.vertices = dofs_at_vertices(domain, self.V)
        self.loads = tuple(loads)
        self._forms = _Forms(self, loads, axisymmetric)

    @property
    def n_dofs(self) -> int:
        """Dofs of this rank, owned and ghost."""
        return len(self.theta.x.array)

    def dofs(self, vertices: Ints, component: int = 0) -> Ints:
        """Local dofs at some input vertices of this rank, owned and ghost, (m,)."""
        return np.asarray(self.vertex_dofs[np.isin(self.vertices, vertices), component])

    def cell_dofs(self) -> Ints:
        """Dofs of every owned cell, (cells, dofs)."""
        topology = self.mesh.mesh.topology
        owned = topology.index_map(topology.dim).size_local
        return np.asarray(self.V.dofmap.list[:owned].astype(np.int64))

    def stored(self, theta: Floats) -> Floats:
        """Heat that temperatures or their rates hold, ∫ ρ₀ c ϑ δϑ dV, this rank's cells.

        Args:
            theta: ϑ [K] or ϑ̇ [K/s], flat over local dofs.

        Returns:
            [J/m] or [W/m], flat over local dofs.
        """
        return np.asarray(self._storage @ theta)

    @cached_property
    def _storage(self) -> sp.csr_matrix:
        return local_matrix(self._forms.storage_matrix)

    def conducted(self, theta: Floats) -> Floats:
        """Heat that leaves nodes by conduction, and what convection takes per temperature [W/m].

        Args:
            theta: ϑ [K], flat over local dofs.
        """
        if self.deforms:
            return self._forms.conducted(theta)
        return np.asarray(self._conduction @ theta)

    @cached_property
    def _conduction(self) -> sp.csr_matrix:
        return local_matrix(self._forms.conduction_matrix)

    def supplied(self, t: float) -> Floats:
        """Heat that the loads bring at a time [W/m], flat over local dofs.

        Args:
            t: Time [s].
        """
        return self._forms.supply(t)

    def cooled(self, theta: Floats, u_old: Floats, dt: float) -> Floats:
        """Heat that straining takes over a step [W/m], flat over local dofs.

        Args:
            theta: ϑ at its start [K], flat over local dofs.
            u_old: Displacement at its start [m], flat over local dofs.
            dt: Its length [s].
        """
        return self._forms.cool(theta, u_old, dt)

    def add_storage(self, A: PETSc.Mat) -> None:
        """Add ∫ ρ₀ c δϑ δϑ dV to a matrix with this body's local-to-global map."""
        assemble_into(A, self._forms.storage_matrix)

    def add_conduction(self, A: PETSc.Mat) -> None:
        """Add ∫ k J C⁻¹ Grad δϑ · Grad δϑ dV and convection, likewise."""
        assemble_into(A, self._forms.conduction_matrix)

    def cell_flux(self) -> Floats:
        """Heat flux at the cells' midpoints, owned and ghost, (cells, dim) [W/m²]."""
        return self._flux.values()[:, 0]

    @cached_property
    def _flux(self) -> CellExpression:
        return self.flux_at(None)

    def flux_at(self, points: Floats | None) -> CellExpression:
        """Heat flux at points of the reference cell, (q, dim); its midpoint without [W/m²]."""
        k = fem.Constant(self.mesh.mesh, self.law.conductivity)
        return CellExpression(self.mesh.mesh, heat_flux(self.theta, k, self._forms.F), points)


class _Forms:
    """Compiled forms of a heat body, with the functions and constants that stand in them."""

    def __init__(self, body: HeatBody, loads: Sequence[HeatLoad], axisymmetric: bool) -> None:
        domain = body.mesh.mesh
        self._body, self._axisymmetric = body, axisymmetric
        self._x = ufl.SpatialCoordinate(domain)
        self._depth = circumference(self._x) if axisymmetric else 1.0
        # Of a simplex the gradient is constant; heat per volume is bilinear.
        simplex = domain.basix_cell().name in ("triangle", "tetrahedron")
        self._dx = _volume(domain, (1 if simplex else 2) + axisymmetric)
        self._dx_mass = _volume(domain, 2 + axisymmetric)
        self.F = self._deformation(body.u) if body.deforms else None
        self._k = fem.Constant(domain, body.law.conductivity)
        capacity = fem.Constant(domain, body.law.capacity)
        self._w = fem.Function(body.V)
        self._loads = [(self._placeholder(load.value), load) for load in loads]
        v, trial = ufl.TestFunction(body.V), ufl.TrialFunction(body.V)
        self.storage_matrix = fem.form(storage(trial, v, capacity, self._depth, self._dx_mass))
        self._action = fem.form(self._conducted(self._w, v)) if body.deforms else None
        self.conduction_matrix = fem.form(self._conducted(trial, v))
        supplies = [self._supplied(value, load, v) for value, load in self._loads]
        self._supply = fem.form(sum(supplies[1:], supplies[0])) if supplies else None
        self._cooling: _Cooling | None = None
        if body.law.cooling is not None:
            self._cooling = _Cooling(body, self._deformation, self._depth, self._dx_mass)

    def conducted(self, theta: Floats) -> Floats:
        """Assemble the conduction of a body that deforms, this rank's cells."""
        assert self._action is not None
        self._w.x.array[:] = theta
        return _assembled(self._action, len(theta))

    def supply(self, t: float) -> Floats:
        """Assemble the loads at a time, this rank's cells."""
        for value, load in self._loads:
            _set(value, load.value, t)
        n = self._body.n_dofs
        return np.zeros(n) if self._supply is None else _assembled(self._supply, n)

    def cool(self, theta: Floats, u_old: Floats, dt: float) -> Floats:
        """Assemble the heat that straining takes, this rank's cells."""
        if self._cooling is None:
            return np.zeros_like(theta)
        return self._cooling.assemble(theta, u_old, dt)

    def _placeholder(self, value: Table | PlaceTime) -> fem.Constant | fem.Function:
        if isinstance(value, Table):
            return fem.Constant(self._body.mesh.mesh, 0.0)
        return fem.Function(self._body.V)

    def _deformation(self, u: Expr) -> Expr:
        return deformation_gradient(u, hoop_strain(u, self._x) if self._axisymmetric else 0.0)

    def _surface(self, group: str) -> tuple[Expr | float, ufl.Measure]:
        """Current area per reference length of a surface, and its measure."""
        body = self._body
        ds = body.mesh.ds(group, degree=2 + self._axisymmetric)
        if not body.deforms:
            return self._depth, ds
        depth = circumference(self._x + body.u) if self._axisymmetric else 1.0
        return surface_ratio(body.u, ufl.FacetNormal(body.mesh.mesh)) * depth, ds

    def _conducted(self, theta: Expr, v: Expr) -> ufl.Form:
        """Conduction, and the part of convection that goes with the temperature."""
        form = conduction(theta, v, self._k, self.F, self._depth, self._dx)
        for _, load in self._loads:
            if load.group is not None and load.coefficient is not None:
                area, ds = self._surface(load.group)
                h = fem.Constant(self._body.mesh.mesh, load.coefficient)
                form += h * theta * v * area * ds
        return form

    def _supplied(self, value: Expr, load: HeatLoad, v: Expr) -> ufl.Form:
        """Virtual power of one load, ∫ r δϑ dV or ∫ q δϑ da (20)."""
        if load.group is None:
            return value * v * self._depth * self._dx_mass
        area, ds = self._surface(load.group)
        if load.coefficient is not None:
            value = fem.Constant(self._body.mesh.mesh, load.coefficient) * value
        return value * v * area * ds


class _Cooling:
    """Heat that straining takes over a step."""

    def __init__(
        self,
        body: HeatBody,
        deformation: Callable[[Expr], Expr],
        depth: Expr | float,
        dx: ufl.Measure,
    ) -> None:
        domain, law = body.mesh.mesh, body.law
        self._theta, self._u_old = fem.Function(body.V), fem.Function(body.displacement_space)
        self._dt = fem.Constant(domain, 1.0)
        modulus = fem.Constant(domain, law.cooling or 0.0)
        F, F_old = deformation(body.u), deformation(self._u_old)
        growth = ufl.ln(ufl.det(F) / ufl.det(F_old)) if body.deforms else ufl.tr(F - F_old)
        power = elastic_cooling(self._theta, modulus, growth, self._dt)
        self._form = fem.form(power * ufl.TestFunction(body.V) * depth * dx)

    def assemble(self, theta: Floats, u_old: Floats, dt: float) -> Floats:
        """Power at the nodes [W/m], this rank's cells."""
        self._theta.x.array[:], self._u_old.x.array[:] = theta, u_old
        self._dt.value = dt
        return _assembled(self._form, len(theta))


def _set(place: fem.Constant | fem.Function, value: Table | PlaceTime, t: float) -> None:
    """Set a constant or, at the vertices, a function to a value at a time."""
    if isinstance(value, Table):
        place.value = value(t)
    else:
        place.interpolate(lambda x: value(x, t))


def _volume(domain: Mesh, degree: int) -> ufl.Measure:
    return ufl.Measure("dx", domain, metadata={"quadrature_degree": degree})


def _assembled(form: fem.Form, n: int) -> Floats:
    result: Floats = np.zeros(n)
    fem.assemble_vector(result, form)
    return result
