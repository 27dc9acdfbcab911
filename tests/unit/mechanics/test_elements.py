"""The MINI element: the same solid as P1, no locking near incompressibility, contact unchanged."""

from pathlib import Path

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh

from mpi4py import MPI

from contactfem.case.element_choice import element_of
from contactfem.case.materials import Material
from contactfem.case.read import read_case
from contactfem.case.scene import Body
from contactfem.check.check import check_case
from contactfem.common.time_table import Table, constant
from contactfem.common.timers import Timers
from contactfem.errors import CaseError
from contactfem.fem.body_mesh import distribute
from contactfem.fem.dof_numbering import Prescribed
from contactfem.forms.energies import (
    linear_elastic,
    linear_elastic_mixed,
    neo_hooke,
    neo_hooke_mixed,
)
from contactfem.mechanics.body import BodyProblem, Law
from contactfem.mechanics.bulk_system import System
from contactfem.meshes.block import Block
from contactfem.meshes.box import Box
from contactfem.results.expectations import judge
from contactfem.results.measures import measure
from contactfem.run.driver import run_case
from contactfem.solvers.newton import NewtonSolver, SolveReport, StepInput

COMM = MPI.COMM_WORLD
CASES = Path(__file__).parents[3] / "cases"
MU = 1e6


def block(n: int, pattern: str = "right", width: float = 1.0):
    """Unit-high block of triangles."""
    builder = Block(
        width=width, height=1.0, nx=int(width * n), ny=n, cell="triangle", pattern=pattern
    )
    return distribute(COMM, builder.build() if COMM.rank == 0 else None)


def body(domain, ratio: float, *, mixed: bool, small: bool = False) -> BodyProblem:
    """A body of a bulk modulus that is `ratio` times its shear modulus."""
    K = ratio * MU
    parameters = {"bulk_modulus": K, "shear_modulus": MU, "expansion": 0.0}
    energy, with_mean = (
        (linear_elastic, linear_elastic_mixed) if small else (neo_hooke, neo_hooke_mixed)
    )
    law = Law(
        energy, parameters, 9 * K * MU / (3 * K + MU), small, small, with_mean if mixed else None
    )
    return BodyProblem("body", domain, law, constant(0.0), [])


def solve(
    problem: BodyProblem, prescribed: list[Prescribed], steps: int
) -> tuple[NewtonSolver, list[SolveReport]]:
    """Equal steps to t = 1 s."""
    system = System(COMM, [problem], prescribed, [])
    solver = NewtonSolver(system, [], 1e-10, 30, {}, Timers())
    times = np.linspace(0, 1, steps + 1)[1:]
    reports = [solver.solve(StepInput(float(t), 1.0, (), (), known=False)) for t in times]
    assert all(report.converged for report in reports), reports
    return solver, reports


def pressed(n: int, ratio: float, *, mixed: bool) -> tuple[float, SolveReport]:
    """Force [N/m] on a glued 2 x 1 block that is pressed by a tenth, and how its last step went."""
    domain = block(n, width=2.0)
    bottom, top = domain.surface("bottom").vertices, domain.surface("top").vertices
    held = [Prescribed(0, v, c, constant(0.0)) for v in (bottom, top) for c in (0, 1)]
    held[3] = Prescribed(0, top, 1, Table((0.0, 1.0), (0.0, -0.1)))
    solver, reports = solve(body(domain, ratio, mixed=mixed), held, 10)
    return -solver.reactions()[3], reports[-1]


@pytest.mark.parametrize(
    ("energy", "mixed", "mean"),
    [
        (neo_hooke, neo_hooke_mixed, lambda F: np.log(np.linalg.det(F)) - 3 * 1e-3 * 40),
        (linear_elastic, linear_elastic_mixed, lambda F: np.trace(F) - 3 - 3 * 1e-3 * 40),
    ],
)
def test_the_mixed_energy_is_stationary_at_the_energy(energy, mixed, mean):
    """ψ(F, p) has its stationary value in p, which is ψ(F), at p = K ln J_e or K (tr ε - 3αϑ)."""
    rng = np.random.default_rng(3)
    F = np.eye(3) + 0.2 * rng.normal(size=(3, 3))
    K, mu = 2e9, 3e6
    numbers = {"bulk_modulus": K, "shear_modulus": mu, "expansion": 1e-3}
    domain = mesh.create_unit_interval(MPI.COMM_SELF, 1)
    tensor = fem.Constant(domain, F)
    p, theta = fem.Constant(domain, 0.0), fem.Constant(domain, 40.0)
    parameters = {name: fem.Constant(domain, value) for name, value in numbers.items()}
    whole = fem.form(energy(tensor, theta, parameters) * ufl.dx(domain))
    split = fem.form(mixed(tensor, p, theta, parameters) * ufl.dx(domain))
    expected = fem.assemble_scalar(whole)
    p.value = K * mean(F)
    assert fem.assemble_scalar(split) == pytest.approx(expected, rel=1e-13)
    for change in (-1e7, 1e7):  # a parabola in p: the curvature is -1/K
        p.value = K * mean(F) + change
        assert fem.assemble_scalar(split) - expected == pytest.approx(
            -(change**2) / (2 * K), rel=1e-6
        )


def test_force_converges_for_every_ratio_where_p1_locks():
    """Glued block pressed by a tenth, force in kN/m at n = 4, 8, 16 cells over the height.

    | K/mu | MINI             | P1                    |
    |------|------------------|-----------------------|
    | 10   | 1438, 1358, 1322 | 1535, 1404, 1345      |
    | 1e2  | 2272, 2014, 1910 | 4784, 2855, 2237      |
    | 1e3  | 2444, 2135, 2016 | 30228, 10040, 4345    |
    | 1e4  | 2463, 2149, 2028 | 278260, 76917, 21817  |
    """
    forces = {}
    for ratio in (10.0, 1e2, 1e3, 1e4):
        coarse, middle = (pressed(n, ratio, mixed=True)[0] for n in (4, 8))
        forces[ratio] = middle
        assert 1.0 < coarse / middle < 1.16
    assert forces[1e4] / forces[1e3] == pytest.approx(1.0062, abs=2e-4)  # it has a limit
    assert pressed(8, 1e4, mixed=False)[0] > 30 * forces[1e4]
    assert pressed(8, 10.0, mixed=False)[0] == pytest.approx(forces[10.0], rel=0.04)


def test_newton_converges_quadratically():
    _, report = pressed(8, 1e4, mixed=True)
    before, after = report.residuals[-3:-1]
    assert report.iterations <= 4
    assert after < 10 * before**2


@pytest.mark.mpi
def test_the_order_is_one_in_the_gradient_and_two_in_the_displacement():
    """Airy's φ = y⁵ - 5x²y³ at K/mu = 1e4: stress-free at y = 0, prescribed on the other sides."""
    errors = [_airy_errors(n) for n in (8, 16, 32)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders[-1] > (1.9, 0.95, 1.4)), orders


def _airy_errors(n: int) -> tuple[float, float, float]:
    """Relative errors of u in L2, Grad u in L2 and the mean stress at the midpoints."""
    ratio = 1e4
    nu = (3 * ratio - 2) / (6 * ratio + 2)
    domain = block(n)
    problem = body(domain, ratio, mixed=True, small=True)

    def exact(x, y):
        u = 20 * x * y**3 - 10 * x**3 * y - nu * (10 * x * y**3 - 10 * x**3 * y)
        v = -2.5 * y**4 - nu * (2.5 * y**4 - 15 * x**2 * y**2) + 2.5 * (1 - nu) * x**4
        return u * 1e-3, v * 1e-3

    held = []
    for side in ("left", "top", "right"):
        surface = domain.surface(side)
        for vertex, X in zip(surface.vertices, surface.X, strict=True):
            value = exact(*X)
            held += [Prescribed(0, np.array([vertex]), c, constant(value[c])) for c in (0, 1)]
    solve(problem, held, 1)
    x = ufl.SpatialCoordinate(domain.mesh)
    u = ufl.as_vector(exact(x[0], x[1]))
    error = problem._element.displacement - u
    dx = ufl.Measure("dx", domain.mesh, metadata={"quadrature_degree": 8})
    e_u, s_u, e_g, s_g = (
        COMM.allreduce(fem.assemble_scalar(fem.form(ufl.inner(e, e) * dx)))
        for e in (error, u, ufl.grad(error), ufl.grad(u))
    )
    owned = domain.mesh.topology.index_map(2).size_local
    middle = mesh.compute_midpoints(domain.mesh, 2, np.arange(owned, dtype=np.int32))
    X, Y = middle[:, 0], middle[:, 1]
    mean = 2 * MU * 1e-3 * (1 + nu) / 3 * (10 * Y**3 - 30 * X**2 * Y)
    found = problem.cell_stress()[:owned, :3].mean(1)
    e_p, s_p = COMM.allreduce(np.array([np.sum((found - mean) ** 2), np.sum(mean**2)]))
    return (e_u / s_u) ** 0.5, (e_g / s_g) ** 0.5, (e_p / s_p) ** 0.5


@pytest.mark.parametrize("variant", [None, "confined_hot", "free_sides", "mesh_5_3"])
def test_contact_passes_a_uniform_pressure_exactly(variant):
    sides = ("lower", "upper")
    overrides = [f"bodies.{side}.mesh.cell=triangle" for side in sides]
    overrides += ["bodies.lower.element=MINI"]  # on P1: elements may differ
    case = read_case(CASES / "patch.toml", overrides, variant)
    verdicts = judge(case, measure(run_case(case, MPI.COMM_SELF, None)))
    assert verdicts
    assert all(verdict.passed for verdict in verdicts), verdicts


def test_tetrahedra():
    """A box pressed between rough plates, K/mu = 1e3: P1 is 22 times as stiff on this mesh."""
    force = {}
    for mixed in (True, False):
        data = Box(width=1.0, height=1.0, depth=1.0, nx=2, ny=2, nz=2, cell="tetrahedron").build()
        domain = distribute(MPI.COMM_SELF, data)
        bottom, top = domain.surface("bottom").vertices, domain.surface("top").vertices
        held = [Prescribed(0, v, c, constant(0.0)) for v in (bottom, top) for c in (0, 1, 2)]
        held[4] = Prescribed(0, top, 1, constant(-0.02))
        solver, _ = solve(body(domain, 1e3, mixed=mixed), held, 1)
        force[mixed] = -solver.reactions()[4]
    assert force[False] > 20 * force[True]


@pytest.mark.parametrize(
    ("element", "poisson_ratio", "cell", "expected"),
    [
        ("auto", 0.499, "triangle", "MINI"),
        ("auto", 0.499, "tetrahedron", "MINI"),
        ("auto", 0.499, "quadrilateral", "P1"),
        ("auto", 0.476, "triangle", "MINI"),  # K/mu = 20.5
        ("auto", 0.474, "triangle", "P1"),  # K/mu = 18.9
        ("P1", 0.499, "triangle", "P1"),
        ("MINI", 0.3, "triangle", "MINI"),
    ],
)
def test_choice(element, poisson_ratio, cell, expected):
    mesh = {"builder": "block", "width": 1.0, "height": 1.0, "nx": 1, "ny": 1}
    chosen = Body(material="m", mesh=mesh, element=element)
    material = Material(youngs_modulus=1e6, poisson_ratio=poisson_ratio)
    assert element_of(chosen, material, cell) == expected


def test_check_says_which_element_and_warns_of_locking():
    case = CASES / "pressed_block.toml"
    assert "MINI triangles, K/mu = 1e+04" in check_case(read_case(case))
    assert 'use element = "MINI"' in check_case(read_case(case, ["bodies.block.element=P1"]))
    with pytest.raises(CaseError, match="needs triangles or tetrahedra; the mesh has quad"):
        read_case(case, ["bodies.block.mesh.cell=quadrilateral", "bodies.block.element=MINI"])
