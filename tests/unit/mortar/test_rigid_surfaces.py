"""Rigid obstacles in space: what they enclose, how they are turned, their directions."""

import numpy as np
import pytest

from contactfem.common.time_table import constant
from contactfem.geometry.facets import around
from contactfem.meshes.triangles import read_triangles
from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.rigid_surfaces import (
    cylinder_side,
    spatial_plane,
    sphere_side,
    triangulated_side,
)
from contactfem.mortar.sides import RigidSide

REST = (constant(0.0),) * 3
EVERYWHERE = np.array(((-9.0,) * 3, (9.0,) * 3))
CENTRE = (1.0, 2.0, 3.0)


def flux(side: RigidSide, centre=CENTRE) -> float:
    """Volume that facets enclose, by the divergence of x/3; negative if they look inward."""
    total = 0.0
    X = side.X - np.array(centre)
    for a, b, c, d in around(side.facets):
        total += X[a] @ np.cross(X[b], X[c]) / 6.0
        total += X[a] @ np.cross(X[c], X[d]) / 6.0
    return total


@pytest.mark.parametrize(("inside", "sign"), [(False, 1.0), (True, -1.0)])
def test_a_sphere_encloses_its_volume(inside, sign):
    side = sphere_side(CENTRE, 2.0, inside, 0.3, EVERYWHERE, REST)
    assert flux(side) == pytest.approx(sign * 4.0 / 3.0 * np.pi * 8.0, rel=1e-12)
    r = np.linalg.norm(side.X - CENTRE, axis=1)
    assert r == pytest.approx(2.0, rel=0.01)
    assert side.facets.shape[1] == 3
    edges = side.X[side.facets] - side.X[np.roll(side.facets, 1, axis=1)]
    assert np.linalg.norm(edges, axis=2).max() < 0.3


@pytest.mark.parametrize(("inside", "sign"), [(False, 1.0), (True, -1.0)])
def test_a_cylinder_has_the_area_of_its_circle(inside, sign):
    axis = np.array([1.0, 2.0, -1.0])
    side = cylinder_side(CENTRE, axis, 0.5, inside, 64, 3.0, REST)
    # the sides alone, without the ends: 2/3 of the volume goes through them
    assert flux(side) == pytest.approx(sign * 2.0 / 3.0 * np.pi * 0.25 * 6.0, rel=1e-12)


def test_a_plane_looks_along_its_normal():
    normal = np.array([1.0, -2.0, 0.5])
    side = spatial_plane(CENTRE, normal, 4.0, REST)
    a, b, c, d = side.X[around(side.facets)[0]]
    n = np.cross(c - a, d - b)
    assert n / np.linalg.norm(n) == pytest.approx(normal / np.linalg.norm(normal), abs=1e-15)
    assert (side.X - CENTRE) @ normal == pytest.approx(0.0, abs=1e-14)
    assert 0.5 * np.linalg.norm(n) == pytest.approx(64.0, rel=1e-14)


@pytest.mark.parametrize(
    "side",
    [
        spatial_plane(CENTRE, (1.0, -2.0, 0.5), 4.0, REST),
        sphere_side(CENTRE, 2.0, False, 0.5, EVERYWHERE, REST),
        sphere_side(CENTRE, 2.0, True, 0.5, EVERYWHERE, REST),
        cylinder_side(CENTRE, (1.0, 2.0, -1.0), 0.5, False, 16, 3.0, REST),
    ],
    ids=["plane", "sphere", "hollow", "cylinder"],
)
def test_directions_are_units_with_their_derivative(side):
    rng = np.random.default_rng(1)
    points = np.array(CENTRE) + rng.normal(size=(5, 3))
    facets = np.array([(0, 1, 2, 2), (2, 3, 4, 4)])
    X = np.vstack((points, side.X))
    mesh = InterfaceMesh(5, facets, around(side.facets) + 5, X, np.ones(X.shape, bool))
    n, slopes = side.directions(mesh, X)
    assert np.linalg.norm(n, axis=1) == pytest.approx(1.0, rel=1e-14)
    step = 1e-6
    for k in range(3):
        moved = X.copy()
        moved[:5, k] += step
        ahead = side.directions(mesh, moved)[0]
        moved[:5, k] -= 2.0 * step
        behind = side.directions(mesh, moved)[0]
        assert slopes[:, :, k] == pytest.approx((ahead - behind) / (2.0 * step), abs=1e-8)


def test_an_stl_file_is_one_surface(tmp_path):
    """Each triangle of an STL file has points of its own; they are joined."""
    corners = {"a": (0, 0, 0), "b": (1, 0, 0), "c": (0, 1, 0), "d": (0, 0, 1)}
    lines = ["solid tetrahedron"]
    for names in ("acb", "abd", "bcd", "cad"):
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex {} {} {}".format(*corners[name]) for name in names]
        lines += ["endloop", "endfacet"]
    path = tmp_path / "body.stl"
    path.write_text("\n".join([*lines, "endsolid tetrahedron"]))
    points, triangles = read_triangles(path)
    assert points.shape == (4, 3)
    side = triangulated_side(points, triangles, REST)
    assert flux(side, (0, 0, 0)) == pytest.approx(1.0 / 6.0, rel=1e-6)


def test_a_large_sphere_has_facets_only_near_the_body():
    """A million edges around would be needed; a body of 1 mm sees a few thousand facets."""
    near = np.array([(-5e-4, -1e-3, -5e-4), (5e-4, 0.0, 5e-4)])
    side = sphere_side((0.0, 1.0, 0.0), 1.0, False, 5e-5, near, REST)
    assert len(side.facets) < 5000
    r = np.linalg.norm(side.X - (0.0, 1.0, 0.0), axis=1)
    assert r == pytest.approx(1.0, abs=(5e-5) ** 2)
    low, high = side.X.min(axis=0), side.X.max(axis=0)
    assert (low[[0, 2]] < near[0][[0, 2]]).all()
    assert (high[[0, 2]] > near[1][[0, 2]]).all()
