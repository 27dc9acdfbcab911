"""Steps that were solved, but in which friction is not known."""

from types import SimpleNamespace

import numpy as np
import pytest

from contactfem.laws.active_set import ActiveSet
from contactfem.laws.friction import Coulomb, frictionless
from contactfem.solvers.diagnosis import WITHOUT_SLIP, trust_check

COULOMB = Coulomb(0.3)


def scene(friction=COULOMB, before=(1.0, 1.0, 1.0), direction=(1.0, 0.0, 0.0), p=(1.0, 1.0, 1.0)):
    """Three nodes in contact: one slips, two stick or have no slip."""
    law = SimpleNamespace(friction=friction, has_friction=friction is not frictionless)
    interface = SimpleNamespace(name="sole", contact=SimpleNamespace(law=law))
    conditions = SimpleNamespace(
        active=np.array(p) != 0.0,
        multiplier=SimpleNamespace(pressure=np.array(p)),
        active_set=ActiveSet(np.array([2, 1, 1], np.int8), np.outer(direction, (0.6, -0.8))),
        operators=SimpleNamespace(D=np.array((0.5, 1.0, 0.5))),
        history=SimpleNamespace(D=np.array(before)),
    )
    return trust_check([interface], [conditions])


def test_nodes_that_faced_something_are_no_reason():
    assert scene() == ""
    assert scene(p=(0.0, 0.0, 0.0), before=(0.0, 0.0, 0.0)) == ""


def test_nodes_from_nowhere_are_told_by_their_share_of_the_force():
    assert scene(before=(1.0, 0.0, 1.0)).startswith("50% of the normal force at 'sole' is on nodes")
    assert scene(before=(1.0, 1.0, 0.0)).startswith("25% of")


def test_nodes_that_follow_a_neighbour_have_their_friction():
    assert scene(before=(0.0, 1.0, 1.0)) == ""


@pytest.mark.parametrize("factor", [0.9, 1.1])
def test_little_force_is_no_reason(factor):
    small = factor * WITHOUT_SLIP
    p = (2.0 * (1 - small), 0.0, 2.0 * small)
    assert (scene(before=(1.0, 1.0, 0.0), p=p) != "") == (factor > 1)


def test_without_friction_nothing_is_lost():
    assert scene(friction=frictionless, before=(0.0, 0.0, 0.0)) == ""
