"""Energies and weak forms at points and on single cells, against exact states of the solid."""

import basix
import basix.ufl
import numpy as np
import pytest
import ufl
from dolfinx import fem

from mpi4py import MPI

from contactfem.common.time_table import Table, constant
from contactfem.fem.body_mesh import distribute
from contactfem.fem.compat import create_mesh
from contactfem.forms.energies import linear_elastic, neo_hooke
from contactfem.forms.kinematics import deformation_gradient, thermal_volume_ratio
from contactfem.forms.mechanics import cauchy_stress, small_strain_stress
from contactfem.mechanics.body import BodyProblem, Law, Load
from contactfem.meshes.block import Block
from contactfem.meshes.box import Box
from contactfem.verification.homogeneous import NeoHooke

K, MU, ALPHA = 333.0, 35.0, 1e-4
NUMBERS = {"bulk_modulus": K, "shear_modulus": MU, "expansion": ALPHA}
E_MODULUS = 101.446
VERTICES = {"quadrilateral": 4, "triangle": 3, "hexahedron": 8, "tetrahedron": 4}


class Cell:
    """One reference cell with a displacement: stress of a law at its quadrature points."""

    def __init__(self, name, energy=neo_hooke, stress=cauchy_stress):
        X = basix.geometry(getattr(basix.CellType, name))
        self.dim = X.shape[1]
        element = basix.ufl.element("Lagrange", name, 1, shape=(self.dim,))
        cells = np.arange(len(X), dtype=np.int64)[None]
        self.mesh = create_mesh(MPI.COMM_SELF, cells, X, ufl.Mesh(element))
        self.u = fem.Function(fem.functionspace(self.mesh, element))
        self.theta = fem.Constant(self.mesh, 0.0)
        parameters = {k: fem.Constant(self.mesh, v) for k, v in NUMBERS.items()}
        self.points = basix.make_quadrature(getattr(basix.CellType, name), 2)[0]
        found = stress(deformation_gradient(self.u), self.theta, energy, parameters)
        self._expression = fem.Expression(found, self.points)

    def stress(self, F, theta=0.0):
        """Stress (points, 3, 3) at a deformation gradient, whose plane part displaces the cell."""
        H = np.asarray(F)[: self.dim, : self.dim] - np.eye(self.dim)
        self.u.interpolate(lambda x: H @ x[: self.dim])
        self.theta.value = theta
        cells = np.zeros(1, np.int32)
        return self._expression.eval(self.mesh, cells).reshape(len(self.points), 3, 3)


@pytest.fixture(scope="module")
def cells():
    """One cell of every kind, compiled once."""
    return {name: Cell(name) for name in VERTICES}


SOLID, PLANE = ("hexahedron", "tetrahedron"), ("quadrilateral", "triangle")
POINTS = [  # kind of cells, F, ϑ, and some stresses of benchmark D1
    (SOLID, (0.5, 1.3727064, 1.3727064), 0, {(0, 0): -63.172833, (1, 1): 0}),
    (SOLID, (0.7, 1.1762676, 1.1762676), 0, {(0, 0): -32.988559, (2, 2): 0}),
    (SOLID, (0.9, 1.0487183, 1.0487183), 0, {(0, 0): -10.317661}),
    (SOLID, (1.2, 0.9222183, 0.9222183), 0, {(0, 0): 19.944071}),
    (PLANE, (0.5, 1.6817739, 1), 0, {(0, 0): -120.461841, (1, 1): 0, (2, 2): -85.421639}),
    (PLANE, (0.7, 1.3258815, 1), 0, {(0, 0): -50.253882, (1, 1): 0, (2, 2): -30.040749}),
    (PLANE, (0.9, 1.0891423, 1), 0, {(0, 0): -13.613738, (2, 2): -6.738680}),
    (PLANE, (0.8, 1, 1), 0, {(0, 0): -105.067674, (1, 1): -86.791418, (2, 2): -86.791418}),
    (PLANE, (0.95, 1, 1), 0, {(0, 0): -20.457692, (1, 1): -16.740628}),
    (SOLID, (1.0100501671,) * 3, 100, {(0, 0): 0, (1, 1): 0, (2, 2): 0}),
    (SOLID, (1, 1, 1), 100, {(0, 0): -9.99, (1, 1): -9.99, (2, 2): -9.99}),
    (PLANE, (1, 1, 1), 100, {(0, 0): -9.99, (1, 1): -9.99, (2, 2): -9.99}),
    (SOLID, (1, 1.0146001670, 1.0146001670), 100, {(0, 0): -0.9809156, (1, 1): 0}),
    (PLANE, (1, 1.0266322, 1), 100, {(0, 0): -1.8081125, (1, 1): 0, (2, 2): -1.8081125}),
]


@pytest.mark.parametrize(("kinds", "stretches", "theta", "expected"), POINTS)
def test_published_points(cells, kinds, stretches, theta, expected):
    """Numbers computed elsewhere, to the seven digits that they have."""
    for kind in kinds:
        stress = cells[kind].stress(np.diag(stretches), theta)
        for (i, j), value in expected.items():
            np.testing.assert_allclose(stress[:, i, j], value, rtol=3e-7, atol=3e-5)


@pytest.mark.parametrize("theta", [0.0, 100.0, -40.0])
@pytest.mark.parametrize("kind", VERTICES)
def test_stress_at_random_states(cells, kind, theta):
    """Against the closed form of the Cauchy stress at any deformation, to 1e-10."""
    rng = np.random.default_rng(1)
    solid = NeoHooke(K, MU, ALPHA, theta)
    dim = cells[kind].dim
    for _ in range(5):
        F = np.eye(3)
        F[:dim, :dim] += 0.3 * rng.uniform(-1, 1, (dim, dim))
        assert np.linalg.det(F) > 0.1
        found, exact = cells[kind].stress(F, theta), solid.cauchy_stress(F)
        np.testing.assert_allclose(found - exact, 0, atol=1e-10 * abs(exact).max())


def test_simple_shear(cells):
    """τ = μ γ and σ11 - σ22 = μ γ²: neither volume nor temperature mixes in."""
    F = np.eye(3)
    F[0, 1] = 0.7
    for kind in VERTICES:
        s = cells[kind].stress(F)[0]
        assert s[0, 1] == pytest.approx(0.7 * MU, rel=1e-12)
        assert s[0, 0] - s[1, 1] == pytest.approx(0.49 * MU, rel=1e-12)


def test_frame(cells):
    """A rotation turns the stress and makes none."""
    c, s = np.cos(0.7), np.sin(0.7)
    R = np.array(((c, -s, 0), (s, c, 0), (0, 0, 1)))
    F = np.array(((1.2, 0.3, 0), (-0.1, 0.9, 0), (0, 0, 1)))
    for kind in VERTICES:
        np.testing.assert_allclose(cells[kind].stress(R), 0, atol=1e-12)
        turned = R @ cells[kind].stress(F, 30.0) @ R.T
        np.testing.assert_allclose(cells[kind].stress(R @ F, 30.0), turned, atol=1e-11)


@pytest.mark.parametrize("kind", ["quadrilateral", "hexahedron"])
def test_small_strain(kind):
    """Hooke's law with thermal strain, and the limit of the finite law."""
    cell = Cell(kind, linear_elastic, small_strain_stress)
    rng = np.random.default_rng(2)
    dim, theta = cell.dim, 20.0
    H = np.zeros((3, 3))
    H[:dim, :dim] = rng.uniform(-1, 1, (dim, dim))
    strain = (H + H.T) / 2
    volume = np.trace(strain)
    expected = K * (volume - 3 * ALPHA * theta) * np.eye(3)
    expected += 2 * MU * (strain - volume / 3 * np.eye(3))
    np.testing.assert_allclose(cell.stress(np.eye(3) + H, theta)[0], expected, rtol=1e-12)
    tiny = 1e-7
    finite = NeoHooke(K, MU, ALPHA, tiny * theta).cauchy_stress(np.eye(3) + tiny * H)
    np.testing.assert_allclose(finite / tiny, expected, atol=1e-3)


def test_kinematics(cells):
    """Plane strain has a third dimension, in which nothing moves."""
    cell = cells["triangle"]
    F = fem.Expression(deformation_gradient(cell.u), cell.points)
    cell.stress(np.diag((1.5, 0.8, 1.0)))
    found = F.eval(cell.mesh, np.zeros(1, np.int32)).reshape(-1, 3, 3)
    np.testing.assert_allclose(found[0], np.diag((1.5, 0.8, 1.0)), atol=1e-15)
    ratio = thermal_volume_ratio(ufl.as_ufl(100.0), ufl.as_ufl(1e-4))
    assert float(ratio) == pytest.approx(np.exp(0.03), rel=1e-15)


LOADS = {
    "none": (),
    "traction": (Load("top", (constant(2.0), constant(-3.0))),),
    "body force": (Load(None, (constant(1.5), constant(-4.0))),),
    "pressure": (Load("top", (constant(5.0),)), Load("right", (constant(-2.0),))),
}


def block(loads, energy=neo_hooke, cell="quadrilateral", small=False):
    """Make a block of 2 by 1 with loads, at full load and 50 K."""
    data = Block(width=2.0, height=1.0, nx=3, ny=2, cell=cell).build()
    law = Law(energy, NUMBERS, E_MODULUS, small, small)
    body = BodyProblem("b", distribute(MPI.COMM_SELF, data), law, constant(50.0), loads)
    body.set_time(1.0, 1.0)
    return body


def resultant(body):
    return body.residual().reshape(-1, 2).sum(0)


def test_loads_add_up():
    """Internal forces have no resultant; external ones have that of the load, with its sign."""
    rng = np.random.default_rng(0)
    expected = {"none": (0, 0), "traction": (4.0, -6.0), "body force": (3.0, -8.0)}
    for name, force in expected.items():
        body = block(LOADS[name])
        body.u.x.array[:] = 0.05 * rng.normal(size=len(body.u.x.array))
        np.testing.assert_allclose(resultant(body), -np.array(force), atol=1e-12)


@pytest.mark.parametrize("small", [False, True])
def test_pressure_follows_the_surface(small):
    """-∫ p n da = -p (dy, -dx) of the deformed side at finite strain, else of the undeformed."""
    body = block((Load("top", (constant(5.0),)),), linear_elastic if small else neo_hooke,
                 small=small)  # fmt: skip
    H = np.array(((0.1, 0.4), (-0.2, 0.15)))
    body.u.interpolate(lambda x: H @ x[:2])
    edge = np.array((-2.0, 0.0)) if small else (np.eye(2) + H) @ (-2.0, 0.0)
    force = -5.0 * np.array((edge[1], -edge[0]))
    np.testing.assert_allclose(resultant(body), -force, rtol=1e-12, atol=1e-12)


def test_loads_over_time():
    """Constants are reached linearly over the first step, tables at their times."""
    table = Table((0.0, 2.0), (0.0, 8.0))
    body = block((Load(None, (constant(1.0), table)),))
    for t, force in ((0.25, (0.5, 1.0)), (0.5, (1.0, 2.0)), (2.0, (1.0, 8.0))):
        body.set_time(t, 0.5)
        np.testing.assert_allclose(resultant(body), -2 * np.array(force), atol=1e-12)


@pytest.mark.parametrize("cell", ["quadrilateral", "triangle"])
@pytest.mark.parametrize("name", LOADS)
def test_tangent_action(name, cell):
    """Residual's derivative by central differences, follower pressure included."""
    body = block(LOADS[name], cell=cell)
    rng = np.random.default_rng(3)
    u = 0.05 * rng.normal(size=len(body.u.x.array))
    v, h, ends = rng.normal(size=len(u)), 1e-6, []
    for step in (-h, h):
        body.u.x.array[:] = u + step * v
        ends.append(body.residual())
    body.u.x.array[:] = u
    exact = body.tangent_action(v)
    difference = (ends[1] - ends[0]) / (2 * h)
    np.testing.assert_allclose(difference, exact, rtol=0, atol=1e-7 * abs(exact).max())


def test_cell_stress():
    """What is written for pictures is the Cauchy stress, in the order xx, yy, zz, xy, yz, xz."""
    body = block(())
    H = np.array(((-0.1, 0.2), (0.05, 0.1)))
    body.u.interpolate(lambda x: H @ x[:2])
    F = np.eye(3)
    F[:2, :2] += H
    s = NeoHooke(K, MU, ALPHA, 50.0).cauchy_stress(F)
    expected = (s[0, 0], s[1, 1], s[2, 2], s[0, 1], 0, 0)
    np.testing.assert_allclose(body.cell_stress(), [expected] * 6, rtol=1e-12, atol=1e-12)


def test_solid_body():
    """Three components in three dimensions: stress, and forces with no resultant."""
    data = Box(width=1.0, height=1.0, depth=1.0, nx=1, ny=1, nz=1, cell="tetrahedron").build()
    law = Law(neo_hooke, NUMBERS, E_MODULUS, False, False)
    body = BodyProblem("b", distribute(MPI.COMM_SELF, data), law, constant(0.0), ())
    F = np.eye(3) + 0.2 * np.random.default_rng(0).uniform(-1, 1, (3, 3))
    body.u.interpolate(lambda x: (F - np.eye(3)) @ x)
    s = NeoHooke(K, MU).cauchy_stress(F)
    expected = (s[0, 0], s[1, 1], s[2, 2], s[0, 1], s[1, 2], s[0, 2])
    np.testing.assert_allclose(body.cell_stress(), [expected] * 6, rtol=1e-12)
    np.testing.assert_allclose(body.residual().reshape(-1, 3).sum(0), 0, atol=1e-12)
