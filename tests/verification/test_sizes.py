"""The adaptive strategy on a steady heat source: meshes with the error that was asked for."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator
from verification.p1_conduction import Plate, estimated

from contactfem.adaptivity.sizes import (
    SizeLimits,
    equal_error_sizes,
    goal,
    predicted_cells,
    predicted_error,
    size_field,
)
from contactfem.geometry.cells import cell_sizes
from contactfem.meshes.gmsh_session import gmsh_session
from contactfem.results.relative_error import RelativeError

WIDTH, CENTRE = 0.1, np.array([0.4, 0.55])
LIMITS = SizeLimits(smallest=1e-4, largest=0.2, growth=0.5, cells=10**6, coarsening=4.0)


def temperature(x):
    return np.exp(-((x - CENTRE) ** 2).sum(-1) / WIDTH**2)


def gradient(x):
    return -2.0 * (x - CENTRE) / WIDTH**2 * temperature(x)[..., None]


def source(x):
    r = ((x - CENTRE) ** 2).sum(-1) / WIDTH**2
    return (4.0 - 4.0 * r) / WIDTH**2 * temperature(x)


def square(size: Callable[[float, float], float]) -> Plate:
    """Frontal-Delaunay mesh of the unit square that follows a size field."""
    with gmsh_session() as gmsh:
        geo = gmsh.model.geo
        corners = [geo.addPoint(x, y, 0.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
        lines = [geo.addLine(corners[i], corners[(i + 1) % 4]) for i in range(4)]
        geo.addPlaneSurface([geo.addCurveLoop(lines)])
        geo.synchronize()
        gmsh.option.setNumber("Mesh.Algorithm", 6)
        gmsh.model.mesh.setSizeCallback(lambda d, t, x, y, z, lc: float(size(x, y)))
        gmsh.model.mesh.generate(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        cells = gmsh.model.mesh.getElementsByType(2)[1].reshape(-1, 3)
    order = np.argsort(tags)
    points = coordinates.reshape(-1, 3)[order, :2]
    return Plate(points, np.searchsorted(tags[order], cells))


@dataclass(frozen=True)
class Found:
    """A discrete solution: squares of estimated errors, the relative error, and the true one."""

    plate: Plate
    errors: np.ndarray
    estimate: RelativeError
    true: RelativeError


def found(plate: Plate) -> Found:
    sides = [plate.at_edge(axis, value) for axis in (0, 1) for value in (0.0, 1.0)]
    found = estimated(plate, np.unique(np.concatenate(sides)), temperature, gradient, source)
    return Found(plate, found.errors, found.estimate, found.true)


def wanted(state: Found, tolerance: float) -> np.ndarray:
    plate = state.plate
    sizes = cell_sizes(plate.points, plate.cells)
    new = equal_error_sizes(sizes, state.errors, goal(state.estimate, tolerance), 1)
    return size_field(plate.points, plate.cells, sizes, new, LIMITS)


def predicted(state: Found, field: np.ndarray) -> tuple[float, float]:
    """Cells and error of a mesh with these sizes."""
    points, cells = state.plate.points, state.plate.cells
    square = predicted_error(cells, cell_sizes(points, cells), field, state.errors, 1)
    return predicted_cells(points, cells, field, LIMITS), np.sqrt(square)


@pytest.mark.parametrize("tolerance", [0.2, 0.1, 0.05])
def test_two_meshes_reach_the_tolerance_with_equal_errors(tolerance):
    state = found(square(lambda x, y: 0.07))
    for _ in range(2):
        field = wanted(state, tolerance)
        cells, error = predicted(state, field)
        state = found(square(LinearNDInterpolator(state.plate.points, field)))
    uniform = found(square(lambda x, y: 0.02))
    needed = len(uniform.plate.cells) * (uniform.true.eta / tolerance) ** 2
    assert state.estimate.eta == pytest.approx(tolerance, rel=0.05)
    assert state.estimate.error / state.true.error == pytest.approx(1.0, abs=0.1)
    assert cells == pytest.approx(len(state.plate.cells), rel=0.15)
    assert error == pytest.approx(state.estimate.error, rel=0.08)
    assert len(state.plate.cells) < needed / 4
    assert spread(state) < 0.5 * spread(uniform)


def spread(state: Found) -> float:
    """Standard deviation of the errors of cells over their mean."""
    errors = np.sqrt(state.errors)
    return float(errors.std() / errors.mean())


def test_a_right_mesh_is_predicted_to_stay():
    """The sizes wanted of a mesh that was made for a tolerance are those that it has."""
    state = found(square(lambda x, y: 0.07))
    for _ in range(3):
        state = found(square(LinearNDInterpolator(state.plate.points, wanted(state, 0.1))))
    field = wanted(state, 0.1)
    cells, _ = predicted(state, field)
    assert cells == pytest.approx(len(state.plate.cells), rel=0.15)
