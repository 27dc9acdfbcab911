"""When a factor is renewed: where it is slow and much is left, not where little is."""

import pytest

from contactfem.solvers.lagged_bulk import should_refactorise

TOLERANCE = 1e-10


@pytest.mark.parametrize(
    ("residuals", "expected"),
    [
        ([0.2], False),  # nothing is known of the rate yet
        ([0.2, 0.15], True),  # hardly falls
        ([0.2, 0.4], True),  # rises
        ([0.2, float("inf")], True),
        ([0.2, 0.02], False),  # so far from the solution a new one is no better
        ([0.02, 0.003], True),
        ([3e-3, 1e-5], False),  # falls fast enough
        ([1e-8, 1e-9], False),  # two more do it
        ([1e-10, 0.9e-10], False),  # done
    ],
)
def test_worth_renewing(residuals, expected):
    assert should_refactorise(residuals, TOLERANCE) is expected


def test_not_a_number_asks_for_a_new_one():
    assert should_refactorise([0.2, float("nan")], TOLERANCE)
