"""Coupled steps: fields between meshes, passes and their relaxation, and what a failure leaves."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.checkpoint.checkpointer import Checkpointer
from contactfem.checkpoint.format import Origin
from contactfem.common.timers import Timers
from contactfem.discretisation.discretise import discretise
from contactfem.fem.body_mesh import distribute, dofs_at_vertices
from contactfem.forms.energies import neo_hooke, neo_hooke_mixed
from contactfem.heat.body import HeatBody, HeatLaw
from contactfem.mechanics.body import BodyProblem, Law
from contactfem.meshes.block import Block
from contactfem.meshes.disk import Disk
from contactfem.output.recorder import Recorder
from contactfem.run.driver import run_case
from contactfem.run.loop_parts import newton_solver
from contactfem.run.time_loop import Loop
from contactfem.thermomechanics.body_transfer import BodyLink
from contactfem.thermomechanics.staggered import _Relaxation
from contactfem.thermomechanics.thermal_problem import Thermal

ROOT = Path(__file__).resolve().parents[3]
SELF, WORLD = MPI.COMM_SELF, MPI.COMM_WORLD
LAW = Law(
    neo_hooke,
    {"bulk_modulus": 333.0, "shear_modulus": 35.0, "expansion": 1e-4},
    101.0,
    False,
    False,
)


def block(n, cell="quadrilateral"):
    return Block(width=2.0, height=1.0, nx=n, ny=n, cell=cell)


def spread(builder):
    return distribute(WORLD, builder.build() if WORLD.rank == 0 else None)


def linear(x):
    return 50.0 + 3.0 * x[0] - 5.0 * x[1]


def moved(x):
    return np.array([0.1 * x[0] + 0.2 * x[1], 0.3 - 0.4 * x[1]])


DISKS = [Disk(radius=1.0, facets=n, layers=n // 8) for n in (16, 128)]


@pytest.mark.mpi
@pytest.mark.quick
@pytest.mark.parametrize(
    ("mechanical", "thermal"),
    [
        (block(3), block(24)),
        (block(24, "triangle"), block(3)),
        (block(3), block(3, "triangle")),
        DISKS,
        DISKS[::-1],
    ],
)
@pytest.mark.parametrize("mixed", [False, True])
def test_linear_fields_go_both_ways(mechanical, thermal, mixed):
    """Displacement to the thermal mesh, temperature back, 8 times finer or coarser (28)-(31)."""
    meshes = spread(mechanical), spread(thermal)
    if mixed and meshes[0].mesh.basix_cell().name != "triangle":
        pytest.skip("MINI is an element of triangles")
    law = replace(LAW, mixed=neo_hooke_mixed) if mixed else LAW
    body = BodyProblem("block", meshes[0], law, None, ())
    heat = HeatBody("block", meshes[1], HeatLaw(0.2, 2.0), ())
    link = BodyLink(WORLD, body, heat)
    _displace(body)
    link.set_displacement()
    points = heat.displacement_space.tabulate_dof_coordinates().T
    np.testing.assert_allclose(heat.u.x.array.reshape(-1, 2), moved(points).T, rtol=0, atol=1e-12)
    points = heat.V.tabulate_dof_coordinates().T
    link.set_temperature(linear(points))
    space = body.temperature.function_space
    expected = linear(space.tabulate_dof_coordinates().T)
    np.testing.assert_allclose(body.temperature.x.array, expected, rtol=1e-12)


def _displace(body):
    """Write a linear displacement at the vertices of a body."""
    vertices = dofs_at_vertices(body.mesh.mesh, body.vertex_space)[1]
    points = WORLD.bcast(None if body.mesh.data is None else body.mesh.data.points)
    body.u.x.array[body.vertex_dofs] = moved(points[vertices].T).T


def test_one_mesh_is_shared():
    """A body without a thermal mesh gets its mechanical one, and nothing is interpolated."""
    mesh = spread(block(4))
    body = BodyProblem("block", mesh, LAW, None, ())
    heat = HeatBody("block", mesh, HeatLaw(0.2, 2.0), ())
    link = BodyLink(WORLD, body, heat)
    values = np.random.default_rng(1).standard_normal(heat.n_dofs)
    link.set_temperature(values)
    np.testing.assert_array_equal(np.sort(link.mechanical_temperature), np.sort(values))
    assert "_to_heat" not in vars(link)


def relaxation(setting, n=3):
    thermal = SimpleNamespace(
        bodies=[SimpleNamespace(n_owned=n)], system=SimpleNamespace(comm=SELF)
    )
    return _Relaxation(setting, thermal)


def test_aitken_is_exact_for_one_mode():
    """x → a x + b with a = -0.8: after two changes the third guess is the fixed point."""
    x, scheme, a = np.array([1.0, 2.0, 3.0]), relaxation("aitken"), -0.8
    fixed = np.array([5.0, -1.0, 2.0])
    for _ in range(2):
        difference = [fixed + a * (x - fixed) - x]
        x = x + scheme.factor(difference) * difference[0]
    np.testing.assert_allclose(x, fixed, rtol=1e-12)
    assert relaxation(0.3).factor([x]) == 0.3


@pytest.mark.parametrize("setting", ["aitken", "0.5", "1.0"])
def test_relaxation_does_not_change_the_answer(setting):
    """Every factor goes to the same fixed point, Aitken's in the fewest passes."""
    found = {}
    for value in ("aitken", setting):
        overrides = [f"heat.relaxation={value}", "heat.max_passes=100", "heat.tolerance=1e-11"]
        result = run_case(
            read_case(ROOT / "cases/gap_closure.toml", overrides, "gap_40"), SELF, None
        )
        assert result.converged
        found[value] = result.interfaces[0].pressure.mean(), result.steps[-1].heat.passes
    (exact, best), (p, passes) = found["aitken"], found[setting]
    assert p == pytest.approx(exact, rel=1e-9)
    assert best <= passes


def test_too_few_passes():
    """A step that does not settle fails, and says which limit it met."""
    overrides = ["heat.max_passes=2", "heat.tolerance=1e-12", "solver.max_cutbacks=0"]
    result = run_case(read_case(ROOT / "cases/gap_closure.toml", overrides), SELF, None)
    assert not result.converged
    assert "after 2 passes (heat.max_passes)" in result.message


def started():
    """A run of the sliding block on different meshes after two steps."""
    small = [
        "bodies.base.mesh.nx=20",
        "bodies.base.mesh.ny=2",
        "bodies.block.mesh.nx=5",
        "bodies.block.mesh.ny=3",
        'time.end="0.5 ms"',
    ]
    case = read_case(ROOT / "cases/sliding_block.toml", small, "meshes")
    timers = Timers()
    discretisation = discretise(case, SELF, timers)
    solver = newton_solver(case, discretisation, timers)
    recorder = Recorder(case, SELF, None, discretisation, timers, "", None)
    keeper = Checkpointer(case, SELF, None, Origin("", case.contents, ""), timers, 0.0, bool)
    loop = Loop(case, discretisation, solver, recorder, keeper, timers, None)
    assert loop.run() == ""
    return loop


def arrays(loop):
    """Everything that an attempt may change."""
    d = loop.discretisation
    own = [d.system.x.array, *(body.u.x.array for body in d.system.bodies)]
    heat = [a for b in d.heat.bodies for a in (b.u.x.array, b.theta.x.array)]
    return [
        np.array(a) for a in (*own, *heat, *(link.mechanical_temperature for link in d.heat.links))
    ]


@pytest.mark.parametrize("phase", ["mechanics", "heat"])
def test_a_failure_of_either_phase_leaves_the_last_good_state(monkeypatch, phase):
    """The attempt moves the bodies; after it all is as before, and the step goes as if new."""
    loop = started()
    before, t = arrays(loop), loop.state.t + 0.1e-3
    expected, outcome = loop._attempt(t)
    assert expected.converged
    after = arrays(loop)
    theta = [values.copy() for values in outcome.solution.theta]
    loop.state.restore(loop.discretisation)
    with monkeypatch.context() as patch:
        if phase == "mechanics":
            solve = loop.solver.solve
            patch.setattr(
                loop.solver,
                "solve",
                lambda step: replace(solve(step), converged=False, reason="made up"),
            )
        else:
            thermal = loop.heat.driver._thermal
            heat = thermal.solve

            def fails(*given):
                solution, exchanges = heat(*given)
                return replace(solution, reason="made up"), exchanges

            patch.setattr(thermal, "solve", fails)
        failed, nothing = loop._attempt(t)
    assert not failed.converged
    assert failed.reason == "made up"
    assert nothing is None
    assert any(not np.array_equal(a, b) for a, b in zip(before, arrays(loop), strict=True))
    loop.state.restore(loop.discretisation)
    for a, b in zip(before, arrays(loop), strict=True):
        np.testing.assert_array_equal(a, b)
    again, outcome = loop._attempt(t)
    assert again.converged
    for a, b in zip(after, arrays(loop), strict=True):
        np.testing.assert_allclose(b, a, rtol=0, atol=1e-10 * np.abs(a).max(initial=1e-300))
    for a, b in zip(theta, outcome.solution.theta, strict=True):
        np.testing.assert_allclose(b, a, rtol=0, atol=1e-10 * np.abs(a).max())


def test_a_failed_heat_solve_cuts_the_step(monkeypatch):
    """The run goes on with half the step, and its balance of heat still closes."""
    case = read_case(ROOT / "cases/sliding_block.toml", ['time.end="1 ms"'], "meshes")
    solve, calls = Thermal.solve, []

    def sometimes(self, *given):
        solution, exchanges = solve(self, *given)
        calls.append(given[3])
        return replace(solution, reason="made up" if len(calls) == 3 else ""), exchanges

    monkeypatch.setattr(Thermal, "solve", sometimes)
    result = run_case(case, SELF, None)
    assert result.converged
    assert sum(step.cutbacks for step in result.steps) == 1
    for step in result.steps:
        assert step.heat.stored == pytest.approx(step.dissipation, rel=1e-10)


CIRCLE = """
title = "Narrow contact over a coarse thermal surface"
time = { end = "4 s", step = "1 s" }
heat = { scheme = "cG(1)" }
[materials.solid]
youngs_modulus = "100 MPa"
poisson_ratio = 0.3
density = "1000 kg/m^3"
heat_capacity = "2000 J/kg/K"
conductivity = "0.2 W/m/K"
[bodies.block]
material = "solid"
mesh = { builder = "block", width = "6 mm", height = "2 mm", nx = 60, ny = 8 }
thermal_mesh = { builder = "block", width = "6 mm", height = "2 mm", nx = 3, ny = 2 }
[obstacles.roll]
shape = "circle"
center = ["3 mm", "5 mm"]
radius = "3 mm"
displacement.y = [["0 s", "0 mm"], ["1 s", "-0.02 mm"]]
displacement.x = [["1 s", "0 mm"], ["4 s", "0.3 mm"]]
[interfaces.contact]
nonmortar = "block.top"
mortar = "roll"
search_radius = "1 mm"
friction = { law = "coulomb", coefficient = 0.2 }
heat = { law = "insulated", partition = 0.3 }
[[conditions]]
on = "block.bottom"
displacement = ["0 mm", "0 mm"]
"""


def test_friction_between_thermal_nodes(tmp_path):
    """What no thermal node sees still enters, near where it is rubbed, and the defect is told."""
    path = tmp_path / "circle.toml"
    path.write_text(CIRCLE)
    result = run_case(read_case(path), SELF, None)
    assert result.converged, result.message
    table = result.interfaces[0]
    touching = table.X[table.status > 0, 0]
    assert 2e-3 < touching.min() < touching.max() < 4e-3
    rubbed = [step for step in result.steps if step.dissipation > 0.0]
    assert rubbed
    for step in rubbed:
        assert step.heat.friction == pytest.approx(0.3 * step.dissipation, rel=1e-10)
        assert step.heat.stored == pytest.approx(0.3 * step.dissipation, rel=1e-10)
    picture = result.heat[0]
    top = np.isclose(picture.points[:, 1], 2e-3)
    x, theta = picture.points[top, 0], picture.fields["temperature"][top, 0]
    assert theta[(x > 1e-3) & (x < 5e-3)].min() > 5 * np.abs(theta[(x < 1e-3) | (x > 5e-3)]).max()


PROBE = """
import sys
from mpi4py import MPI
from contactfem.case.read import read_case
from contactfem.run.driver import run_case
assert run_case(read_case("{case}", variant={variant!r}), MPI.COMM_SELF, None).converged
parts = ("heat.body", "heat.system", "heat.interface", "thermomechanics", "transfer")
heat = (*("contactfem." + part for part in parts), "contactfem.discretisation.heat")
print(*[name for name in sys.modules if name.startswith(heat)])
"""


@pytest.mark.parametrize(("stem", "variant"), [("block", "coarse"), ("two_bars", None)])
def test_heat_is_imported_only_where_it_is_solved_for(stem, variant):
    """A case without [heat] loads none of its modules."""
    script = PROBE.format(case=ROOT / f"cases/{stem}.toml", variant=variant)
    found = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=100
    ).stdout
    names = set(found.split())
    assert (not names) == (stem == "block"), names
