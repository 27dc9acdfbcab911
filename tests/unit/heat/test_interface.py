"""Heat through one interface: closed integrals on meshes that do not match, what is conserved."""

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.common.time_table import constant
from contactfem.common.timers import Timers
from contactfem.fem.body_mesh import distribute
from contactfem.heat.body import HeatBody, HeatLaw
from contactfem.heat.interface import HeatInterface, HeatInterfaceLaw
from contactfem.heat.interface_nodes import HeatNodes
from contactfem.heat.system import HeatStepInput, HeatSystem, PrescribedTemperature
from contactfem.heat.time_schemes import scheme
from contactfem.laws.conductance import Constant, GasGap, PowerLaw
from contactfem.meshes.block import Block
from contactfem.mortar.search_range import SearchRange
from contactfem.mortar.sides import BodySide, plane_side

WIDTH = 2.0


class Pair:
    """Block on block or on a plane, with their heat problems and one interface."""

    def __init__(self, law, *, n=(5, 7), rigid=False, corner=0.0, comm=MPI.COMM_SELF, **settings):
        lower = Block(width=WIDTH, height=1.0, nx=n[0], ny=2, corner=(corner, 0.0))
        upper = Block(width=WIDTH, height=1.0, nx=n[1], ny=2, corner=(corner, 1.0))
        builders = [lower] if rigid else [lower, upper]
        meshes = [distribute(comm, b.build() if comm.rank == 0 else None) for b in builders]
        self.bodies = [
            HeatBody(name, mesh, HeatLaw(0.2, 2.0), (), **settings)
            for name, mesh in zip(("lower", "upper"), meshes, strict=False)
        ]
        held = [PrescribedTemperature(0, meshes[0].surface("bottom").vertices, constant(10.0))]
        self.system = HeatSystem(comm, self.bodies, held, scheme("cG(1)"), {}, Timers())
        nonmortar = BodySide(0, meshes[0].surface("top"))
        zero = constant(0.0)
        mortar = (
            plane_side([corner + 1.0, 1.0], (0.0, -1.0), 20.0, (zero, zero))
            if rigid
            else BodySide(1, meshes[1].surface("bottom"))
        )
        count = len(nonmortar.surface.X)
        other = mortar.X if rigid else mortar.surface.X
        free = np.ones((count + len(other), 2), bool)
        axisymmetric = bool(settings.get("axisymmetric"))
        self.nodes = HeatNodes(self.bodies, self.system, nonmortar, mortar, free, axisymmetric)
        self.interface = HeatInterface("joint", self.nodes, law)
        self.system.couple([self.interface])
        self.count = count

    def exchange(self, pressure=1.0, dissipation=0.0, power=None, x=None):
        p = np.broadcast_to(np.asarray(pressure, float), self.count)
        d = np.broadcast_to(np.asarray(dissipation, float), self.count)
        x = self.nodes.positions(1.0, 1.0) if x is None else x
        return self.interface.exchange(x, p, d, power)

    @property
    def X(self):
        return self.nodes.mesh.X

    def at(self, function):
        """Values at the nodes of both surfaces."""
        return np.asarray(function(self.X), float)


def law(conductance=None, partition=0.5, obstacle=None, facets=5):
    return HeatInterfaceLaw(conductance, partition, SearchRange.within(0.5, facets), obstacle)


def test_conduction_of_linear_temperatures():
    """∫ h (ϑ_nm - ϑ_m) (δϑ_nm - δϑ_m) for linear fields on either side and a linear pressure."""
    pair = Pair(law(PowerLaw(4.0, 2.0, 1.0)))
    p = 1.0 + pair.X[: pair.count, 0]
    K = pair.exchange(pressure=p).conduction
    below = np.arange(len(pair.X)) < pair.count
    theta = np.where(below, 3.0 + pair.X[:, 0], 1.0 - 2.0 * pair.X[:, 0])
    test = np.where(below, 1.0, pair.X[:, 0])
    # h = 2 (1 + x), [ϑ] = 2 + 3x, [δϑ] = 1 - x on (0, 2): ∫ 2 (1 - x²) (2 + 3x)
    expected = 2.0 * (2.0 * 2 + 3.0 * 2 - 2.0 * 8 / 3 - 3.0 * 16 / 4)
    assert test @ (K @ theta) == pytest.approx(expected, rel=1e-12)
    np.testing.assert_allclose((K @ np.ones(len(theta))), 0.0, atol=1e-12)
    np.testing.assert_allclose((K @ theta).sum(), 0.0, atol=1e-12)
    np.testing.assert_allclose(K.toarray(), K.toarray().T, atol=1e-13)


@pytest.mark.parametrize("partition", [0.0, 0.3, 1.0])
def test_frictional_heat_of_a_linear_density(partition):
    """∫ d (β δϑ_nm + (1 - β) δϑ_m) (21), all of it entering."""
    pair = Pair(law(partition=partition))
    d = 1.0 + pair.X[: pair.count, 0]
    entering = pair.exchange(dissipation=d).friction
    below = np.arange(len(pair.X)) < pair.count
    x = pair.X[:, 0]
    assert entering.sum() == pytest.approx(4.0, rel=1e-13)
    assert entering[below].sum() == pytest.approx(partition * 4.0, abs=1e-13)
    moment = 2.0 + 8.0 / 3.0  # ∫ x (1 + x)
    assert entering[below] @ x[below] == pytest.approx(partition * moment, abs=1e-12)
    assert entering[~below] @ x[~below] == pytest.approx((1 - partition) * moment, abs=1e-12)


def test_power_of_mechanics_is_what_enters():
    """Whatever the interpolated density, its total is scaled; the defect before is told."""
    pair = Pair(law(partition=0.4))
    d = 1.0 + pair.X[: pair.count, 0]
    given = pair.exchange(dissipation=d, power=5.0)
    assert given.friction.sum() == pytest.approx(5.0, rel=1e-14)
    assert given.defect == pytest.approx((4.0 - 5.0) / 5.0, rel=1e-12)
    more = pair.exchange(dissipation=d, power=3.0)
    assert more.defect == pytest.approx((4.0 - 3.0) / 4.0, rel=1e-12)
    lost = pair.exchange(dissipation=0.0, power=3.0)
    assert lost.friction.sum() == pytest.approx(3.0, rel=1e-14)
    assert lost.defect == -1.0
    none = pair.exchange(dissipation=0.0, power=0.0)
    assert not none.friction.any()
    assert none.defect == 0.0


def test_current_area():
    """A surface that is stretched to 1.5 of its length conducts and takes as much more."""
    pair = Pair(law(Constant(3.0)))
    x = pair.X * (1.5, 1.0)
    exchange = pair.exchange(dissipation=2.0, x=x)
    one = (np.arange(len(x)) < pair.count).astype(float)
    assert one @ (exchange.conduction @ one) == pytest.approx(3.0 * 1.5 * WIDTH, rel=1e-12)
    assert exchange.friction.sum() == pytest.approx(2.0 * 1.5 * WIDTH, rel=1e-12)


def test_around_an_axis():
    """2π r in conduction and friction."""
    pair = Pair(law(Constant(3.0)), corner=1.0, axisymmetric=True)
    exchange = pair.exchange(dissipation=2.0)
    one = (np.arange(len(pair.X)) < pair.count).astype(float)
    area = np.pi * (3.0**2 - 1.0)
    assert one @ (exchange.conduction @ one) == pytest.approx(3.0 * area, rel=1e-12)
    assert exchange.friction.sum() == pytest.approx(2.0 * area, rel=1e-12)


def test_gas_across_a_wedge():
    """h = k / (g + g₀) over a gap that opens linearly, ∫ = k ln(1 + 2s/g₀) / s."""
    pair = Pair(law(GasGap(0.5, 0.4), facets=40), n=(40, 56))
    x = pair.X.copy()
    above = np.arange(len(x)) >= pair.count
    x[above, 1] += 0.1 * x[above, 0]
    one = (~above).astype(float)
    found = one @ (pair.exchange(pressure=0.0, x=x).conduction @ one)
    assert found == pytest.approx(0.5 * np.log(1.0 + 0.1 * WIDTH / 0.4) / 0.1, rel=1e-5)


def test_an_open_gap_neither_conducts_nor_breaks():
    """p = 0 with an exponent below one gives zeros, and a surface far away no segments at all."""
    pair = Pair(law(PowerLaw(4.0, 2.0, 0.5)))
    exchange = pair.exchange(pressure=0.0)
    assert np.all(exchange.conduction.data == 0.0)
    away = pair.X + np.where(np.arange(len(pair.X)) < pair.count, 0.0, 9.0)[:, None] * (0.0, 1.0)
    far = pair.exchange(x=away)
    assert far.conduction.nnz == 0
    heat = pair.interface.at_nodes([b.theta.x.array for b in pair.bodies], far, 1.0)
    assert np.isnan(heat.flux).all()


@pytest.mark.parametrize("temperature", [None, 30.0])
def test_an_obstacle(temperature):
    """It conducts where it has a temperature, which its side shows."""
    obstacle = None if temperature is None else constant(temperature)
    pair = Pair(law(Constant(3.0), obstacle=obstacle), rigid=True)
    assert pair.interface.conducts == (temperature is not None)
    exchange = pair.exchange()
    theta = [np.full(pair.bodies[0].n_dofs, 10.0)]
    heat = pair.interface.at_nodes(theta, exchange, 1.0)
    np.testing.assert_allclose(heat.temperature, 10.0)
    if temperature is None:
        assert exchange.conduction.count_nonzero() == 0
        assert np.isnan(heat.mortar_temperature).all()
    else:
        np.testing.assert_allclose(heat.mortar_temperature, 30.0, rtol=1e-12)
        np.testing.assert_allclose(heat.flux, 3.0 * (10.0 - 30.0), rtol=1e-12)


def test_another_coupling_pattern_is_right():
    """After the surfaces have moved on, entries appear that the first matrix did not have."""
    moved = []
    for early in (True, False):
        pair = Pair(law(Constant(3.0)))
        theta = [np.full(b.n_dofs, 5.0 * k) for k, b in enumerate(pair.bodies)]
        pair.system.set_held(0.0, theta)
        u = [b.u.x.array.copy() for b in pair.bodies]
        if early:
            pair.system.solve(HeatStepInput(0.0, 1.0, theta, u, [pair.exchange()]))
        pair.bodies[1].u.interpolate(lambda x: np.array([0.7 + 0.0 * x[0], 0.0 * x[0]]))
        for b in pair.bodies:
            assert b.u.x.array.shape == (2 * b.n_dofs,)
        exchange = pair.exchange()
        solution = pair.system.solve(HeatStepInput(0.0, 1.0, theta, u, [exchange]))
        assert solution.reason == ""
        assert abs(solution.balance.defect) < 1e-12
        moved.append(np.concatenate(solution.theta))
    np.testing.assert_allclose(moved[0], moved[1], rtol=0, atol=1e-12)


@pytest.mark.mpi
@pytest.mark.quick
def test_the_same_on_any_ranks():
    """Conduction, friction and nodal means to 1e-12; a rank may hold no facet."""
    found = []
    for comm in (MPI.COMM_SELF, MPI.COMM_WORLD):
        pair = Pair(law(PowerLaw(4.0, 2.0, 1.5)), n=(2, 9), comm=comm)
        p = 1.0 + pair.X[: pair.count, 0]
        exchange = pair.exchange(pressure=p, dissipation=p, power=7.0)
        theta = [
            (1.0 + k) * b.V.tabulate_dof_coordinates()[:, 0] for k, b in enumerate(pair.bodies)
        ]
        heat = pair.interface.at_nodes(theta, exchange, 1.0)
        found.append([exchange.conduction.toarray(), exchange.friction, *heat])
    for a, b in zip(*found, strict=True):
        np.testing.assert_allclose(b, a, rtol=0, atol=1e-12 * np.abs(a).max())
