"""A manufactured solution at finite strain and homogeneous solids, through system and solver."""

import numpy as np
import pytest
import ufl
from dolfinx import fem

from mpi4py import MPI

from contactfem.common.time_table import constant
from contactfem.common.timers import Timers
from contactfem.fem.body_mesh import distribute
from contactfem.fem.compat import cell_nodes
from contactfem.fem.dof_numbering import Prescribed
from contactfem.forms.energies import neo_hooke
from contactfem.forms.kinematics import deformation_gradient
from contactfem.forms.mechanics import dead_load
from contactfem.mechanics.body import BodyProblem, Law
from contactfem.mechanics.bulk_system import System
from contactfem.meshes.block import Block
from contactfem.meshes.box import Box
from contactfem.solvers.newton import NewtonSolver, StepInput
from contactfem.verification.homogeneous import NeoHooke

COMM = MPI.COMM_WORLD
K, MU = 333.0, 35.0
LAW = Law(
    neo_hooke, {"bulk_modulus": K, "shear_modulus": MU, "expansion": 0.0}, 101.446, False, False
)
pytestmark = pytest.mark.mpi


def mesh_of(builder):
    """Mesh of a builder, which only the first rank runs."""
    return distribute(COMM, builder.build() if COMM.rank == 0 else None)


def exact(X):
    """Displacement of the unit square, of UFL or numpy coordinates."""
    lib = np if isinstance(X, np.ndarray) else ufl
    sin, cos, pi = lib.sin, lib.cos, np.pi
    return (
        0.1 * sin(pi * X[0]) * cos(pi * X[1] / 2),
        0.08 * cos(pi * X[0] / 2) * sin(pi * X[1]),
    )


def nominal_stress(X):
    """P = ∂ψ/∂F of the exact displacement."""
    F = ufl.variable(deformation_gradient(ufl.as_vector(exact(X))))
    return ufl.diff(neo_hooke(F, ufl.as_ufl(0.0), LAW.parameters), F)


def body_force(X):
    """B₀ = -Div P, which keeps the exact displacement in equilibrium [N/m³]."""
    P = nominal_stress(X)
    return ufl.as_vector([-sum(P[i, j].dx(j) for j in range(2)) for i in range(2)])


class Manufactured(BodyProblem):
    """The body under the exact solution's body force, which varies in space."""

    def _residual_form(self, loads):
        form = super()._residual_form(loads)
        dx = ufl.Measure("dx", self.mesh.mesh, metadata={"quadrature_degree": 4})
        force = body_force(ufl.SpatialCoordinate(self.mesh.mesh))
        return form - dead_load(force, ufl.TestFunction(self.V), dx)


def solve(body, prescribed):
    """Solve for one body in one step without contact; its report."""
    system = System(COMM, [body], prescribed, [])
    solver = NewtonSolver(system, (), 1e-12, 20, {}, Timers())
    report = solver.solve(StepInput(1.0, 1.0, (), (), known=False))
    assert report.converged, report.reason
    return solver, report


def held_at(mesh, groups, displacement):
    """Prescribe every vertex of some sides, one by one."""
    found = {}
    for name in groups:
        surface = mesh.surface(name)
        found |= dict(zip(surface.vertices.tolist(), surface.X, strict=True))
    return [
        Prescribed(0, np.array([vertex]), k, constant(float(value)))
        for vertex, X in found.items()
        for k, value in enumerate(displacement(X))
    ]


def errors(body):
    """L2 norm and H1 seminorm of the error, with a quadrature that is finer than the solution."""
    dx = ufl.Measure("dx", body.mesh.mesh, metadata={"quadrature_degree": 5})
    error = body.u - ufl.as_vector(exact(ufl.SpatialCoordinate(body.mesh.mesh)))
    squares = (ufl.inner(error, error), ufl.inner(ufl.grad(error), ufl.grad(error)))
    parts = [fem.assemble_scalar(fem.form(square * dx)) for square in squares]
    return np.sqrt(COMM.allreduce(np.array(parts)))


def test_manufactured_solution():
    """The exact field's stress and force at a point, against numbers derived elsewhere (D2).

    Those are of a body that is also heated, to ϑ = 50 sin(πX) sin(πY) K.
    """
    mesh = mesh_of(Block(width=1.0, height=1.0, nx=2, ny=2))
    X = ufl.SpatialCoordinate(mesh.mesh)
    theta = 50 * ufl.sin(np.pi * X[0]) * ufl.sin(np.pi * X[1])
    numbers = LAW.parameters | {"expansion": 1e-4}
    F = ufl.variable(deformation_gradient(ufl.as_vector(exact(X))))
    P = ufl.diff(neo_hooke(F, theta, numbers), F)
    force = [-sum(P[i, j].dx(j) for j in range(2)) for i in range(2)]
    found = fem.Expression(
        ufl.as_vector([P[0, 0], P[0, 1], P[1, 0], P[1, 1], *force]), np.array([[0.6, 0.8]])
    )
    # the reference point (0.6, 0.8) of the cell at the corner lies at (0.3, 0.4)
    corner = np.flatnonzero((mesh.mesh.geometry.x[cell_nodes(mesh.mesh)].max(1) < 0.6).all(1))
    for cell in corner:
        values = found.eval(mesh.mesh, np.array([cell], np.int32)).ravel()
        expected = (59.853107, -1.0296119, 0.0676240, 59.254878, 197.199694, 250.403795)
        np.testing.assert_allclose(values, expected, rtol=1e-6)
    assert COMM.allreduce(len(corner)) >= 1


@pytest.mark.parametrize("cell", ["quadrilateral", "triangle"])
def test_rates(cell):
    """Linear elements: second order in L2, first in H1, Newton's last steps quadratic."""
    found = []
    for n in (12, 24, 48):
        mesh = mesh_of(Block(width=1.0, height=1.0, nx=n, ny=n, cell=cell))
        body = Manufactured("square", mesh, LAW, constant(0.0), ())
        sides = ("left", "right", "bottom", "top")
        _, report = solve(body, held_at(mesh, sides, exact))
        found.append(errors(body))
        assert report.iterations <= 7
        order = np.log(report.residuals[-2]) / np.log(report.residuals[-3])
        assert order >= 1.6 or report.residuals[-2] < 1e-11
    rates = np.log2(np.array(found[:-1]) / np.array(found[1:]))
    assert (rates[-1] >= (1.95, 0.95)).all(), rates
    assert (rates[-1] <= (2.1, 1.1)).all(), rates
    assert found[-1][0] < 1e-3


@pytest.mark.parametrize("n", [(1, 1, 1), (3, 2, 2)])
@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
def test_uniaxial_strain_of_solids(cell, n):
    """A box between smooth walls: homogeneous whatever the mesh, with the closed form's stress."""
    width, stretch = 2.0, 0.8
    mesh = mesh_of(Box(width=width, height=1.0, depth=3.0, nx=n[0], ny=n[1], nz=n[2], cell=cell))
    body = BodyProblem("box", mesh, LAW, constant(0.0), ())
    walls = {"left": (0, 0.0), "right": (0, (stretch - 1) * width), "bottom": (1, 0.0),
             "top": (1, 0.0), "back": (2, 0.0), "front": (2, 0.0)}  # fmt: skip
    prescribed = [
        Prescribed(0, mesh.surface(name).vertices, axis, constant(value))
        for name, (axis, value) in walls.items()
    ]
    solver, _ = solve(body, prescribed)
    places = body.V.tabulate_dof_coordinates()
    expected = np.zeros_like(places)
    expected[:, 0] = (stretch - 1) * places[:, 0]
    found = body.u.x.array.reshape(-1, 3)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * (1 - stretch) * width)
    axial, lateral = NeoHooke(K, MU).uniaxial_strain(stretch)
    stress = np.tile((axial, lateral, lateral, 0.0, 0.0, 0.0), (len(body.cell_stress()), 1))
    np.testing.assert_allclose(body.cell_stress(), stress, rtol=0, atol=1e-9 * abs(axial))
    forces = solver.reactions()
    side = width * stretch
    areas = dict(zip(walls, (3.0, 3.0, 3.0 * side, 3.0 * side, side, side), strict=True))
    for name, force in zip(walls, forces, strict=True):
        sign = 1 if name in ("right", "top", "front") else -1
        normal = axial if name in ("left", "right") else lateral
        assert force == pytest.approx(sign * normal * areas[name], rel=1e-9)
