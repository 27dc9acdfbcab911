"""The tangent of contact forces and conditions against finite differences."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from mpi4py import MPI

from contactfem.common.time_table import Table
from contactfem.contact.conditions import Contact, ContactLaw
from contactfem.contact.slip import tangential
from contactfem.contact.state import ContactHistory
from contactfem.contact.tangent import RowScales, linearise
from contactfem.laws.active_set import Status
from contactfem.laws.friction import Coulomb, VariableCoulomb
from contactfem.mortar.normals import line_tangents, nodal_normals
from contactfem.mortar.search_range import SearchRange

MU = 0.4
PRESCRIBED = ((0, 0), (9, 0), (9, 1))  # a symmetry line at one end, a Dirichlet node at the other
CASES = {
    "ends beyond": {"nonmortar": 9, "mortar": 11, "span": (-0.05, 1.05)},
    "rim": {"nonmortar": 9, "mortar": 6, "span": (0.15, 0.94)},
    "held": {"nonmortar": 9, "mortar": 6, "span": (-0.05, 0.78), "held": PRESCRIBED},
    "finer mortar": {"nonmortar": 9, "mortar": 31, "span": (0.15, 0.94)},
    "one facet": {"nonmortar": 9, "mortar": 1, "span": (0.15, 0.94)},
    "speed": {"nonmortar": 9, "mortar": 11, "span": (-0.05, 1.05)},
    "pressure": {"nonmortar": 9, "mortar": 11, "span": (-0.05, 1.05)},
    "penalty": {"nonmortar": 8, "mortar": 9, "span": (0.15, 0.94)},
}
SMALL = 1e-6  # the differences are exact to 1e-8


class Scene:
    """An interface at a random state near contact, with nodes of every status."""

    def __init__(self, chains, name, seed, comm=MPI.COMM_SELF):
        rng = np.random.default_rng(seed)
        mesh, start = chains(seed=seed, noise=0.0, wave=0.08, **CASES[name])
        n = mesh.n_nonmortar
        c = 5.0 * rng.uniform(0.5, 2.0, n)
        soft = 0.3 / c if name == "penalty" else np.zeros(1)
        table = Table((0.0, 0.5, 3.0), (0.4, 0.5, 0.2))
        kinds = {
            "speed": VariableCoulomb("speed", table),
            "pressure": VariableCoulomb("pressure", table),
        }
        reach = SearchRange.within(0.3, len(mesh.nonmortar))
        friction = kinds.get(name, Coulomb(MU))
        law = ContactLaw(friction, c, 1.0, 0.7, 1.0, reach, soft, 2.0 * soft)
        self.contact = Contact(comm, mesh, law)
        operators = self.contact.operators(start)
        past = 0.1 * rng.normal(size=n)
        tangents = line_tangents(operators.normals.n)
        past = replace(ContactHistory.at(operators), traction=past[:, None] * tangents)
        self.history = replace(past, dt=0.01)
        self.x = start + 0.004 * rng.normal(size=start.shape)
        normal = nodal_normals(mesh, self.x).n
        p, t = rng.uniform(-0.2, 1.0, (n, 1)), 0.35 * rng.normal(size=(n, 1))
        self.multiplier = p * normal + t * line_tangents(normal)
        self.conditions = self.at(self.x, self.multiplier)
        one, zero = np.ones(n), np.zeros(n)
        scales = RowScales(one, zero), RowScales(zero, one)  # apart, as their units differ
        self.tangents = [linearise(self.contact, self.conditions, s) for s in scales]

    def at(self, x, multiplier):
        """Find the conditions elsewhere."""
        return self.contact.state(self.contact.operators(x), multiplier, self.history)

    def rows(self, x, multiplier):
        """What the tangent linearises: forces on mortar nodes, then conditions in frozen planes."""
        c = self.at(x, multiplier)
        assert not c.active_set.differs_from(self.conditions.active_set).any()
        forces = -(c.operators.M.T @ c.multiplier.vector)
        normal = self.conditions.operators.normals.n
        along = tangential(c.residuals.tangential, normal)
        rows = (forces, c.residuals.normal[:, None] * normal, along)
        return np.concatenate([part.ravel() for part in rows])

    def matrix(self, name):
        """Both tangents as `rows` are ordered."""
        first = 2 * self.contact.mesh.n_nodes
        parts = [getattr(tangent, name).scipy() for tangent in self.tangents]
        return sp.vstack((parts[0], parts[1][first:]))

    def blocks(self):
        """Rows of one kind and unit: forces, normal conditions, stick and slip conditions."""
        first = 2 * self.contact.mesh.n_nodes
        nodes = np.arange(2 * self.contact.mesh.n_nonmortar).reshape(-1, 2)
        status = self.conditions.status
        yield "forces", np.arange(first)
        yield "normal", first + nodes[self.conditions.active].ravel()
        for kind in (Status.STICK, Status.SLIP):
            yield kind.name, first + nodes.size + nodes[status == kind].ravel()


def slope(function, at, direction, h=1e-6):
    return (function(at + h * direction) - function(at - h * direction)) / (2 * h)


def assert_slopes(scene, exact, difference):
    """Compare block by block, as their units differ and hide small errors."""
    for name, rows in scene.blocks():
        scale = abs(exact[rows]).max(initial=0.0)
        error = abs(exact[rows] - difference[rows]).max(initial=0.0)
        assert error <= SMALL * scale, name


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", CASES)
def test_by_position(chains, name, seed):
    """With D, M, g, n, τ, facet lengths, cover and positions all alive."""
    scene = Scene(chains, name, seed)
    rng = np.random.default_rng(seed)
    for _ in range(3):
        v = rng.normal(size=scene.x.shape)
        difference = slope(lambda x: scene.rows(x, scene.multiplier), scene.x, v)
        assert_slopes(scene, scene.matrix("by_position") @ v.ravel(), difference)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("name", CASES)
def test_by_multiplier(chains, name, seed):
    """Linear, hence exact to round-off; multipliers of open nodes are no variables."""
    scene = Scene(chains, name, seed)
    v = np.random.default_rng(seed).normal(size=scene.multiplier.shape)
    difference = slope(lambda m: scene.rows(scene.x, m), scene.multiplier, v)
    assert_slopes(scene, scene.matrix("by_multiplier") @ v.ravel(), difference)


@pytest.mark.parametrize("name", CASES)
def test_D_by_position(chains, name):
    """Of the active nodes, where the elimination divides by it."""
    scene = Scene(chains, name, 0)
    v = np.random.default_rng(0).normal(size=scene.x.shape)
    difference = slope(lambda x: scene.contact.operators(x).D, scene.x, v)
    exact = scene.tangents[0].D_by_position.scipy() @ v.ravel()
    active = scene.conditions.active
    np.testing.assert_allclose(
        exact[active], difference[active], rtol=0, atol=SMALL * abs(exact).max()
    )


def test_states_are_rich(chains):
    """The scenes above hold what they are meant to test."""
    statuses, edges, held = set(), set(), False
    for name in CASES:
        for seed in range(4):
            c = Scene(chains, name, seed).conditions
            tangents = line_tangents(c.operators.normals.n)
            sense = np.einsum("ji,ji->j", c.active_set.direction, tangents).round()
            statuses |= {(int(s), int(d)) for s, d in zip(c.status, sense, strict=True)}
            edges |= {int(s) for s in c.status[c.edge.nodes] if s > 0}
            nonmortar = c.operators.M[:, : len(sense)].tocoo()
            held |= bool(c.active[nonmortar.row].any())
    assert statuses == {(-1, 0), (0, 0), (1, 0), (2, 1), (2, -1)}
    assert edges == {int(Status.STICK), int(Status.SLIP)}
    assert held


def test_rows_of_inactive_nodes_are_empty(chains):
    scene = Scene(chains, "held", 1)
    idle = np.flatnonzero(~scene.conditions.active)
    assert len(idle)
    rows = 2 * scene.contact.mesh.n_nodes + np.concatenate((2 * idle, 2 * idle + 1))
    for tangent in scene.tangents:
        for matrix in (tangent.by_position, tangent.by_multiplier):
            assert abs(matrix.scipy()[rows]).sum() == 0


@pytest.mark.mpi
@pytest.mark.quick
@pytest.mark.parametrize("name", CASES)
def test_parts_of_the_ranks_add_up(chains, name):
    """By position they are shares, by multiplier every rank has the whole."""
    comm = MPI.COMM_WORLD
    pair = [Scene(chains, name, 2, c).tangents for c in (MPI.COMM_SELF, comm)]
    for alone, shared in zip(*pair, strict=True):
        for part in ("by_position", "D_by_position"):
            total = comm.allreduce(getattr(shared, part).scipy().toarray())
            expected = getattr(alone, part).scipy().toarray()
            np.testing.assert_allclose(total, expected, rtol=0, atol=1e-12 * abs(expected).max())
        difference = abs(shared.by_multiplier.scipy() - alone.by_multiplier.scipy()).max()
        assert difference <= 1e-14
