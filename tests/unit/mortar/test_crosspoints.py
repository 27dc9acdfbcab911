"""Which nodes several surfaces share, and that they carry no multiplier."""

from dataclasses import replace

import numpy as np

from contactfem.mortar.crosspoints import shared_nodes


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
