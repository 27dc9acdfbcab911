"""Neighbours along edges, and multipliers of nodes that have none."""

import numpy as np
import pytest
from spatial_surfaces import grid, neighbours

from contactfem.mortar.multiplier_extension import extension


@pytest.mark.parametrize("kind", [3, 4])
def test_whole_rim_without_multiplier(kind):
    X, facets = grid(4, kind, jitter=0.0)
    inner = (abs(X[:, :2]) < 0.49).all(1)
    E = extension(neighbours(facets, len(X)), inner)
    np.testing.assert_allclose(np.asarray(E.sum(1)).ravel(), 1.0, rtol=1e-15)
    assert (E[:, ~inner].toarray() == 0).all()
    np.testing.assert_array_equal(E[inner].toarray(), np.eye(len(X))[inner])


def test_corner_takes_what_its_neighbours_got():
    """Of nine nodes only the middle one has a multiplier: a corner is two edges away from it."""
    _, facets = grid(2, 4)
    middle = np.arange(9) == 4
    E = extension(neighbours(facets, 9), middle).toarray()
    np.testing.assert_array_equal(E[:, 4], 1.0)
    np.testing.assert_array_equal(E[:, ~middle], 0.0)


def test_nodes_out_of_reach():
    """Two facets that share no node: one of them has no multiplier at all."""
    facets = np.array([[0, 1, 2, 2], [3, 4, 5, 5]])
    E = extension(neighbours(facets, 6), np.arange(6) < 2).toarray()
    np.testing.assert_array_equal(E[2], [0.5, 0.5, 0, 0, 0, 0])
    np.testing.assert_array_equal(E[3:], 0.0)
