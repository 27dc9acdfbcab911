"""What conditions say of tractions and heat flows on the boundary of a block."""

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.adaptivity.boundary_data import (
    cartesian_rows,
    facet_normals,
    heat_flows,
    tractions,
    vertex_conditions,
)
from contactfem.case.read import read_case
from contactfem.fem.body_mesh import distribute
from contactfem.fem.gathered_mesh import MeshView
from contactfem.meshes.data import matches

CASE = """
title = "A block"
dimension = "{dimension}"
time = {{ end = "1 s", step = "1 s" }}
[heat]
scheme = "steady"
[materials.solid]
youngs_modulus = "1 MPa"
poisson_ratio = 0.3
conductivity = "1 W/m/K"
[bodies.block]
material = "solid"
mesh = {{ builder = "block", width = "2 m", height = "1 m", nx = 4, ny = 2 }}
[[conditions]]
on = "block.bottom"
displacement.y = "0 m"
[[conditions]]
on = "block.top"
traction.x = "6 Pa"
[[conditions]]
on = "block.right"
pressure = "5 Pa"
[[conditions]]
on = "block.right"
convection = {{ coefficient = "3 W/m^2/K", ambient = "10 K" }}
[[conditions]]
on = "block.top"
heat_flux = "7 W/m^2"
[[conditions]]
on = "block.bottom"
temperature = "0 K"
"""


@pytest.fixture
def block(tmp_path):
    def make(dimension="plane strain"):
        (tmp_path / "case.toml").write_text(CASE.format(dimension=dimension))
        case = read_case(tmp_path / "case.toml")
        data = case.bodies["block"].mesh.build()
        return case, MeshView.of(MPI.COMM_SELF, distribute(MPI.COMM_SELF, data))

    return make


def on(view, side):
    return matches(view.data.groups[side], view.boundary)


def test_tractions(block):
    case, view = block()
    x = view.data.points
    found = tractions(case, "block", view, x, 1.0)
    assert found.known[on(view, "bottom")].tolist() == [[True, False]] * 4
    assert found.known[on(view, "left")].all()
    assert found.value[on(view, "top")].tolist() == [[6.0, 0.0]] * 4
    assert found.value[on(view, "right")].tolist() == [[-5.0, 0.0]] * 2
    assert not found.value[on(view, "left")].any()


def test_dead_loads_act_on_reference_areas_and_pressure_on_present_ones(block):
    case, view = block()
    found = tractions(case, "block", view, view.data.points * (1.5, 2.0), 1.0)
    np.testing.assert_allclose(found.value[on(view, "top")], [[4.0, 0.0]] * 4)
    np.testing.assert_allclose(found.value[on(view, "right")], [[-5.0, 0.0]] * 2)


def test_the_axis_is_no_free_surface(block):
    """There is no shear on it, and its normal stress is not known."""
    case, view = block("axisymmetric")
    found = tractions(case, "block", view, view.data.points * (1.5, 1.0), 1.0)
    assert found.known[on(view, "left")].tolist() == [[False, True]] * 2
    # areas of rings grow by 1.5² where the radius and the width grow by 1.5
    np.testing.assert_allclose(found.value[on(view, "top")], [[6.0 / 1.5**2, 0.0]] * 4)


def test_heat_flows(block):
    case, view = block()
    theta = view.data.points[:, 1] * 2.0  # 1 and 3 K in the middle of the facets on the right
    found = heat_flows(case, "block", view, theta + 0.0, 0.0)
    assert not found.known[on(view, "bottom")].any()
    assert sorted(found.value[on(view, "right"), 0]) == [3.0 * (0.5 - 10.0), 3.0 * (1.5 - 10.0)]
    assert set(found.value[on(view, "top"), 0]) == {-7.0}
    assert not found.value[on(view, "left")].any()


def test_conditions_at_vertices(block):
    """One where facets are in line, those of both sides at corners; a uniform stress obeys them."""
    case, view = block()
    x = view.data.points
    found = tractions(case, "block", view, x, 1.0)
    stress = np.array([2.0, 3.0, 0.0, 1.0])
    n = facet_normals(view.boundary, x)
    found.value[:] = n @ np.array([[2.0, 1.0], [1.0, 3.0]])
    rows = vertex_conditions(view.boundary, x, found, cartesian_rows, 4)
    np.testing.assert_allclose(rows.rows @ stress, rows.targets, atol=1e-12)
    corner = int(np.flatnonzero((x == (2.0, 1.0)).all(axis=1))[0])
    middle = int(np.flatnonzero((x == (1.0, 1.0)).all(axis=1))[0])
    foot = int(np.flatnonzero((x == (1.0, 0.0)).all(axis=1))[0])
    assert [int((rows.vertices == v).sum()) for v in (corner, middle, foot)] == [4, 2, 1]
