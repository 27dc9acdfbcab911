"""A layer of heat with flat cells: as accurate as with equilateral ones, and known to be."""

from dataclasses import dataclass

import numpy as np
import pytest
from verification.p1_conduction import Plate, estimated

from contactfem.adaptivity.sizes import SizeLimits, equal_error_sizes, goal, size_field
from contactfem.geometry.cells import cell_sizes, thicknesses
from contactfem.meshes.block import Block
from contactfem.meshes.data import MeshData
from contactfem.meshes.layers import Layers
from contactfem.meshes.size_field import size_field as on_mesh
from contactfem.results.relative_error import RelativeError

LAYER, WAVE = 1e-3, 2.0 * np.pi
BODY = Block(width="1 m", height="1 m", nx=10, ny=10, cell="triangle")


def temperature(x):
    """Falls off within LAYER below y = 1, and varies along it."""
    return np.exp((x[..., 1] - 1.0) / LAYER) * (1.0 + 0.3 * np.sin(WAVE * x[..., 0]))


def gradient(x):
    fall, along = np.exp((x[..., 1] - 1.0) / LAYER), WAVE * x[..., 0]
    return np.stack((0.3 * WAVE * fall * np.cos(along), temperature(x) / LAYER), axis=-1)


def source(x):
    fall, along = np.exp((x[..., 1] - 1.0) / LAYER), WAVE * x[..., 0]
    return 0.3 * WAVE**2 * fall * np.sin(along) - temperature(x) / LAYER**2


@dataclass(frozen=True)
class Found:
    """A mesh with squares of estimated errors, the relative error, and the true one."""

    data: MeshData
    errors: np.ndarray
    estimate: RelativeError
    true: RelativeError


def found(data: MeshData) -> Found:
    outside = np.unique([v for group in data.groups.values() for v in group.ravel()])
    plate = Plate(data.points, data.cells)
    found = estimated(plate, outside, temperature, gradient, source)
    return Found(data, found.errors, found.estimate, found.true)


def adapted(aspect: float, tolerance: float) -> Found:
    """After some new meshes that each follow from the errors of the one before."""
    layers = None if aspect == 1.0 else Layers(frozenset({"top"}), aspect, np.inf)
    sizes = cell_sizes if aspect == 1.0 else thicknesses
    data = BODY.adapted(on_mesh(BODY.build(), np.full(121, 0.02)))
    for _ in range(8):
        state = found(data)
        h = sizes(data.points, data.cells)
        wanted = equal_error_sizes(h, state.errors, goal(state.estimate, tolerance), 1)
        limits = SizeLimits(1e-6, 0.1, 0.2, 10**6, aspect=aspect)
        data = BODY.adapted(
            on_mesh(data, size_field(data.points, data.cells, h, wanted, limits)), (), layers
        )
    return found(data)


@pytest.fixture(scope="module")
def flat():
    return adapted(20.0, 0.1)


def test_the_error_asked_for_with_few_cells(flat):
    plain = adapted(1.0, 0.1)
    assert flat.true.eta == pytest.approx(0.1, rel=0.1)
    assert plain.true.eta == pytest.approx(0.1, rel=0.1)
    fewer = len(plain.data.cells) / len(flat.data.cells) * (plain.true.eta / flat.true.eta) ** 2
    assert fewer > 5.0


def test_the_error_is_known(flat):
    assert flat.estimate.error == pytest.approx(flat.true.error, rel=0.02)


def test_the_error_falls_with_the_cells(flat):
    """At least by the order of linear elements, half of it with four times the cells."""
    fine = adapted(20.0, 0.05)
    assert fine.true.eta == pytest.approx(0.05, rel=0.1)
    cells = len(fine.data.cells) / len(flat.data.cells)
    assert np.log(flat.true.eta / fine.true.eta) / np.log(cells) > 0.5
