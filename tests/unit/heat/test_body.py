"""Heat of one body: its forms against closed integrals, and each matrix against its action."""

import numpy as np
import pytest

from mpi4py import MPI
from petsc4py import PETSc

from contactfem.common.time_table import Table, constant
from contactfem.fem.body_mesh import distribute
from contactfem.heat.body import HeatBody, HeatLaw, HeatLoad
from contactfem.meshes.block import Block

COMM = MPI.COMM_SELF
K, CAPACITY = 0.2, 2e6
CELLS = pytest.mark.parametrize("cell", ["quadrilateral", "triangle"])
A, B = 0.3, -0.2  # stretches less one of a homogeneous deformation


def body(cell="quadrilateral", loads=(), law=None, corner=(0.0, 0.0), **settings):
    """Block of 2 by 1 m with its lower left corner somewhere."""
    data = Block(width=2.0, height=1.0, nx=3, ny=2, cell=cell, corner=corner).build()
    law = law or HeatLaw(K, CAPACITY)
    return HeatBody("block", distribute(COMM, data), law, loads, **settings)


def set_field(heat, V, values):
    """Local array of a space from a function of the points (dim, n)."""
    x = V.tabulate_dof_coordinates().T
    return np.asarray(values(x), float).T.ravel()


def stretch(heat):
    """Displace to x = (1 + A) X, (1 + B) Y."""
    heat.u.interpolate(lambda x: np.array([A * x[0], B * x[1]]))


def theta_of(heat, values):
    return set_field(heat, heat.V, values)


@CELLS
def test_what_is_stored(cell):
    """∫ ρ₀ c ϑ of a linear field, per reference volume whatever the deformation."""
    heat = body(cell)
    stretch(heat)
    theta = theta_of(heat, lambda x: 5.0 + 3.0 * x[0] - x[1])
    assert heat.stored(theta).sum() == pytest.approx(CAPACITY * 2.0 * (5.0 + 3.0 - 0.5), rel=1e-13)
    square = (5 + 3 * 1 - 0.5) ** 2 + 9 * 4 / 12 + 1 / 12  # mean of the square of a linear field
    assert heat.stored(theta) @ theta == pytest.approx(CAPACITY * 2.0 * square, rel=1e-13)


@CELLS
def test_conduction_of_a_stretched_body(cell):
    """∫ k J C⁻¹ Grad ϑ · Grad ϑ = k (1+a)(1+b) (g_x²/(1+a)² + g_y²/(1+b)²) V, and no net heat."""
    heat = body(cell)
    theta = theta_of(heat, lambda x: 5.0 + 3.0 * x[0] - x[1])
    assert heat.conducted(theta) @ theta == pytest.approx(K * 2.0 * 10.0, rel=1e-13)
    stretch(heat)
    a, b = 1 + A, 1 + B
    expected = K * 2.0 * a * b * (9 / a**2 + 1 / b**2)
    assert heat.conducted(theta) @ theta == pytest.approx(expected, rel=1e-13)
    assert abs(heat.conducted(theta).sum()) < 1e-12


def test_small_strain_does_not_see_the_displacement():
    heat = body(deforms=False)
    theta = theta_of(heat, lambda x: x[0])
    before = heat.conducted(theta)
    stretch(heat)
    np.testing.assert_array_equal(heat.conducted(theta), before)


@CELLS
@pytest.mark.parametrize("axisymmetric", [False, True])
def test_matrices_are_their_actions(cell, axisymmetric):
    """Storage, and conduction with convection, applied to a random field, sheared and bent."""
    loads = [HeatLoad("top", constant(20.0), 50.0)]
    heat = body(cell, loads, corner=(1.0, 0.0), axisymmetric=axisymmetric)
    heat.u.interpolate(lambda x: np.array([0.1 * x[0] * x[1], 0.2 * x[0] - 0.1 * x[1] ** 2]))
    theta = np.random.default_rng(3).standard_normal(heat.n_dofs)
    for add, action in (
        (heat.add_storage, heat.stored),
        (heat.add_conduction, heat.conducted),
    ):
        A = PETSc.Mat().createDense((heat.n_dofs,) * 2, comm=COMM)
        A.setUp()
        A.setLGMap(*[PETSc.LGMap().create(np.arange(heat.n_dofs, dtype=np.int32), comm=COMM)] * 2)
        add(A)
        A.assemble()
        dense = A.getDenseArray()
        np.testing.assert_allclose(dense, dense.T, atol=1e-12 * np.abs(dense).max())
        expected = action(theta)
        scale = np.abs(expected).max()
        np.testing.assert_allclose(dense @ theta, expected, rtol=0, atol=1e-12 * scale)


@CELLS
@pytest.mark.parametrize("axisymmetric", [False, True])
def test_loads(cell, axisymmetric):
    """Sources per reference volume, fluxes and convection per current area, over time."""
    ramp = Table((0.0, 2.0), (0.0, 10.0))
    volume = 2.0 * (4 * np.pi if axisymmetric else 1.0)
    stretched = (1 + A) * 2.0 * (4 * np.pi * (1 + A) if axisymmetric else 1.0)
    for load, expected in (
        (HeatLoad(None, ramp), 5.0 * volume),
        (HeatLoad("top", ramp), 5.0 * stretched),
        (HeatLoad("top", ramp, 50.0), 50.0 * 5.0 * stretched),
        (HeatLoad("top", lambda x, t: t + 0.0 * x[0]), 1.0 * stretched),
        (HeatLoad(None, lambda x, t: t * x[1]), 0.5 * volume),
    ):
        heat = body(cell, [load], corner=(1.0, 0.0), axisymmetric=axisymmetric)
        stretch(heat)
        assert heat.supplied(1.0).sum() == pytest.approx(expected, rel=1e-12)
        assert heat.supplied(0.0).sum() == 0.0


def test_convection_takes_with_the_temperature():
    """h ϑ leaves through the current surface."""
    heat = body(loads=[HeatLoad("right", constant(0.0), 50.0)])
    stretch(heat)
    theta = theta_of(heat, lambda x: 7.0 + 0.0 * x[0])
    assert heat.conducted(theta).sum() == pytest.approx(50.0 * 7.0 * (1 + B), rel=1e-12)


@CELLS
@pytest.mark.parametrize("deforms", [True, False])
def test_heat_of_straining(cell, deforms):
    """3 α K θ times the growth of ln J, or of tr ε where strain is small, over the step."""
    heat = body(cell, law=HeatLaw(K, CAPACITY, cooling=1e5), deforms=deforms)
    old = set_field(heat, heat.displacement_space, lambda x: np.array([0.07 * x[0], 0.0 * x[1]]))
    stretch(heat)
    theta = theta_of(heat, lambda x: 303.0 + 0.0 * x[0])
    growth = np.log((1 + A) * (1 + B) / 1.07) if deforms else A + B - 0.07
    expected = 1e5 * 303.0 * growth / 0.5 * 2.0
    assert heat.cooled(theta, old, 0.5).sum() == pytest.approx(expected, rel=1e-12)
    assert not body(cell).cooled(theta, old, 0.5).any()


def test_flux_in_the_deformed_configuration():
    """q = -k F⁻ᵀ Grad ϑ at the cells."""
    heat = body("triangle")
    stretch(heat)
    heat.theta.x.array[:] = theta_of(heat, lambda x: 3.0 * x[0] - x[1])
    np.testing.assert_allclose(heat.cell_flux()[:, 0], -K * 3.0 / (1 + A), rtol=1e-12)
    np.testing.assert_allclose(heat.cell_flux()[:, 1], K / (1 + B), rtol=1e-12)


def test_radius_of_the_circumference():
    """Storage around an axis: 2π r dr dz."""
    heat = body(corner=(1.0, 0.0), axisymmetric=True)
    theta = theta_of(heat, lambda x: x[0])
    expected = CAPACITY * 2 * np.pi * (3.0**3 - 1.0) / 3.0
    assert heat.stored(theta).sum() == pytest.approx(expected, rel=1e-12)
