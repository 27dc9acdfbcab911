"""Trial states of unilateral contact with Coulomb friction, node by node."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from contactfem.common.time_table import Table
from contactfem.laws.active_set import ActiveSet, Status
from contactfem.laws.complementarity import (
    Regularisation,
    active_set,
    contact_scale,
    normal_condition,
    slip_condition,
    stick_condition,
    trial_multiplier,
)
from contactfem.laws.edge_stabilisation import EDGE_COMPLIANCE, EDGE_COVERAGE, edge_compliance
from contactfem.laws.friction import Coulomb, SlipState, Tresca, VariableCoulomb, frictionless

SCALE = st.floats(1e-3, 1e3)
SIGNED = st.floats(-1e3, 1e3)


def one(value):
    return np.array([float(value)])


def along(value, turn):
    """One vector of a size with a sign, along a direction in a plane or in space."""
    direction = np.array(turn) / np.linalg.norm(turn)
    return value * direction[None, :]


TURNS = [(1.0,), (0.6, -0.8), (2.0, -1.0, 2.0)]


def judge(p_trial, t, slip, mu=0.5, c=2.0, t_edge=0.0, kappa=0.0):
    """Status, and the sign of the slip along the line that all vectors are on, whatever that is."""
    found = set()
    for turn in TURNS:
        tied = [Regularisation(one(kappa), along(t_edge, turn))]
        t_trial = trial_multiplier(along(t, turn), along(slip, turn), one(c), tied)
        friction = mu > 0
        result = active_set(one(p_trial), t_trial, one(mu * max(p_trial, 0.0)), friction)
        sense = float(result.direction[0] @ along(1.0, turn)[0])
        np.testing.assert_allclose(result.direction, along(sense, turn), atol=1e-15)
        found.add((Status(result.status[0]), round(sense, 12)))
    assert len(found) == 1
    return found.pop()


def test_contact_scale():
    """Two springs in a row; a rigid obstacle adds nothing."""
    np.testing.assert_allclose(contact_scale(one(0.5), 10.0, 2.0, 40.0), [10.0])
    np.testing.assert_allclose(contact_scale(one(0.5), 10.0, 2.0, np.inf), [20.0])


@pytest.mark.parametrize(
    ("p_trial", "t", "slip", "expected"),
    [
        (-1.0, 0.0, 0.0, (Status.OPEN, 0)),
        (-1.0, 9.0, 9.0, (Status.OPEN, 0)),  # slip without pressure is no friction
        (0.0, 1.0, 0.0, (Status.OPEN, 0)),
        (1.0, 0.0, 0.0, (Status.STICK, 0)),
        (1.0, 0.49, 0.0, (Status.STICK, 0)),
        (1.0, 0.5, 0.0, (Status.STICK, 0)),
        (1.0, 0.51, 0.0, (Status.SLIP, 1)),
        (1.0, -0.49, 0.0, (Status.STICK, 0)),
        (1.0, -0.51, 0.0, (Status.SLIP, -1)),
        (1.0, 0.4, 0.06, (Status.SLIP, 1)),  # t + c s = 0.52
        (1.0, 0.4, 0.04, (Status.STICK, 0)),  # 0.48
        (1.0, 0.5, -0.1, (Status.STICK, 0)),  # slips back: 0.3
        (1.0, 0.5, -0.51, (Status.SLIP, -1)),  # slips back by a lot: -0.52
        (1.0, -0.5, -0.1, (Status.SLIP, -1)),
        (1.0, -0.5, 0.1, (Status.STICK, 0)),
    ],
)
def test_status_for_all_signs(p_trial, t, slip, expected):
    """Pressure decides over contact; traction and slip together over stick and direction."""
    assert judge(p_trial, t, slip) == expected


@pytest.mark.parametrize("t", [-3.0, 0.0, 3.0])
def test_without_friction_contact_slips_without_direction(t):
    assert judge(1.0, t, 0.7, mu=0.0) == (Status.SLIP, 0)
    assert judge(-1.0, t, 0.7, mu=0.0) == (Status.OPEN, 0)


@given(p=SIGNED, p_rim=SIGNED, gap=SIGNED, c=SCALE)
def test_trial_pressure_limits(p, p_rim, gap, c):
    """No rim rule: p - c g. A vanishing cover: the neighbour's pressure, with the gap over κ."""
    args = [one(v) for v in (p, -gap, c)]
    assert (
        trial_multiplier(*args, [])[0]
        == trial_multiplier(*args, [Regularisation(one(0.0), one(p_rim))])[0]
        == p - c * gap
    )
    large = 1e12
    size = abs(p) + abs(p_rim) + c * abs(gap) + 1.0
    found = trial_multiplier(*args, [Regularisation(one(large / c), one(p_rim))])[0]
    assert found == pytest.approx(p_rim, abs=1e-11 * size)


@given(p=SIGNED, p_rim=SIGNED, c=SCALE, kappa=SCALE)
def test_trial_pressure_where_the_condition_holds(p, p_rim, c, kappa):
    """At g + κ (p - p_k) = 0 the trial pressure is the pressure: the status is consistent."""
    gap = -kappa * (p - p_rim)
    found = trial_multiplier(one(p), one(-gap), one(c), [Regularisation(one(kappa), one(p_rim))])[0]
    assert found == pytest.approx(p, rel=1e-9, abs=1e-9 * (1 + abs(p_rim)) * (1 + c * kappa))


@given(SIGNED, st.floats(-10, 10), SCALE, st.floats(1e-3, 1e6))
def test_penalty_tells_the_same_status_as_its_law(p, gap, c, epsilon):
    """With a = 1/ε the pressure that makes the trial one the same is <-ε g>, at any c."""
    law = max(-epsilon * gap, 0.0)
    tie = [Regularisation(one(1 / epsilon), one(0.0))]
    found = trial_multiplier(one(law), one(-gap), one(c), tie)[0]
    if gap < 0:
        assert found == pytest.approx(law, rel=1e-9)
    else:
        assert found <= 0


@given(t=st.floats(-0.9, 0.9), t_rim=SIGNED, c=SCALE, kappa=SCALE, sign=st.sampled_from([-1, 1]))
def test_rim_rule_of_the_traction(t, t_rim, c, kappa, sign):
    """Where s = κ (t - t_k) the trial traction is t: inside the cone sticks, outside slips."""
    slip = kappa * (t - t_rim)
    assert judge(2.0, t, slip, 0.5, c, t_rim, kappa) == (Status.STICK, 0)
    far = sign * 1.1
    slip = kappa * (far - t_rim)
    assert judge(2.0, far, slip, 0.5, c, t_rim, kappa) == (Status.SLIP, sign)


@given(st.floats(-1e6, 1e6), SIGNED, SIGNED, st.floats(0, 2), SCALE)
def test_every_node_has_one_status(p_trial, t, slip, mu, c):
    """Direction is non-zero only in slip with friction, and then has the trial traction's sign."""
    t_trial = t + c * slip
    # on the bound itself the round-off of the turns decides
    assume(abs(abs(t_trial) - mu * max(p_trial, 0.0)) > 1e-9 * (abs(t) + c * abs(slip)))
    status, direction = judge(p_trial, t, slip, mu, c)
    assert (status == Status.OPEN) == (p_trial <= 0)
    if status == Status.SLIP and mu > 0:
        assert direction == np.sign(t_trial)
    else:
        assert direction == 0


def test_nodes_do_not_mix():
    """Arrays are judged entry by entry."""
    t = np.array([[0.0, 0], [0, 0], [2, 0], [-3, 4]])
    found = active_set(np.array([1.0, -1, 1, 1]), t, np.full(4, 0.5), has_friction=True)
    np.testing.assert_array_equal(found.status, [1, 0, 2, 2])
    np.testing.assert_allclose(found.direction, [[0, 0], [0, 0], [1, 0], [-0.6, 0.8]])
    assert found.status.dtype == np.int8


def test_rim_compliance_values():
    """κ = (0.1 / c) (1 / 2f - 1) below half a cover, continuous there, and none elsewhere."""
    coverage = np.array([0.0, 1e-12, 0.05, 0.25, EDGE_COVERAGE, 0.7, 1.0])
    kappa, slope = edge_compliance(coverage, np.full(7, 4.0))
    a = EDGE_COMPLIANCE / 4.0
    np.testing.assert_allclose(kappa, [0, a * (5e11 - 1), 9 * a, a, 0, 0, 0], rtol=1e-14)
    assert (slope[[0, 4, 5, 6]] == 0).all()
    just_below, _ = edge_compliance(one(EDGE_COVERAGE - 1e-9), one(4.0))
    assert 0 < just_below[0] < 1e-8 * a * 3
    assert EDGE_COMPLIANCE == 0.1


@given(coverage=st.floats(1e-6, 0.4999), c=SCALE)
def test_rim_compliance_slope(coverage, c):
    """dκ/df by central differences."""
    h = 1e-5 * coverage
    ends = [edge_compliance(one(f), one(c))[0][0] for f in (coverage - h, coverage + h)]
    slope = edge_compliance(one(coverage), one(c))[1][0]
    if coverage + h < EDGE_COVERAGE:
        assert slope == pytest.approx((ends[1] - ends[0]) / (2 * h), rel=1e-6)


def at(p, v=0.0, temperature=0.0):
    return SlipState(one(p), one(v), one(temperature))


TABLE = Table((1.0, 3.0), (0.5, 0.1))


def test_friction_laws():
    """Coulomb is proportional, Tresca a constant while there is contact, tables are linear."""
    assert Coulomb(0.3)(at(2.0)).value == pytest.approx(0.6)
    assert Tresca(7.0)(at(2.0)).value == 7.0
    assert Tresca(7.0)(at(0.0)).value == 0.0
    assert frictionless(at(2.0)).value == 0.0
    for y, mu in ((0.0, 0.5), (1.5, 0.4), (2.0, 0.3), (9.0, 0.1)):
        assert VariableCoulomb("speed", TABLE)(at(2.0, y)).value == pytest.approx(2 * mu)
        assert VariableCoulomb("temperature", TABLE)(at(2.0, 0, y)).value == pytest.approx(2 * mu)
        assert VariableCoulomb("pressure", TABLE)(at(y)).value == pytest.approx(y * mu)


LAWS = [Coulomb(0.3), Tresca(0.7), VariableCoulomb("pressure", TABLE),
        VariableCoulomb("speed", TABLE), VariableCoulomb("temperature", TABLE)]  # fmt: skip


@pytest.mark.parametrize("law", LAWS, ids=str)
@pytest.mark.parametrize(("p", "v"), [(0.5, 0.4), (1.7, 2.2), (2.9, 1.1), (4.0, 5.0)])
def test_slopes_of_friction_laws(law, p, v):
    """db/dp and db/dv by central differences, inside the tables and outside."""
    h = 1e-6
    found = law(at(p, v, 2.0))
    by_p = (law(at(p + h, v, 2.0)).value - law(at(p - h, v, 2.0)).value) / (2 * h)
    by_v = (law(at(p, v + h, 2.0)).value - law(at(p, v - h, 2.0)).value) / (2 * h)
    np.testing.assert_allclose(found.by_pressure, by_p, atol=1e-8)
    np.testing.assert_allclose(found.by_speed, by_v, atol=1e-8)


def test_conditions():
    """g + Σ a (p - v), s - Σ a (t - v) and t - b d, node by node and component by component."""
    ties = [Regularisation(np.array([0.5, 0.0]), np.array([2.0, 9.0]))]
    found = normal_condition(np.array([1.0, -1.0]), np.array([4.0, 5.0]), ties)
    np.testing.assert_allclose(found, [2.0, -1.0])
    slip, t = np.array([[1.0, 2.0], [3.0, 4.0]]), np.array([[2.0, 2.0], [1.0, 1.0]])
    tied = [Regularisation(np.array([0.5, 0.0]), np.array([[0.0, 2.0], [9.0, 9.0]]))]
    np.testing.assert_allclose(stick_condition(slip, t, tied), [[0.0, 2.0], [3.0, 4.0]])
    direction = np.array([[0.6, 0.8], [0.0, 0.0]])
    found = slip_condition(t, direction, np.array([5.0, 7.0]))
    np.testing.assert_allclose(found, [[-1.0, -2.0], [1.0, 1.0]])


def test_active_sets_differ_by_status_and_by_the_sense_of_slip():
    """A direction that turns by less than a right angle is the same slip."""
    first = ActiveSet(np.array([2, 2, 1], np.int8), np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 0]]))
    other = ActiveSet(
        np.array([2, 2, 0], np.int8), np.array([[0.1, 0.9, 0], [0, -1, 0], [0, 0, 0]])
    )
    np.testing.assert_array_equal(other.turned_from(first), [False, True, False])
    np.testing.assert_array_equal(other.differs_from(first), [False, True, True])
    np.testing.assert_array_equal(first.active, [True, True, True])
