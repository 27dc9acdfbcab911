"""Which nodes several surfaces share, and that they carry no multiplier."""

from dataclasses import replace

import numpy as np
import pytest
from spatial_surfaces import two_grids

from contactfem.errors import CaseError
from contactfem.mortar.crosspoints import check_shared, shared_nodes


def test_shared_nodes():
    """A vertex counts once per surface it is on; the same number in another body is another one."""
    bottom, left, right = np.array([3, 4, 5]), np.array([9, 3]), np.array([5, 7])
    interfaces = {
        "sole": ((0, bottom), None),
        "side": ((0, left), (1, np.array([4, 9]))),
        "far": ((1, np.array([3, 9])), (0, right)),
    }
    found = {name: shared.tolist() for name, shared in shared_nodes(interfaces).items()}
    expected = {"sole": [True, False, True], "side": [False, True], "far": [False, True]}
    assert found == expected


def test_shared_nodes_carry_no_multiplier(chains):
    mesh, _ = chains()
    shared = np.zeros(mesh.n_nonmortar, bool)
    shared[[0, 3]] = True
    np.testing.assert_array_equal(
        replace(mesh, shared=shared).has_multiplier, mesh.has_multiplier & ~shared
    )


def test_shared_nodes_in_space_are_served_from_further_off():
    """A corner facet all of whose nodes are shared; only where no other is left it is an error."""
    mesh = two_grids(3, 4, 2, 4)
    low = (mesh.X[: mesh.n_nonmortar, :2] < -0.1).all(1)
    check_shared({"some": replace(mesh, shared=low)})
    every = replace(mesh, shared=np.ones(mesh.n_nonmortar, bool))
    with pytest.raises(
        CaseError, match=r"interface all: nodes of the nonmortar facet at \(.*, .*, 0\) m"
    ):
        check_shared({"all": every})
