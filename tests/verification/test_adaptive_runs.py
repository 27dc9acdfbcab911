"""Runs whose meshes and steps follow from the errors asked for: what stays, and what goes on."""

from unittest.mock import patch

import numpy as np
import pytest
from verification.watched import vertex_temperatures, watch

from mpi4py import MPI

from contactfem.adaptivity import adaptation as adapt
from contactfem.adaptivity import remesh
from contactfem.adaptivity.decisions import RepeatStep
from contactfem.case.read import read_case
from contactfem.run import driver as run
from contactfem.run import time_loop as loop
from contactfem.solvers.newton import NewtonSolver, SolveReport

SOLID = """
[materials.solid]
youngs_modulus = "100 MPa"
poisson_ratio = 0.3
density = "1000 kg/m^3"
heat_capacity = "100 J/kg/K"
conductivity = "0.05 W/m/K"
"""
PRESSED = (
    """
title = "A block on a plane, held by a grip and at a point"
strain = "small"
time = { end = "1 s", step = "0.5 s" }
adaptivity = { tolerance = "8 %" }
[bodies.block]
material = "solid"
mesh = { builder = "block", width = "2 mm", height = "1 mm", nx = 8, ny = 4 }
[obstacles.floor]
shape = "circle"
center = ["1 mm", "-3 mm"]
radius = "3 mm"
[interfaces.sole]
nonmortar = "block.bottom"
mortar = "floor"
[[conditions]]
on = "block.top"
grip = { displacement.x = "0 mm", force.y = "-5 N/mm" }
[[conditions]]
on = "block"
at = ["0.5 mm", "0.75 mm"]
displacement.x = "0.001 mm"
[probes.inside]
on = "block"
at = ["1.61 mm", "0.37 mm"]
value = "displacement.y"
"""
    + SOLID
)
RUBBED = (
    """
title = "Two blocks, one of them hot and pressed on the other"
strain = "finite"
time = { end = "0.3 s", step = "0.1 s", step_max = "0.2 s" }
adaptivity = { mechanics = "12 %", heat = "12 %", time = "60 %", size_min = "0.02 mm" }
[heat]
[bodies.upper]
material = "solid"
initial_temperature = "20 K"
mesh = { builder = "block", width = "1 mm", height = "1 mm", corner = ["0.5 mm", "0 mm"], \
nx = 5, ny = 5 }
[bodies.lower]
material = "solid"
mesh = { builder = "block", width = "2 mm", height = "1 mm", corner = ["0 mm", "-1 mm"], \
nx = 8, ny = 4 }
[interfaces.seam]
nonmortar = "upper.bottom"
mortar = "lower.top"
friction = { coefficient = 0.3 }
heat = { law = "constant", conductance = "500 W/m^2/K" }
[[conditions]]
on = "lower.bottom"
displacement = ["0 mm", "0 mm"]
[[conditions]]
on = "upper.top"
displacement.y = [["0 s", "0 mm"], ["0.1 s", "-0.02 mm"]]
displacement.x = [["0.1 s", "0 mm"], ["0.3 s", "0.1 mm"]]
"""
    + SOLID
)
SWITCHED = """
title = "A source that changes its sign at once"
mechanics = false
time = { end = "1 s", step = "0.1 s", step_min = "1e-4 s", step_max = "0.1 s" }
adaptivity = { time = "10 %" }
[heat]
[materials.solid]
youngs_modulus = "1 Pa"
poisson_ratio = 0.0
density = "1 kg/m^3"
heat_capacity = "2 J/kg/K"
conductivity = "0.2 W/m/K"
[bodies.plate]
material = "solid"
initial_temperature = "switch.py:theta"
mesh = { builder = "block", width = "1 m", height = "1 m", nx = 6, ny = 6 }
[[conditions]]
on = "plate"
heat_source = "switch.py:source"
[[conditions]]
on = "plate.left"
temperature = "0 K"
"""
FUNCTIONS = """
from contactfem.verification.manufactured import SuddenSwitch
found = SuddenSwitch(conductivity=0.2, heat_capacity=2.0)
theta, source = found.theta, found.source
"""


def case_of(folder, text, *overrides):
    (folder / "case.toml").write_text(text)
    return read_case(folder / "case.toml", overrides)


def test_points_stay_and_a_probe_is_a_node(tmp_path):
    result = run.run_case(case_of(tmp_path, PRESSED), MPI.COMM_SELF, None)
    assert result.converged
    first, *_ = [step.errors for step in result.steps]
    assert len(first.remeshes) >= 1
    assert first.mechanics < 0.08
    assert first.change.forces["sole"][1] == pytest.approx(0.0, abs=1e-4)  # it is prescribed
    assert 0.0 < abs(first.change.forces["sole"][0]) < 0.05 * 2.5e3
    assert first.change.temperature_max is None
    (block,) = result.bodies
    for point, axis, value in (((0.5e-3, 0.75e-3), 0, 1e-6), ((1.61e-3, 0.37e-3), 1, None)):
        distance = np.hypot(*(block.points - point).T)
        assert distance.min() < 1e-12
        found = block.displacement[np.argmin(distance), axis]
        assert found == pytest.approx(result.probes["inside"] if value is None else value)
    top = block.points[:, 1] == 1e-3
    assert np.ptp(block.displacement[top, 1]) < 1e-12
    assert result.steps[-1].forces["sole"][1] == pytest.approx(-5e3, rel=1e-8)


def test_only_named_bodies_get_new_meshes(tmp_path):
    case = case_of(tmp_path, RUBBED, 'adaptivity.bodies=["upper"]', "adaptivity.heat=0.025")
    result = run.run_case(case, MPI.COMM_SELF, None)
    assert result.converged
    remeshes = [new for step in result.steps for new in step.errors.remeshes]
    assert {new.body for new in remeshes} == {"upper"}
    assert {new.problem for new in remeshes} == {"mechanics", "heat"}
    last = result.steps[-1].errors
    assert (last.cells["lower"], last.thermal_cells["lower"]) == (32, 32)
    assert last.cells["upper"] > 25 < last.thermal_cells["upper"]


def test_the_problem_without_new_meshes_keeps_what_it_has(tmp_path):
    """Heat gets new meshes; of mechanics there is one system and one solver, and no change."""
    solvers, carried = set(), []
    solve, carry = NewtonSolver.solve, remesh.carried

    def seen(self, step):
        solvers.add(id(self))
        return solve(self, step)

    def spy(old, new, state, ramp_end):
        x = state.x.copy()
        after = carry(old, new, state, ramp_end)
        carried.append(state.t)
        assert new.system is old.system
        assert new.heat.bodies != old.heat.bodies
        assert np.array_equal(x, after.x)
        assert np.array_equal(x, new.system.x.array)
        assert state.conditions == after.conditions
        return after

    case = case_of(
        tmp_path, RUBBED, "adaptivity.mechanics=0.9", "time.step='0.02 s'", "time.step_max='0.05 s'"
    )
    with patch.object(NewtonSolver, "solve", seen), patch.object(remesh, "carried", spy):
        result = run.run_case(case, MPI.COMM_SELF, None)
    assert result.converged
    assert len(solvers) == 1
    assert max(carried) > 0.0
    changes = [s.errors.change for s in result.steps if s.errors.remeshes]
    for change in changes:
        assert max(map(abs, change.forces["seam"])) < 0.02 * 1e5
        assert abs(change.temperature_mean) < 0.02


def test_a_step_that_fails_on_new_meshes_starts_again(tmp_path):
    """From the state that was carried over, with half the step."""
    solve, starts = NewtonSolver.solve, []

    def fail_once(self, step):
        if step.t > 0.5:  # on meshes that were made for the first step
            starts.append([body.u.x.array.copy() for body in self.system.bodies])
        report = solve(self, step)
        if len(starts) != 1:
            return report
        self.system.x.array[:] *= 3.0  # a state that must not stay
        self.system.spread(self.system.x)
        return SolveReport(False, "planned", report.iterations, report.residuals)

    with patch.object(NewtonSolver, "solve", fail_once):
        # with factors that serve on, the first thing to try again would be without them
        case = case_of(tmp_path, PRESSED, "solver.reuse=false")
        result = run.run_case(case, MPI.COMM_SELF, None)
    assert result.converged
    first, second, *_ = result.steps
    assert first.errors.remeshes
    assert (first.cutbacks, second.cutbacks) == (0, 1)
    assert second.dt == pytest.approx(0.5 * first.dt)
    for failed, again in zip(*starts[:2], strict=True):
        assert np.abs(failed).max() > 0
        assert np.array_equal(failed, again)


def test_repeated_steps_leave_no_trace(tmp_path):
    """Taken from the start with the steps that were accepted, a run gives the same: to 1e-9."""
    (tmp_path / "switch.py").write_text(FUNCTIONS)
    back, fields = set(), ([], [])
    decide = adapt.decide_step

    def spy(report, policy):
        decision = decide(report, policy)
        if isinstance(decision, RepeatStep):
            back.add(decision.back)
        return decision

    with patch.object(adapt, "decide_step", spy):
        first = watch(
            case_of(tmp_path, SWITCHED),
            lambda _, state, d: fields[0].append(vertex_temperatures(d, state)[0][1]),
        )
    assert back == {1, 2}
    steps = iter([step.dt for step in first.steps])
    with patch.object(loop, "clipped", lambda *_: next(steps)):
        second = watch(
            case_of(tmp_path, SWITCHED, "adaptivity=false"),
            lambda _, state, d: fields[1].append(vertex_temperatures(d, state)[0][1]),
        )
    assert [step.t for step in first.steps] == [step.t for step in second.steps]
    assert len(first.steps) > 20
    for a, b in zip(*fields, strict=True):
        assert np.abs(a - b).max() < 1e-9 * np.abs(a).max()


def test_steps_before_a_kink_are_as_long_as_without_it(tmp_path):
    """Data that change their slope at a given time say nothing of the steps before."""
    source = '[[conditions]]\non = "plate"\nheat_source = "switch.py:source"\n'
    text = SWITCHED.replace(source, "").replace('"switch.py:theta"', '"0 K"')
    steps = []
    for end in ("50 K", "100 K"):  # held from 0.5 s on, or rising as before
        table = f'[["0 s", "0 K"], ["0.5 s", "50 K"], ["1 s", "{end}"]]'
        kinked = text.replace('temperature = "0 K"', f"temperature = {table}")
        result = run.run_case(case_of(tmp_path, kinked), MPI.COMM_SELF, None)
        steps.append([step.t for step in result.steps if step.t < 0.5 * (1.0 + 1e-9)])
        assert 0.5 in [pytest.approx(step.t) for step in result.steps]
    assert steps[0] == steps[1]
    assert 5 < len(steps[0]) < 60


@pytest.mark.mpi
def test_ranks_agree(tmp_path):
    """The same meshes and decisions; values to 1e-8.

    Sizes of cells are rounded to 1e-6, so states are solved for far below that.
    """
    comm = MPI.COMM_WORLD
    folder = comm.bcast(tmp_path)
    if comm.rank == 0:
        case_of(folder, RUBBED)
    comm.barrier()
    case = read_case(folder / "case.toml", ["solver.tolerance=1e-13"])
    alone, together = (run.run_case(case, c, None) for c in (MPI.COMM_SELF, comm))
    assert alone.converged and together.converged
    assert any(step.errors.remeshes for step in alone.steps)
    assert len(alone.steps) == len(together.steps)
    for a, b in zip(alone.steps, together.steps, strict=True):
        assert a.dt == pytest.approx(b.dt, rel=1e-8)
        assert (a.errors.cells, a.errors.thermal_cells) == (b.errors.cells, b.errors.thermal_cells)
        assert a.errors.decisions == b.errors.decisions
        for name in ("mechanics", "heat", "time"):
            x, y = getattr(a.errors, name), getattr(b.errors, name)
            assert (x is None) == (y is None)
            assert x is None or x == pytest.approx(y, rel=1e-8)
        assert np.allclose(a.forces["seam"], b.forces["seam"], rtol=1e-8, atol=1e-5)
        assert a.heat.temperature_max == pytest.approx(b.heat.temperature_max, rel=1e-8)
