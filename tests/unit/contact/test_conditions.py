"""Contact conditions of an interface: slip, forces, rim rule and status, without any body."""

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.contact.conditions import Contact, ContactLaw
from contactfem.contact.state import BARELY, ContactHistory
from contactfem.laws.active_set import ActiveSet, Status
from contactfem.laws.edge_stabilisation import EDGE_COMPLIANCE
from contactfem.laws.friction import Coulomb, frictionless
from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.normals import line_tangents
from contactfem.mortar.search_range import SearchRange

MU = 0.4


def contact(mesh, mu=MU, c=10.0, comm=MPI.COMM_SELF, radius=0.4):
    return Contact(
        comm,
        mesh,
        ContactLaw(
            Coulomb(mu) if mu else frictionless,
            np.full(mesh.n_nonmortar, c),
            1.0,
            1.0,
            1.0,
            SearchRange.within(radius, len(mesh.nonmortar)),
        ),
    )


def history(interface, x):
    operators = interface.operators(x)
    return ContactHistory.at(operators)


def lower_on(upper, nonmortar=4, height=0.0, X=(1.0, 0.0)):
    """Flat nonmortar facets from X[0] to X[1], under mortar facets between the given places."""
    lower = np.column_stack((np.linspace(*X, nonmortar + 1), np.zeros(nonmortar + 1)))
    above = np.column_stack((upper, np.full(len(upper), height)))
    n = nonmortar + 1
    facets = [k + np.column_stack((np.arange(m), 1 + np.arange(m)))
              for k, m in ((0, nonmortar), (n, len(upper) - 1))]  # fmt: skip
    points = np.vstack((lower, above))
    return InterfaceMesh(n, *facets, points, np.ones(points.shape, bool))


def sticking(interface, x, multiplier=None, before=None):
    """Make conditions with every node that sees the other side sticking."""
    n = interface.mesh.n_nonmortar
    start = ActiveSet(np.full(n, Status.STICK, np.int8), np.zeros((n, 2)))
    multiplier = np.zeros((n, 2)) if multiplier is None else multiplier
    past = history(interface, x if before is None else before)
    return interface.state(interface.operators(x), multiplier, past, start)


def motion(interface, before, after):
    """Slip increment of a step [m], as the conditions of sticking nodes report it."""
    c = sticking(interface, after, before=before)
    normals = c.operators.normals.n
    assert abs(np.einsum("ji,ji->j", c.slip, normals)).max() <= 1e-14 * (1 + abs(c.slip).max())
    return along(c.slip, normals)


def along(vectors, normals):
    """Components of tangential vectors along τ = (n_y, -n_x)."""
    return np.einsum("ji,ji->j", vectors, line_tangents(normals))


@pytest.mark.parametrize("offset", [0.0, 1e3])
def test_rotation_makes_no_slip(chains, offset):
    """Surfaces that turn together by a right angle do not slide, rims and held ends included."""
    mesh, x = chains(seed=2, span=(0.1, 0.93), held=((0, 0), (0, 1)))
    interface = contact(mesh)
    c, s = np.cos(np.pi / 2), np.sin(np.pi / 2)
    turned = x @ np.array(((c, s), (-s, c))) + offset
    slip = motion(interface, x + offset, turned)
    assert abs(slip).max() <= (1e-12 if offset == 0.0 else 1e-9)
    shifted = motion(interface, x, x + np.array((0.3, -0.7)))
    assert abs(shifted).max() <= 1e-12


@pytest.mark.parametrize("held", [(), (0, 4), (1,)])
@pytest.mark.parametrize("distance", [0.04, -0.04])
def test_slip_at_rim_nodes_is_exact(distance, held):
    """A flat side that slides changes what its rim nodes see, but they slide as far as all others.

    The mortar side moves to the right, so the nonmortar one slides to the left by τ = (n_y, -n_x).
    Beside a node without multiplier Φ_j also acts for that node: D⁰ s is the slip times ∫ Φ_j.
    """
    mesh = lower_on(np.linspace(0.2, 0.82, 4))
    mesh.free[list(held)] = False
    interface = contact(mesh)
    after = mesh.X.copy()
    after[mesh.n_nonmortar :, 0] += distance
    start = interface.operators(mesh.X)
    seen = start.D > 0
    assert seen.sum() >= 3
    assert start.coverage[seen].min() < 0.5 or held
    width = np.ravel(start.M[:, mesh.n_nonmortar :].sum(1)) if held else start.D
    slip = motion(interface, mesh.X, after)
    np.testing.assert_allclose(slip * start.D, -distance * width, rtol=0, atol=1e-13)
    np.testing.assert_allclose(
        slip[seen], -distance * (width[seen] / start.D[seen]), rtol=0, atol=1e-12
    )


def test_slip_of_a_moving_nonmortar_side():
    """Along τ = (n_y, -n_x): above a nonmortar side that moves to the right it slips by +."""
    mesh = lower_on(np.linspace(-1.0, 2.0, 5))
    after = mesh.X.copy()
    after[: mesh.n_nonmortar] += np.array((0.02, 0.0))
    slip = motion(contact(mesh), mesh.X, after)
    np.testing.assert_allclose(slip, 0.02, rtol=0, atol=1e-13)


def test_relative_motion_does_not_see_the_origin(chains):
    """Positions times the change of D and M, but never positions alone."""
    mesh, x = chains(seed=5)
    interface = contact(mesh)
    before = history(interface, x)
    rng = np.random.default_rng(0)
    after = x + 0.01 * rng.normal(size=x.shape)
    here = interface.motion(interface.operators(after), before).w
    far = interface.motion(interface.operators(after + 1e3), history(interface, x + 1e3)).w
    np.testing.assert_allclose(far, here, rtol=0, atol=1e-12)


@pytest.mark.parametrize("height", [-0.03, 0.0, 0.05])
def test_gap_is_the_distance(height):
    """Open is positive; a node that faces nothing has no gap and is open."""
    mesh = lower_on(np.linspace(0.3, 2.0, 5), height=height)
    interface = contact(mesh)
    operators = interface.operators(mesh.X)
    covered = operators.D > 0
    np.testing.assert_array_equal(covered, [True, True, True, True, False])
    np.testing.assert_allclose(operators.gap[covered], height, atol=1e-15)
    assert operators.gap[4] == np.inf
    np.testing.assert_allclose(operators.full, [0.125, 0.25, 0.25, 0.25, 0.125])
    np.testing.assert_allclose(operators.coverage[:2], 1.0, rtol=1e-14)
    n = mesh.n_nonmortar
    c = interface.state(operators, np.zeros((n, 2)), history(interface, mesh.X))
    np.testing.assert_array_equal(c.active, covered & (height < 0))


def test_forces_balance(chains):
    """Nodal forces sum to zero: what the nonmortar side loses the mortar side gains."""
    mesh, x = chains(seed=3, held=((2, 1), (0, 0), (0, 1)))
    interface = contact(mesh)
    rng = np.random.default_rng(0)
    c = sticking(interface, x, rng.normal(size=(mesh.n_nonmortar, 2)))
    operators = c.operators
    force = c.nodal_forces()
    assert abs(force[: mesh.n_nonmortar]).max() > 0.05
    np.testing.assert_allclose(force.sum(0), 0, atol=1e-15)
    mine = operators.D[:, None] * c.multiplier.vector
    mine -= operators.M[:, : mesh.n_nonmortar].T @ c.multiplier.vector
    np.testing.assert_allclose(force[: mesh.n_nonmortar], mine, atol=1e-16)


def test_uniform_pressure_gives_uniform_forces():
    """Constant p on matching or other meshes: nodes carry p times their share of the length."""
    mesh = lower_on(np.array([0.0, 0.3, 0.35, 0.8, 1.0]))
    interface = contact(mesh)
    n = mesh.n_nonmortar
    c = sticking(interface, mesh.X, np.tile((0.0, 7.0), (n, 1)))
    np.testing.assert_allclose(c.pressure, 7.0)
    force = c.nodal_forces()
    np.testing.assert_allclose(force[:n, 1], 7 * np.array([0.125, 0.25, 0.25, 0.25, 0.125]))
    upper = -7 * np.array([0.15, 0.175, 0.25, 0.325, 0.1])
    np.testing.assert_allclose(force[n:, 1], upper, rtol=1e-13)


STATES = {  # pressure, traction; on a closed gap
    "open": ((-1.0, 0.0), Status.OPEN, 0),
    "stick": ((1.0, 0.39), Status.STICK, 0),
    "slip": ((1.0, 0.41), Status.SLIP, 1),
    "slip back": ((1.0, -0.41), Status.SLIP, -1),
}


@pytest.mark.parametrize("name", STATES)
def test_status_and_rows(name):
    """The rows of each status, from multipliers along n and τ of a closed interface."""
    (p, t), status, direction = STATES[name]
    mesh = lower_on(np.linspace(0.0, 1.0, 4))
    interface = contact(mesh)
    operators = interface.operators(mesh.X)
    n = mesh.n_nonmortar
    c = interface.state(operators, np.tile((t, p), (n, 1)), history(interface, mesh.X))
    assert (c.status == status).all()
    normals = operators.normals.n
    np.testing.assert_allclose(along(c.active_set.direction, normals), direction, atol=1e-15)
    np.testing.assert_allclose(c.residuals.normal, 0, atol=1e-15)
    row = t - MU * direction * p if status == Status.SLIP else 0.0
    np.testing.assert_allclose(along(c.residuals.tangential, normals), row, atol=1e-15)
    np.testing.assert_allclose(c.multiplier.vector, [[t, p]] * n if c.active.all() else 0.0)


def test_nodes_without_multiplier_have_no_status():
    mesh = lower_on(np.linspace(0.0, 1.0, 4))
    mesh.free[0] = False
    interface = contact(mesh)
    operators = interface.operators(mesh.X)
    pressed = np.tile((0.0, 1.0), (mesh.n_nonmortar, 1))
    c = interface.state(operators, pressed, history(interface, mesh.X))
    np.testing.assert_array_equal(c.status, [Status.NONE] + 4 * [Status.STICK])
    assert operators.D[0] == 0
    assert not c.active[0]


def test_rim_rule():
    """A barely covered node is tied to its better covered neighbour, by κ times the difference."""
    mesh = lower_on(np.array([-1.0, 0.30, 0.55]))  # covers 0.05 of the facet from 0.75 to 0.5
    c = 10.0
    interface = contact(mesh, c=c)
    operators = interface.operators(mesh.X)
    share = 0.2  # of that facet
    f = np.array([0.0, share**2 / 2, share - share**2 / 2 + 0.5])
    np.testing.assert_allclose(operators.coverage[:3], f, rtol=1e-12)
    n = mesh.n_nonmortar
    multiplier = np.column_stack((np.zeros(n), [9.0, 3.0, 2.0, 1.0, 1.0]))
    found = interface.state(operators, multiplier, history(interface, mesh.X))
    kappa = EDGE_COMPLIANCE / c * (1 / (2 * f[1]) - 1)
    np.testing.assert_array_equal((found.edge.nodes, found.edge.neighbours), [[1], [2]])
    np.testing.assert_allclose(found.edge.compliance, [0, kappa, 0, 0, 0], rtol=1e-12)
    np.testing.assert_allclose(found.residuals.normal, [0, kappa * (3 - 2), 0, 0, 0], atol=1e-14)


def test_newly_covered_node_follows_its_neighbour():
    """It has no slip yet, as D⁰ = 0, so it takes the slip direction of the node it is tied to."""
    before = lower_on(np.array([-1.0, 0.2, 0.45]))
    after = before.X.copy()
    after[before.n_nonmortar :, 0] += 0.1
    interface = contact(before)
    operators = interface.operators(after)
    start = history(interface, before.X)
    assert start.D[1] == 0 < operators.D[1]
    pressed = np.tile((-1.0, 1.0), (before.n_nonmortar, 1))  # |t| > μ p: slips
    c = interface.state(operators, pressed, start)
    assert dict(zip(c.edge.nodes, c.edge.neighbours, strict=True))[1] == 2
    direction = along(c.active_set.direction, operators.normals.n)
    assert c.status[1] == Status.SLIP
    np.testing.assert_allclose(direction[1:3], -1)
    np.testing.assert_array_equal(c.slip[1], 0)


@pytest.mark.mpi
@pytest.mark.quick
@pytest.mark.parametrize("facets", [1, 2, 11])
def test_ranks_agree(chains, facets):
    """Ranks share the facets, even too few for all; the operators are those of one rank."""
    mesh, x = chains(facets, 8, seed=1, held=((0, 0), (0, 1)))
    alone, shared = contact(mesh).operators(x), contact(mesh, comm=MPI.COMM_WORLD).operators(x)
    np.testing.assert_allclose(shared.D, alone.D, rtol=0, atol=1e-15)
    np.testing.assert_allclose(shared.M.toarray(), alone.M.toarray(), rtol=0, atol=1e-15)
    np.testing.assert_allclose(shared.gap, alone.gap, rtol=0, atol=1e-13)


def test_reported_multipliers_of_barely_covered_nodes():
    """p_k - g/κ and t_k, whatever the quotient of two vanishing numbers says."""
    mesh = lower_on(np.array([-1.0, 0.3, 0.5075]))  # covers 0.03 of the facet from 0.75 to 0.5
    interface = contact(mesh)
    operators = interface.operators(mesh.X)
    n = mesh.n_nonmortar
    assert 0.0 < operators.coverage[1] < BARELY
    multiplier = np.column_stack((np.full(n, 0.1), np.full(n, 2.0)))
    multiplier[1] = 7e5, 9e5
    c = interface.state(operators, multiplier, history(interface, mesh.X))
    np.testing.assert_allclose(c.pressure[1:], 2.0, rtol=1e-12)
    np.testing.assert_allclose(c.traction[1], c.traction[2], rtol=1e-12)
    assert c.multiplier.pressure[1] == 9e5
