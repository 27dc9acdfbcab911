"""Steps of the heat problem: stages against a dense reference, when matrices are kept, balances."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp

from mpi4py import MPI

from contactfem.common.time_table import Table, constant
from contactfem.common.timers import Timers
from contactfem.fem.body_mesh import distribute
from contactfem.heat.body import HeatBody, HeatLaw, HeatLoad
from contactfem.heat.stage_matrix import _blocked
from contactfem.heat.system import HeatStepInput, HeatSystem, PrescribedTemperature
from contactfem.heat.time_schemes import NAMES, scheme
from contactfem.meshes.block import Block

COMM = MPI.COMM_SELF
K, CAPACITY, DT = 0.2, 2.0, 0.3
LEFT = Table((0.0, 1.0), (0.0, 10.0))


def system(name, *, held=True, comm=COMM, n=4, options=None, loads=None):
    """A block of 1 m with its left side led, a flux into its right one and a source."""
    builder = Block(width=1.0, height=1.0, nx=n, ny=2)
    mesh = distribute(comm, builder.build() if comm.rank == 0 else None)
    given = [HeatLoad("right", Table((0.0, 1.0), (0.0, 4.0))), HeatLoad(None, constant(3.0))]
    heat = HeatBody("block", mesh, HeatLaw(K, CAPACITY), given if loads is None else loads)
    prescribed = [PrescribedTemperature(0, mesh.surface("left").vertices, LEFT)] if held else []
    return HeatSystem(comm, [heat], prescribed, scheme(name), options or {}, Timers())


def start(problem):
    """A rough field that fits the prescribed one."""
    heat = problem.bodies[0]
    x = heat.V.tabulate_dof_coordinates().T
    theta = [np.sin(3.0 * x[0]) * (1.0 + x[1])]
    problem.set_held(0.0, theta)
    return theta


def step(problem, theta, dt=DT, t=0.0):
    u = [heat.u.x.array.copy() for heat in problem.bodies]
    return problem.solve(HeatStepInput(t, dt, theta, u, []))


def dense(problem):
    """Storage and conduction matrix of the only body over its local dofs."""
    heat = problem.bodies[0]
    unit = np.eye(heat.n_dofs)
    return [np.column_stack([act(e) for e in unit]) for act in (heat.stored, heat.conducted)]


@pytest.mark.parametrize("name", NAMES)
def test_against_a_dense_reference(name):
    """All stages of a step from the equations of the scheme, built without the solver's matrix."""
    problem = system(name)
    theta, s = start(problem), scheme(name)
    M, H = dense(problem)
    n, stages = len(M), len(s.nodes)
    weight, begin = s.test @ s.trial, s.test @ s.trial_start
    storage = 0.0 if s.steady else 1.0
    A = storage * np.kron(s.rate, M) + DT * np.kron(weight, H)
    b = np.zeros((stages, n))
    heat = problem.bodies[0]
    for k in range(stages):
        b[k] = -(storage * s.rate_start[k] * M + DT * begin[k] * H) @ theta[0]
        b[k] += DT * sum(
            w * heat.supplied(a * DT) for w, a in zip(s.test[k], s.points, strict=True)
        )
    held = heat.dofs(heat.mesh.surface("left").vertices)
    for k, alpha in enumerate(s.nodes):
        rows = k * n + held
        A[rows] = 0.0
        A[rows, rows] = 1.0
        b[k, held] = LEFT(alpha * DT)
    expected = scipy.linalg.solve(A, b.ravel()).reshape(stages, n)
    found = step(problem, theta)
    assert found.reason == ""
    for values, stage in zip(expected, found.stages, strict=True):
        np.testing.assert_allclose(stage[0], values, rtol=0, atol=1e-10 * np.abs(values).max())
    np.testing.assert_allclose(found.theta[0], s.end @ expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", ["cG(1)", "cG(2)", "dG(0)", "dG(1)"])
def test_balance(name):
    """Stored = held + loads, and each of them by itself."""
    problem = system(name)
    theta = start(problem)
    found = step(problem, theta)
    balance = found.balance
    grown = problem.bodies[0].stored(found.theta[0] - theta[0]).sum()
    assert balance.stored == pytest.approx(grown, rel=1e-12)
    weights, points = scheme(name).test[-1], scheme(name).points
    loads = DT * (3.0 + 4.0 * DT * float(weights @ points))
    assert balance.loads == pytest.approx(loads, rel=1e-12)
    assert abs(balance.defect) < 1e-12 * abs(balance.stored)
    assert balance.friction == balance.obstacles == balance.strained == 0.0


def test_the_factorisation_is_kept_while_nothing_changes(monkeypatch):
    """The same step again needs no new matrix; another length or displacement does."""
    problem = system("cG(2)")
    theta = start(problem)
    made = []
    blocks = problem._matrix._blocks
    monkeypatch.setattr(
        problem._matrix, "_blocks", lambda *given: made.append(given[0]) or blocks(*given)
    )
    first = step(problem, theta)
    again = step(problem, theta)
    assert made == [DT]
    np.testing.assert_array_equal(first.theta[0], again.theta[0])
    step(problem, theta, 0.1)
    assert made == [DT, 0.1]
    problem.bodies[0].u.interpolate(lambda x: 0.1 * x[:2])
    moved = step(problem, theta, 0.1)
    assert made == [DT, 0.1, 0.1]
    fresh = system("cG(2)")
    fresh.bodies[0].u.x.array[:] = problem.bodies[0].u.x.array
    expected = step(fresh, theta, 0.1)
    np.testing.assert_allclose(moved.theta[0], expected.theta[0], rtol=0, atol=1e-12)


def test_a_linear_solver_that_fails(monkeypatch):
    """The reason says so, the next step makes its matrix again, and is right."""
    weak = {"ksp_type": "cg", "pc_type": "none", "ksp_max_it": "1"}
    problem = system("cG(1)", options=weak)
    found = step(problem, start(problem))
    assert found.reason.startswith("heat: linear solver failed (PETSc error")
    ksp = problem._matrix._ksp
    ksp.setTolerances(rtol=1e-14, max_it=1000)
    theta = start(problem)
    expected = step(system("cG(1)"), theta)
    np.testing.assert_allclose(step(problem, theta).theta[0], expected.theta[0], atol=1e-8)


def test_nothing_holds_a_steady_temperature():
    """Without storage and a temperature to hold on to there is no solution, and it is said."""
    problem = system("steady", held=False)
    found = step(problem, start(problem))
    assert "heat:" in found.reason
    free = system("cG(1)", held=False)
    assert step(free, start(free)).reason == ""


@pytest.mark.mpi
@pytest.mark.quick
@pytest.mark.parametrize("name", ["cG(1)", "dG(1)", "cG(2)"])
def test_the_same_on_any_ranks(name):
    """Balance and range of temperatures of three steps."""
    found = []
    for comm in (MPI.COMM_SELF, MPI.COMM_WORLD):
        problem = system(name, comm=comm, n=9)
        theta = start(problem)
        for k in range(3):
            solution = step(problem, theta, t=k * DT)
            assert solution.reason == ""
            theta = solution.theta
        b = solution.balance
        ends = [comm.allreduce(getattr(theta[0], name)(), op)
                for name, op in (("max", MPI.MAX), ("min", MPI.MIN))]  # fmt: skip
        found.append([b.stored, b.loads, *b.held, *ends])
    np.testing.assert_allclose(found[1], found[0], rtol=1e-9)


@pytest.mark.parametrize("stages", [1, 2, 3])
def test_a_pattern_of_blocks(stages):
    """As Kronecker products make it, with the same entries in the same places."""
    pattern = sp.random(40, 60, 0.1, format="csr", random_state=1)
    pattern.sort_indices()
    pattern.data = np.arange(pattern.nnz) + 1.0
    starts, columns, entry, place = _blocked(pattern, stages)
    places = np.arange(stages**2, dtype=float).reshape(stages, stages) + 1.0
    whole = sp.kron(pattern.astype(bool), places, format="csr")
    assert np.array_equal(whole.indptr, starts)
    assert np.array_equal(whole.indices, columns)
    assert np.array_equal(whole.data - 1.0, place)
    whole = sp.kron(pattern, np.ones((stages, stages)), format="csr")
    assert np.array_equal(whole.data - 1.0, entry)
