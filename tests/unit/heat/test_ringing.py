"""What counts as ringing, on single modes and on a bar with a stepped wall temperature."""

import numpy as np
import pytest

from contactfem.heat.ringing import Increment, Zigzag, local_ringing, ringing
from contactfem.heat.time_schemes import NAMES, scheme

CONTINUOUS = [name for name in NAMES if name.startswith("c")]


def stages_of(of, theta, H, load, dt, steps):
    """March M θ' + H θ = load(t), M = 1, and return the start and all stages (n, modes)."""
    s, modes = len(of.nodes), len(theta)
    system = np.kron(of.rate, np.eye(modes)) + dt * np.kron(of.test @ of.trial, H)
    history = [theta]
    for n in range(steps):
        loads = np.array([load(n * dt + alpha * dt) for alpha in of.points])
        start = -np.outer(of.rate_start, theta) - dt * np.outer(of.test @ of.trial_start, H @ theta)
        right = start + dt * of.test @ loads
        stages = np.linalg.solve(system, right.ravel()).reshape(s, modes)
        history += list(stages)
        theta = of.end @ stages
    return np.array(history)


def verdicts(of, history):
    """What is said after every stage, as the end of a step."""
    changes = np.diff(history, axis=0)
    inner = [0.0, *np.sum(changes[1:] * changes[:-1], axis=1)]
    norms = np.linalg.norm(changes, axis=1)
    increments = [Increment(*pair) for pair in zip(norms, inner, strict=True)]
    s = len(of.nodes)
    return [ringing(of, increments[:n], norms[:n].max()) for n in range(s, len(norms) + 1, s)]


def decay(of, z, steps=10):
    """Decay of one mode with λ dt = z."""
    return stages_of(of, np.ones(1), np.array([[z]]), lambda t: np.zeros(1), 1.0, steps)


@pytest.mark.parametrize("name", CONTINUOUS)
def test_stiff_decay_rings_and_is_reported_after_three_steps(name):
    of = scheme(name)
    found = verdicts(of, decay(of, 1e7))
    assert found[:2] == [None, None]
    assert all(found[2:])
    assert found[-1].left == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("name", CONTINUOUS)
@pytest.mark.parametrize("z", [1e-3, 0.5, 2.0, 6.0])
def test_moderate_and_slow_decay_do_not_ring(name, z):
    of = scheme(name)
    assert not any(verdicts(of, decay(of, z)))


def test_the_bound_is_what_is_left_after_a_step():
    """cG(1) leaves (z - 2)/(z + 2) of a fast mode: 0.7 at z = 11.33."""
    of = scheme("cG(1)")
    assert not any(verdicts(of, decay(of, 11.0)))
    found = verdicts(of, decay(of, 12.0))
    assert found[-1].left == pytest.approx(10.0 / 14.0)


@pytest.mark.parametrize("name", [name for name in NAMES if name not in CONTINUOUS])
def test_l_stable_schemes_do_not_ring(name):
    of = scheme(name)
    assert not any(verdicts(of, decay(of, 1e7)))


@pytest.mark.parametrize("z", [0.1, 1.0, 100.0])
@pytest.mark.parametrize("period", [6.0, 7.3, 40.0])
def test_an_oscillating_load_is_no_ringing(period, z):
    """From the state that belongs to the load, so that nothing fast is set free."""
    of = scheme("cG(1)")
    omega = 2.0 * np.pi / period

    def load(t):
        return np.array([z * np.sin(omega * t) + omega * np.cos(omega * t)])

    history = stages_of(of, np.zeros(1), np.array([[z]]), load, 1.0, 60)
    assert np.ptp(history) > 1.0
    assert not any(verdicts(of, history))


def bar(cells, conductance):
    """Conduction matrix of a bar with lumped storage 1 per node, wall at one end held at 1."""
    H = 2.0 * np.eye(cells) - np.eye(cells, k=1) - np.eye(cells, k=-1)
    H[-1, -1] = 1.0
    return conductance * H, conductance * np.eye(cells)[0]


def test_a_bar_with_hardly_any_heat_capacity():
    """The wall temperature is stepped: cG(1) rings for ever, dG(1) is at the steady profile."""
    H, wall = bar(10, 1e10)
    continuous, discontinuous = scheme("cG(1)"), scheme("dG(1)")
    ringing_bar = stages_of(continuous, np.zeros(10), H, lambda t: wall, 1.0, 20)
    assert all(verdicts(continuous, ringing_bar)[2:])
    assert abs(ringing_bar[-1] - 1.0).max() > 0.9
    damped = stages_of(discontinuous, np.zeros(10), H, lambda t: wall, 1.0, 20)
    np.testing.assert_allclose(damped[-1], 1.0, atol=1e-6)
    assert not any(verdicts(discontinuous, damped))


def test_a_bar_that_warms_up_in_many_steps():
    H, wall = bar(10, 0.5)
    of = scheme("cG(1)")
    assert not any(verdicts(of, stages_of(of, np.zeros(10), H, lambda t: wall, 1.0, 50)))


def test_round_off_at_the_steady_state_is_no_ringing():
    of = scheme("cG(1)")
    noise = 1e-9 * (-1.0) ** np.arange(8)[:, None]
    history = np.vstack([[[0.0]], 1.0 + noise])
    assert not any(verdicts(of, history))
    assert any(verdicts(of, history[1:]))  # the same, but all that ever happened


def test_message_names_the_scheme_and_the_way_out():
    of = scheme("cG(1)")
    message = str(verdicts(of, decay(of, 1e7))[-1])
    assert "rings" in message
    assert "100 %" in message
    assert "cG(1)" in message
    assert "dG(1)" in message


def zigzag(values, dt=1.0):
    """Zigzag of one temperature over time."""
    rates = np.diff(values)[:, None] / dt
    found = Zigzag.begun(rates[0])
    for rate in rates[1:]:
        found = found.followed(rate)
    return found


def test_amplitude_of_what_rings_on_a_slope() -> None:
    """±0.3 on a line that rises by 5 in a step: the norm of the increments does not see it."""
    n = np.arange(8)
    for dt in (1.0, 0.1):
        found = zigzag(5.0 * n + 0.3 * (-1.0) ** n, dt)
        assert found.amplitude(dt) == pytest.approx(0.3, rel=1e-12)


@pytest.mark.parametrize(
    "values",
    [np.exp(-0.5 * np.arange(9)), np.sin(0.7 * np.arange(12)), (-0.3) ** np.arange(9)],
    ids=["decay", "slow oscillation", "gone by itself"],
)
def test_no_amplitude_of_what_does_not_ring(values) -> None:
    assert zigzag(values).amplitude(1.0) == 0.0


def test_local_ringing_is_said_above_a_share_of_the_range() -> None:
    assert "0.2 K" in local_ringing(scheme("cG(1)"), 0.2, 100.0)
    assert local_ringing(scheme("cG(1)"), 0.05, 100.0) == ""
    assert local_ringing(scheme("dG(1)"), 0.2, 100.0) == ""
    assert local_ringing(scheme("cG(1)"), 1e-14, 1e-13) == ""
