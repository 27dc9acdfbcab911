"""Step control: what follows a failed and an accepted step."""

import math

from hypothesis import assume, given
from hypothesis import strategies as st

from contactfem.adaptivity.decisions import GiveUp, RepeatStep
from contactfem.run.step_control import (
    EASY_ITERATIONS,
    StepLimits,
    after_failure,
    after_success,
    clipped,
)

LIMITS = StepLimits(end=1.0, smallest=1 / 1024, largest=0.25, max_cutbacks=8)
STEP = st.floats(1e-3, 0.25)


@given(dt=STEP, cutbacks=st.integers(0, 20))
def test_failure_halves_or_gives_up(dt, cutbacks):
    """Never below the smallest step, never more often than allowed."""
    decision = after_failure(dt, cutbacks, LIMITS)
    if isinstance(decision, RepeatStep):
        assert decision.dt == dt / 2
        assert decision.dt >= LIMITS.smallest * (1 - 1e-9)
        assert cutbacks < LIMITS.max_cutbacks
    else:
        assert cutbacks >= LIMITS.max_cutbacks or dt / 2 < LIMITS.smallest


def test_failures_end():
    """A step that always fails is given up with the key that limits it."""
    dt, cutbacks = 0.25, 0
    while isinstance(decision := after_failure(dt, cutbacks, LIMITS), RepeatStep):
        dt, cutbacks = decision.dt, cutbacks + 1
    assert (dt, cutbacks) == (0.25 / 2**8, 8)
    assert isinstance(decision, GiveUp)
    assert "solver.max_cutbacks" in decision.reason
    decision = after_failure(LIMITS.smallest, 0, LIMITS)
    assert isinstance(decision, GiveUp)
    assert "time.step_min" in decision.reason
    assert after_failure(2 * LIMITS.smallest, 0, LIMITS) == RepeatStep(LIMITS.smallest)


@given(dt=STEP, iterations=st.lists(st.integers(0, 30), max_size=6))
def test_success_doubles_at_most(dt, iterations):
    """Only after two easy solves in a row, and never beyond the largest step."""
    following = after_success(dt, iterations, LIMITS)
    easy = len(iterations) >= 2 and max(iterations[-2:]) <= EASY_ITERATIONS
    assert following == min(2 * dt if easy else dt, LIMITS.largest)


@given(t=st.floats(0, 10), dt=STEP, stops=st.lists(st.floats(0, 10), max_size=5))
def test_steps_end_at_stops(t, dt, stops):
    """A step never passes a stop, is never longer than wanted, and never of no length."""
    stops = sorted(stops)
    step = clipped(t, dt, stops)
    assert 0 < step <= dt * (1 + 1e-9)
    ahead = [stop for stop in stops if stop > t + 1e-9 * dt]
    if ahead:
        assert t + step <= ahead[0] + 1e-12 * (1 + t)
        short = [abs(t + n * step - ahead[0]) <= 1e-12 * (1 + t) for n in (1, 2)]
        assert step == dt or short[0] or (short[1] and step >= 0.499 * dt)


@given(dt=STEP, end=st.floats(0.3, 5))
def test_a_run_reaches_its_end(dt, end):
    """Repeated steps arrive at the end in as few as possible, none shorter than half of them."""
    t, n = 0.0, 0
    assume(end / dt < 500)
    while t < end * (1 - 1e-12):
        step = clipped(t, dt, [end])
        assert step >= 0.499 * dt
        t, n = t + step, n + 1
    assert n <= math.ceil(end / dt * (1 + 1e-9))
    assert abs(t - end) <= 1e-12 * end
