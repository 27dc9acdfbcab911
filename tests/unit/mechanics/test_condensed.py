"""The condensed system: its tangent against differences, its solution against Newton's promise."""

import numpy as np
import pytest
import scipy.sparse as sp

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.common.timers import Timers
from contactfem.contact.slip import tangential
from contactfem.contact.state import ContactHistory
from contactfem.discretisation.discretise import discretise
from contactfem.laws.active_set import ActiveSet, Status
from contactfem.mechanics.condensed import Condensed, row_scales
from contactfem.mortar.normals import nodal_normals
from contactfem.solvers.newton import NewtonSolver, StepInput

# The upper block overhangs the held side of the lower one and ends within a facet of it.
CASE = """
title = "two blocks"
strain = "finite"
time = { end = "1 s", step = "1 s" }
[materials.soft]
youngs_modulus = "1 Pa"
poisson_ratio = 0.3
[materials.stiff]
youngs_modulus = "7 Pa"
poisson_ratio = 0.2
[bodies.lower]
material = "soft"
mesh = { builder = "block", width = "2 m", height = "1 m", nx = 9, ny = 3, cell = "triangle" }
[bodies.upper]
material = "stiff"
mesh.builder = "block"
mesh.width = "1.5 m"
mesh.height = "1 m"
mesh.corner = ["-0.1 m", "1 m"]
mesh.nx = 5
mesh.ny = 3
[interfaces.joint]
nonmortar = "lower.top"
mortar = "upper.bottom"
friction = { law = "coulomb", coefficient = 0.3 }
[[conditions]]
on = "lower.bottom"
displacement = ["0 m", "0 m"]
[[conditions]]
on = "lower.left"
displacement = ["0 m", "0 m"]
[[conditions]]
on = "upper.top"
displacement = ["0.01 m", "-0.03 m"]
"""
PUSH = 'displacement = ["0.01 m", "-0.03 m"]'
PAIR = 'nonmortar = "lower.top"\nmortar = "upper.bottom"'
LEFT = 'on = "lower.left"\ndisplacement = ["0 m", "0 m"]'
FLOOR = """
[obstacles.floor]
shape = "plane"
point = ["0 m", "0.95 m"]
normal = [0.02, -1.0]
"""
VARIANTS = {  # what is replaced in the case by what
    "finite strain": ("", ""),
    "small strain": ('"finite"', '"small"'),
    "frictionless": ('friction = { law = "coulomb", coefficient = 0.3 }', ""),
    "symmetry line": (LEFT, 'on = "lower.left"\ndisplacement.x = "0 m"'),
    "sides swapped": (PAIR, 'nonmortar = "upper.bottom"\nmortar = "lower.top"'),
    "sliding": (PUSH, 'displacement = ["0.02 m", "-0.03 m"]'),
    "grip": (PUSH, 'grip = { displacement = { y = "-0.03 m" }, force = { x = "0.002 N/m" } }'),
    "obstacle": (PAIR + "\n", 'nonmortar = "lower.top"\nmortar = "floor"\n'),
}


class Problem:
    """A case that is ready to be evaluated anywhere."""

    def __init__(self, folder, name):
        path = folder / "case.toml"
        path.write_text(CASE.replace(*VARIANTS[name]) + (FLOOR if name == "obstacle" else ""))
        found = discretise(read_case(path), MPI.COMM_SELF, Timers())
        self.system, self.interfaces = found.system, found.interfaces
        self.histories = []
        for interface in self.interfaces:
            operators = interface.contact.operators(interface.nodes.positions(0.0, 1.0))
            self.histories.append(ContactHistory.at(operators))
        self.system.advance(1.0, 1.0)
        self.condensed = Condensed(self.system, self.interfaces, Timers())

    def evaluate(self, values):
        """Find the condensed residual and the conditions at some unknowns."""
        self.system.x.array[:] = values
        self.system.spread(self.system.x)
        bulk, out = self.system.x.duplicate(), self.system.x.duplicate()
        self.system.residual(bulk, [None] * len(self.system.bodies))
        positions = [i.nodes.positions(1.0, 1.0) for i in self.interfaces]
        nothing = [None] * len(positions)
        conditions = self.condensed.evaluate(positions, self.histories, nothing, bulk, out)
        return out.array.copy(), conditions

    def random(self, seed):
        """Draw unknowns at which nodes of every status occur: pressed together, and shaken."""
        rng = np.random.default_rng(seed)
        values = 0.015 * rng.normal(size=self.system.x.local_size)
        nodes = self.interfaces[0].nodes
        n = nodes.mesh.n_nonmortar
        inward = -np.sign(nodal_normals(nodes.mesh, nodes.X).n[0, 1])
        for side, distance in ((slice(0, n), 0.025), (slice(n, None), 0.05)):
            movable = nodes.unknown[side, 1][nodes.unknown[side, 1] >= 0]
            values[movable] += distance * inward
        return values

    def replaced(self, conditions):
        """Nodes and unknowns whose rows are conditions."""
        nodes = self.interfaces[0].nodes
        n = nodes.mesh.n_nonmortar
        rows = conditions.active[:, None] & nodes.mesh.free[:n] & (nodes.unknown[:n] >= 0)
        return np.nonzero(rows), nodes.unknown[:n][rows]

    def solve(self):
        """Solve the step from all nodes sticking, as a body may have no other hold at first."""
        starts = []
        for interface in self.interfaces:
            n = interface.nodes.mesh.n_nonmortar
            starts.append(ActiveSet(np.full(n, Status.STICK, np.int8), np.zeros((n, 2))))
        solver = NewtonSolver(self.system, self.interfaces, 1e-13, 30, {}, Timers())
        step = StepInput(1.0, 1.0, tuple(self.histories), tuple(starts), known=False)
        return solver, solver.solve(step)


def frozen(problem, base, values):
    """Find the residual with normals and scales of the rows of another state.

    They are weights of the conditions, which the tangent leaves alone: at the solution the
    conditions vanish, and away from it Newton's step does not depend on them.
    """
    out, (c,) = problem.evaluate(values)
    assert not c.active_set.differs_from(base.active_set).any()
    scales = row_scales(problem.interfaces[0], base)
    normals = base.operators.normals.n
    rows = (scales.normal * c.residuals.normal)[:, None] * normals
    rows += scales.tangential[:, None] * tangential(c.residuals.tangential, normals)
    places, unknowns = problem.replaced(base)
    out[unknowns] = rows[places]
    return out


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("name", VARIANTS)
def test_tangent_against_differences(tmp_path, name, seed):
    """Bulk, forces moved to the mortar side and conditions with λ = -R / D, all at once."""
    problem = Problem(tmp_path, name)
    rng = np.random.default_rng(seed)
    values = problem.random(seed)
    residual, conditions = problem.evaluate(values)
    base = conditions[0]
    assert base.active.sum() >= 3
    np.testing.assert_allclose(frozen(problem, base, values), residual, rtol=0, atol=1e-15)
    matrix = problem.condensed.linearise(conditions, [None] * len(problem.system.bodies))
    indptr, indices, data = matrix.getValuesCSR()
    tangent = sp.csr_matrix((data, indices, indptr))
    is_condition = np.zeros(len(values), bool)
    is_condition[problem.replaced(base)[1]] = True
    for _ in range(3):
        v, h = rng.normal(size=len(values)), 1e-7
        ends = [frozen(problem, base, values + step * v) for step in (-h, h)]
        difference = (ends[1] - ends[0]) / (2 * h)
        exact = tangent @ v
        for rows in (is_condition, ~is_condition):
            error = abs(exact - difference)[rows].max()
            assert error <= 1e-6 * abs(exact[rows]).max()


def test_scenes_are_rich(tmp_path):
    """Open, sticking and slipping nodes, a rim and a held node in contact occur in them."""
    problem = Problem(tmp_path, "finite strain")
    statuses, edges, held = set(), 0, 0
    for seed in range(2):
        _, (c,) = problem.evaluate(problem.random(seed))
        statuses |= set(c.status.tolist())
        edges += int(c.active[c.edge.nodes].sum())
        n = len(c.status)
        held += int((abs(c.operators.M[:, :n]).sum(1)[c.active] > 0).sum())
    assert statuses == {Status.NONE, Status.OPEN, Status.STICK, Status.SLIP}
    assert edges
    assert held


@pytest.mark.parametrize("name", VARIANTS)
def test_convergence_is_quadratic(tmp_path, name):
    """Once the status stands r' <= C r² with C = 100: a linear rate of 1e-4 would not pass."""
    solver, report = Problem(tmp_path, name).solve()
    assert report.converged, report.reason
    sets = [c.active_set for (c,) in solver.history]
    pairs = list(zip(report.residuals, report.residuals[1:], sets, sets[1:], strict=False))
    stands = [
        (r, following)
        for r, following, a, b in pairs
        if not a.differs_from(b).any() and 1e-7 < r < 2e-2
    ]
    assert stands
    for r, following in stands:
        assert following <= 100 * r**2 + 1e-13
    if name == "sliding":
        assert {Status.STICK, Status.SLIP} <= set(solver.conditions[0].status.tolist())
