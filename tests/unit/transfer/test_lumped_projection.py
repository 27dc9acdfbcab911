"""Temperatures on the triangles of another mesh."""

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.fem.body_mesh import distribute
from contactfem.meshes.block import Block
from contactfem.transfer.lumped_projection import LumpedProjection
from contactfem.transfer.volume import VolumeTransfer


def block(comm, nx, ny, cell="triangle"):
    builder = Block(width=1.0, height=1.0, nx=nx, ny=ny, cell=cell)
    return distribute(comm, builder.build() if comm.rank == 0 else None)


def data(comm, mesh):
    return comm.bcast(mesh.data)


def integral(mesh, values):
    """Of a linear field on triangles or rectangles."""
    a, b, c = mesh.points[mesh.cells[:, :3]].transpose(1, 2, 0)
    cross = np.abs((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0])
    area = (0.5 if mesh.cells.shape[1] == 3 else 1.0) * cross
    return float(area @ values[mesh.cells].mean(axis=1))


@pytest.mark.mpi
@pytest.mark.quick
def test_linear_fields_are_kept():
    comm = MPI.COMM_WORLD
    source, target = block(comm, 7, 5), block(comm, 9, 8)
    move = LumpedProjection(comm, source, target, "block")
    x, y = data(comm, source).points, data(comm, target).points
    np.testing.assert_allclose(
        move(3.0 * x[:, 0] - x[:, 1] + 2.0), 3.0 * y[:, 0] - y[:, 1] + 2.0, rtol=1e-13
    )


@pytest.mark.mpi
@pytest.mark.quick
def test_integrals_of_bent_fields_are_kept_far_better_than_by_interpolation():
    comm = MPI.COMM_WORLD
    source, target = block(comm, 20, 20), block(comm, 23, 23)
    x, wanted = data(comm, source), data(comm, target)
    theta = np.exp(-4.0 * x.points[:, 1])
    true = integral(x, theta)
    straight = integral(wanted, VolumeTransfer(comm, source, target, "block")(theta)) - true
    projected = integral(wanted, LumpedProjection(comm, source, target, "block")(theta)) - true
    assert straight > 0.0  # chords of a convex field
    assert abs(projected) < 0.2 * straight


def test_a_layer_stays_as_thin_over_many_meshes():
    """Twenty exchanges of two meshes: interpolation alone makes it thicker each time."""
    comm = MPI.COMM_SELF
    meshes = [block(comm, 2, 40), block(comm, 2, 47)]
    theta = np.exp(-((meshes[0].data.points[:, 1] / 0.1) ** 2))

    def second_moment(mesh, values):
        return integral(mesh, values * mesh.points[:, 1] ** 2) / integral(mesh, values)

    before = second_moment(meshes[0].data, theta)
    growth = []
    for kind in (VolumeTransfer, LumpedProjection):
        forth, back = (kind(comm, meshes[k], meshes[1 - k], "block") for k in (0, 1))
        values = theta
        for _ in range(10):
            values = back(forth(values))
        growth.append(second_moment(meshes[0].data, values) / before - 1.0)
    assert growth[0] > 0.1
    assert abs(growth[1]) < 0.2 * growth[0]


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
def test_a_layer_thinner_than_the_cells_has_its_content(cell):
    """On cells ten times as large as it is thick: interpolation gives 4.8 times as much."""
    comm = MPI.COMM_SELF
    source, target = block(comm, 4, 160), block(comm, 4, 10, cell)
    theta = np.exp(-(source.data.points[:, 1] / 0.01))
    true = integral(source.data, theta)
    values = LumpedProjection(comm, source, target, "block")(theta)
    assert integral(target.data, values) == pytest.approx(true, rel=2e-3)
    straight = VolumeTransfer(comm, source, target, "block")(theta)
    assert integral(target.data, straight) > 4.8 * true
    assert values.max() < 0.6


def test_on_finer_cells_a_field_stays_as_it_is():
    comm = MPI.COMM_SELF
    source, target = block(comm, 5, 5), block(comm, 40, 40)
    theta = np.random.default_rng(1).normal(size=len(source.data.points))
    interpolated = VolumeTransfer(comm, source, target, "block")(theta)
    projected = LumpedProjection(comm, source, target, "block")(theta)
    np.testing.assert_allclose(projected, interpolated, atol=1e-12)
