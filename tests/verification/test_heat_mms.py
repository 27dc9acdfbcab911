"""A manufactured solution of heat at finite strain: rates with exact and computed motion."""

import basix.ufl
import numpy as np
import pytest
import ufl
from dolfinx import fem

from mpi4py import MPI

from contactfem.common.time_table import constant
from contactfem.common.timers import Timers
from contactfem.fem.body_mesh import distribute
from contactfem.fem.dof_numbering import Prescribed
from contactfem.forms.energies import neo_hooke
from contactfem.forms.mechanics import dead_load
from contactfem.heat.body import HeatBody, HeatLaw, HeatLoad
from contactfem.heat.system import HeatStepInput, HeatSystem, PrescribedTemperature
from contactfem.heat.time_schemes import scheme
from contactfem.mechanics.body import BodyProblem, Law
from contactfem.mechanics.bulk_system import System
from contactfem.meshes.block import Block
from contactfem.solvers.newton import NewtonSolver, StepInput
from contactfem.thermomechanics.body_transfer import BodyLink
from contactfem.verification.manufactured import FiniteStrain

COMM = MPI.COMM_WORLD
# the rubber of the paper, N-mm-s-K
TIRE = {"bulk_modulus": 333.0, "shear_modulus": 35.0, "expansion": 1e-4}
EXACT = FiniteStrain(
    **TIRE, conductivity=0.2, heat_capacity=0.0, amplitude=(0.1, 0.08), temperature=50.0
)
SIDES = ("left", "right", "bottom", "top")
pytestmark = pytest.mark.mpi


def square(n, cell):
    builder = Block(width=1.0, height=1.0, nx=n, ny=n, cell=cell)
    return distribute(COMM, builder.build() if COMM.rank == 0 else None)


def around(mesh):
    return np.unique(np.concatenate([mesh.surface(side).vertices for side in SIDES]))


def heat_of(mesh, exact=EXACT):
    """Heat problem under the exact source."""
    law = HeatLaw(exact.conductivity, exact.heat_capacity)
    return HeatBody("square", mesh, law, [HeatLoad(None, exact.heat_source)])


def warmed(body, name="steady", steps=1, exact=EXACT):
    """Temperatures after a second at the body's displacement, boundary prescribed."""
    held = [PrescribedTemperature(0, around(body.mesh), exact.theta)]
    system = HeatSystem(COMM, [body], held, scheme(name), {}, Timers())
    start = fem.Function(body.V)
    start.interpolate(lambda x: exact.theta(x, 0.0))
    theta = [start.x.array.copy()]
    for k in range(steps):
        step = HeatStepInput(k / steps, 1.0 / steps, theta, [body.u.x.array.copy()], [])
        solution = system.solve(step)
        assert solution.reason == ""
        theta = solution.theta
    body.theta.x.array[:] = theta[0]


def errors(field, exact):
    """L2 norm and H1 seminorm of the error; the exact field is taken of degree 3."""
    domain = field.function_space.mesh
    shape = field.function_space.value_shape
    element = basix.ufl.element("Lagrange", domain.basix_cell(), 3, shape=shape)
    target = fem.Function(fem.functionspace(domain, element))
    target.interpolate(exact)
    dx = ufl.Measure("dx", domain, metadata={"quadrature_degree": 6})
    error = field - target
    squares = (ufl.inner(error, error), ufl.inner(ufl.grad(error), ufl.grad(error)))
    parts = [fem.assemble_scalar(fem.form(square * dx)) for square in squares]
    return np.sqrt(COMM.allreduce(np.array(parts)))


def rates(found):
    return np.log2(np.array(found[:-1]) / np.array(found[1:]))


@pytest.mark.parametrize("cell", ["quadrilateral", "triangle"])
def test_conduction_on_a_given_deformation(cell):
    """k J C⁻¹ at the exact displacement: order 2 in L2, 1 in H1 (D2)."""
    found = []
    for n in (8, 16, 32):
        body = heat_of(square(n, cell))
        body.u.interpolate(EXACT.displacement)
        warmed(body)
        found.append(errors(body.theta, EXACT.theta))
    assert (rates(found) > (1.9, 0.95)).all(), rates(found)


def test_storage_in_time():
    """A temperature that fades, ρ₀ c per reference volume: order 2 of cells and steps together."""
    exact = FiniteStrain(
        **TIRE,
        conductivity=0.2,
        heat_capacity=2.0,
        amplitude=(0.1, 0.08),
        temperature=50.0,
        rate=-1.0,
    )
    found = []
    for n in (8, 16, 32):
        body = heat_of(square(n, "quadrilateral"), exact)
        body.u.interpolate(exact.displacement)
        warmed(body, "cG(1)", n // 2, exact)
        found.append(errors(body.theta, lambda x: exact.theta(x, 1.0))[0])
    assert (rates(found) > 1.9).all(), rates(found)


class Forced(BodyProblem):
    """The body under the exact solution's body force, which varies in space."""

    def _residual_form(self, loads):
        form = super()._residual_form(loads)
        element = basix.ufl.element("Lagrange", self.mesh.mesh.basix_cell(), 3, shape=(2,))
        force = fem.Function(fem.functionspace(self.mesh.mesh, element))
        force.interpolate(EXACT.body_force)
        dx = ufl.Measure("dx", self.mesh.mesh, metadata={"quadrature_degree": 4})
        return form - dead_load(force, ufl.TestFunction(self.V), dx)


def moved(body):
    """Equilibrium of one body at its temperature with the exact displacement around it."""
    mesh = body.mesh
    held = {}
    for side in SIDES:
        surface = mesh.surface(side)
        held |= dict(zip(surface.vertices.tolist(), surface.X, strict=True))
    prescribed = [
        Prescribed(0, np.array([vertex]), k, constant(float(value)))
        for vertex, X in held.items()
        for k, value in enumerate(EXACT.displacement(X[:, None])[:, 0])
    ]
    solver = NewtonSolver(System(COMM, [body], prescribed, []), (), 1e-12, 20, {}, Timers())
    report = solver.solve(StepInput(1.0, 1.0, (), (), known=False))
    assert report.converged, report.reason


@pytest.mark.parametrize(
    ("own", "cell"), [(False, "quadrilateral"), (True, "quadrilateral"), (True, "triangle")]
)
def test_coupled(own, cell):
    """Mechanics at the computed temperature, heat at the computed motion, on one mesh or on two.

    Passes until nothing changes; u and θ at orders 2 and 1 (D2).
    """
    law = Law(neo_hooke, TIRE, 101.446, False, False)
    found = []
    for n in (8, 16, 32):
        mesh = square(n, "quadrilateral")
        thermal = square(3 * n // 2, cell) if own else mesh
        mechanics = Forced("square", mesh, law, None, ())
        heat = heat_of(thermal)
        link = BodyLink(COMM, mechanics, heat)
        for _ in range(4):
            link.set_temperature(heat.theta.x.array)
            moved(mechanics)
            link.set_displacement()
            warmed(heat)
        found.append(
            np.concatenate(
                (errors(mechanics.u, EXACT.displacement), errors(heat.theta, EXACT.theta))
            )
        )
    assert (rates(found) > (1.9, 0.95, 1.9, 0.95)).all(), rates(found)
