"""Decisions about meshes and steps, case by case, and in loops that must settle."""

import math
from dataclasses import replace

import numpy as np
import pytest

from contactfem.adaptivity.decisions import Advance, RepeatStep
from contactfem.adaptivity.policies import (
    KeepMesh,
    MeshPolicy,
    MeshReport,
    Remesh,
    StepPolicy,
    TimedStep,
    TimeReport,
    decide_mesh,
    decide_step,
)
from contactfem.adaptivity.recovery.time import time_error
from contactfem.results.relative_error import error_ratio

MESH = MeshPolicy(tolerance=0.05)
FINE = MeshReport(
    eta=0.03, cells=1000, predicted_eta=0.04, predicted_cells=500, remeshes=0, steps_left=100
)
COARSE = replace(FINE, eta=0.08, predicted_eta=0.04, predicted_cells=3000)
STEP = StepPolicy(tolerance=0.05, smallest=0.01, largest=1.0)


def test_too_large_an_error_makes_a_new_mesh():
    decision = decide_mesh(COARSE, MESH)
    assert isinstance(decision, Remesh)
    assert decision.reason == "an error of 8 % exceeds 5 %: 1000 to about 3000 cells"


def test_new_meshes_of_one_step_are_counted():
    assert isinstance(decide_mesh(replace(COARSE, remeshes=2), MESH), Remesh)
    decision = decide_mesh(replace(COARSE, remeshes=3), MESH)
    assert decision == KeepMesh(
        False, "an error of 8 % exceeds 5 % after 3 new meshes in this step"
    )


def test_limits_that_allow_no_better_mesh_are_told():
    decision = decide_mesh(replace(COARSE, predicted_eta=0.0790), MESH)
    assert isinstance(decision, KeepMesh)
    assert not decision.within
    assert "the limits allow no mesh with less than 7.9 %" in decision.reason


def test_limits_that_bind_make_a_mesh_for_much_less_error_only():
    bound = replace(COARSE, eta=0.4, predicted_eta=0.37, limited=True)
    assert isinstance(decide_mesh(replace(bound, predicted_eta=0.36), MESH), Remesh)
    assert isinstance(decide_mesh(replace(bound, limited=False), MESH), Remesh)
    decision = decide_mesh(bound, MESH)
    assert decision == KeepMesh(
        False,
        "an error of 40 % exceeds 5 %, but the limits allow no mesh with less than 37 %",
    )
    assert isinstance(decide_mesh(replace(bound, eta=0.06, predicted_eta=0.049), MESH), Remesh)


def test_a_new_mesh_that_gained_nothing_is_not_followed_by_the_next_one():
    """Not before that could have paid; and where the tolerance is in reach, at once."""
    idle = replace(COARSE, eta=0.4, predicted_eta=0.1, gained=0.04, age=5, limited=True)
    decision = decide_mesh(idle, MESH)
    assert isinstance(decision, KeepMesh)
    assert not decision.within
    assert "the last new mesh gained nothing" in decision.reason
    assert isinstance(decide_mesh(replace(idle, age=6), MESH), Remesh)
    for gained in (0.06, -0.06):
        assert isinstance(decide_mesh(replace(idle, gained=gained), MESH), Remesh)
    assert isinstance(decide_mesh(replace(idle, predicted_eta=0.05), MESH), Remesh)


def test_a_coarser_mesh_has_to_pay():
    """It saves half of each step; it has to gain twice the three steps that it costs."""
    assert isinstance(decide_mesh(replace(FINE, steps_left=13), MESH), Remesh)
    assert isinstance(decide_mesh(replace(FINE, steps_left=12), MESH), KeepMesh)
    assert isinstance(decide_mesh(replace(FINE, life=13), MESH), Remesh)
    decision = decide_mesh(replace(FINE, life=5), MESH)
    assert decision == KeepMesh(
        True, "1000 to about 500 cells would save 2.5 steps of work, a new mesh costs 3"
    )


def test_a_mesh_that_is_right_is_kept():
    assert decide_mesh(replace(FINE, predicted_cells=1100), MESH).within
    assert decide_mesh(replace(FINE, predicted_eta=0.06), MESH).within
    assert isinstance(decide_mesh(replace(FINE, remeshes=1), MESH), KeepMesh)


def test_meshes_settle():
    """e² ~ 1/n with an estimate that is off by 10 %, up or down: no mesh is made for nothing."""
    rng = np.random.default_rng(0)
    cells, life, made = 200.0, math.inf, 0
    for step in range(100):
        for remeshes in range(4):
            eta = 0.05 * math.sqrt(1000 / cells) * rng.uniform(0.95, 1.05)
            predicted = cells * (eta / (MESH.aim * MESH.tolerance)) ** 2
            report = MeshReport(
                eta, round(cells), MESH.aim * MESH.tolerance, predicted, remeshes, 100 - step, life
            )
            if isinstance(decide_mesh(report, MESH), KeepMesh):
                break
            cells, made = predicted * rng.uniform(0.9, 1.1), made + 1
    assert made <= 2
    assert 900 < cells < 2000


def after(eta, dt, repeats=0, older=None):
    """Decision after a step."""
    return decide_step(TimeReport(TimedStep(dt, eta), older, repeats), STEP)


def test_a_step_with_too_large_an_error_is_repeated():
    decision = after(0.1, 0.4)
    assert isinstance(decision, RepeatStep)
    assert decision.back == 1
    expected = 0.4 * 0.8 * error_ratio(0.05) / error_ratio(0.1)
    assert decision.dt == pytest.approx(expected, rel=1e-13)
    assert decision.reason == "an error of 10 % against 5 %: back by 1 and on with 0.159 s"


def test_a_step_that_turns_out_wrong_is_repeated_with_the_next_one():
    decision = after(0.03, 0.1, older=TimedStep(0.2, 0.08))
    assert isinstance(decision, RepeatStep)
    assert decision.back == 2
    assert decision.dt == pytest.approx(0.2 * 0.8 * error_ratio(0.05) / error_ratio(0.08))
    assert after(0.09, 0.1, older=TimedStep(0.2, 0.08)).back == 1
    assert isinstance(after(0.03, 0.1, older=TimedStep(0.2, 0.05)), Advance)


def test_where_the_older_step_is_the_smallest_the_newer_becomes_shorter():
    decision = after(0.08, 0.02, older=TimedStep(0.01, 0.1))
    assert isinstance(decision, RepeatStep)
    assert decision.back == 1
    decision = after(0.04, 0.02, older=TimedStep(0.01, 0.1))
    assert decision == Advance(
        0.02, within=False, reason="an error of 10 % against 5 % with the smallest step"
    )


@pytest.mark.parametrize("eta", [0.99, 1.0])
def test_steps_are_cut_by_a_limited_factor(eta):
    assert after(eta, 0.4).dt == pytest.approx(0.08)
    assert after(eta, 0.02).dt == STEP.smallest


def test_what_cannot_be_repeated_is_told():
    expected = Advance(
        0.01, within=False, reason="an error of 20 % against 5 % with the smallest step"
    )
    assert after(0.2, 0.01) == expected
    decision = after(0.2, 0.4, repeats=4)
    assert decision == Advance(
        0.4, within=False, reason="an error of 20 % against 5 % after 4 repetitions"
    )


def test_steps_grow_when_the_error_allows():
    change = 0.8 * error_ratio(0.05) / error_ratio(0.03)
    assert after(0.03, 0.1).dt == pytest.approx(0.1 * change, rel=1e-13)
    assert after(0.001, 0.1).dt == pytest.approx(0.2)
    assert after(0.0, 0.1).dt == pytest.approx(0.2)
    assert after(0.001, 0.8).dt == 1.0
    assert after(0.001, 0.1, repeats=1).dt == 0.1


def test_steps_hold_where_the_error_is_as_wanted_and_shrink_before_it_is_too_large():
    for eta in (0.035, 0.0399):
        assert after(eta, 0.1) == Advance(
            0.1,
            within=True,
            reason=f"an error of {100 * eta:.3g} % against 5 %: the next step is 0.1 s",
        )
    change = 0.8 * error_ratio(0.05) / error_ratio(0.048)
    assert isinstance(after(0.048, 0.1), Advance)
    assert after(0.048, 0.1).dt == pytest.approx(0.1 * change, rel=1e-13)
    assert after(0.048, 0.01).dt == STEP.smallest
    assert after(0.001, 0.1, older=TimedStep(0.1, 0.04)).dt == pytest.approx(0.1, rel=2e-3)


def test_steps_follow_a_front_and_recover():
    """z = tanh((t - 0.5)/0.02): a fifth of the step at most at the front, and few repetitions."""
    policy = StepPolicy(tolerance=0.1, smallest=1e-5, largest=0.1)
    mean_square = 4.0 / 3.0 / 0.02  # of the rate over (0, 1)

    def z(t):
        return math.tanh((t - 0.5) / 0.02)

    def step(t, dt):
        return t, dt, (z(t + dt) - z(t)) / dt

    def etas(older, newer):
        change = (newer[2] - older[2]) ** 2
        pairs = ((newer, older), (older, newer))
        return [time_error(change, a[2] ** 2, b[1], a[1], mean_square).eta for a, b in pairs]

    dt, repeats, repeated, taken = 0.02, 0, 0, [step(-0.02, 0.02)]
    while sum(taken[-1][:2]) < 1.0:
        older, newer = taken[-1], step(sum(taken[-1][:2]), dt)
        eta = etas(older, newer)
        before = TimedStep(older[1], eta[1]) if len(taken) > 1 else None
        decision = decide_step(TimeReport(TimedStep(dt, eta[0]), before, repeats), policy)
        dt = decision.dt
        if isinstance(decision, Advance):
            taken.append(newer)
            repeats = 0
            continue
        repeats, repeated = repeats + 1, repeated + decision.back
        taken = taken[: len(taken) + 1 - decision.back]
    times, lengths, rates = np.array(taken[1:]).T
    middles = times + lengths / 2
    at_front = lengths[np.abs(middles - 0.5) < 0.02].max()
    assert at_front < lengths[middles < 0.4].max() / 5
    assert at_front < lengths[middles > 0.6].max() / 5
    assert repeated < len(taken) / 2
    nodes, weights = np.polynomial.legendre.leggauss(8)
    t = middles[:, None] + lengths[:, None] / 2 * nodes
    off = (1.0 - np.tanh((t - 0.5) / 0.02) ** 2) / 0.02 - rates[:, None]
    assert np.sqrt((lengths[:, None] / 2 * weights * off**2).sum() / mean_square) < 0.1
