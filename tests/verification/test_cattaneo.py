"""Partial slip: symmetry, the way of the loads, and ranks."""

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.results.expectations import measure

# facets of a/10, ten steps for the normal load
COARSE = (
    'bodies.lower.mesh.size="0.068 mm"',
    'bodies.upper.mesh.size="0.068 mm"',
    'time.step="0.1 s"',
)


@pytest.fixture(scope="module")
def coarse(solved):
    return solved("cattaneo_mindlin", *COARSE)


def test_error_falls_with_the_mesh(solved, coarse):
    values = measure(coarse)
    assert values["contact.pressure_error_l2"] < 0.05
    assert values["contact.traction_error_l2"] < 0.09
    assert values["contact.force_x"] == pytest.approx(-936.22, rel=1e-8)


def test_slip_zone_obeys_the_law(coarse):
    """|t| = μp where nodes slip, less where they stick, and friction takes energy everywhere."""
    (table,) = coarse.interfaces
    slip, stick = table.status == 2, table.status == 1
    assert slip.sum() >= 4
    assert stick.sum() >= 8
    np.testing.assert_allclose(np.abs(table.traction[slip]), 0.2 * table.pressure[slip], rtol=1e-9)
    assert np.all(np.abs(table.traction[stick]) < 0.2 * table.pressure[stick])
    total = sum(step.dissipation for step in coarse.steps)
    assert all(step.dissipation > -1e-9 * total for step in coarse.steps)


def test_q_alone_decides_the_sign(solved, coarse):
    """The mirrored load gives the mirrored traction."""
    load = '[["0 s", "0 N/mm"], ["1 s", "0 N/mm"], ["2 s", "-0.93622 N/mm"]]'
    other = solved("cattaneo_mindlin", *COARSE, f"conditions.1.grip.force.x={load}")
    a, b = coarse.interfaces[0], other.interfaces[0]
    scale = np.abs(a.traction).max()
    np.testing.assert_allclose(b.traction[::-1], -a.traction, rtol=0, atol=1e-7 * scale)


@pytest.mark.mpi
def test_ranks_agree(solved, same, coarse):
    same(coarse, solved("cattaneo_mindlin", *COARSE, comm=MPI.COMM_WORLD))
