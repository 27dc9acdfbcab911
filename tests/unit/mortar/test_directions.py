"""Direction of contact with rigid obstacles: theirs, with exact derivatives, whoever leans."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from mpi4py import MPI

from contactfem.common.time_table import constant
from contactfem.contact.conditions import Contact, ContactLaw
from contactfem.contact.slip import tangential
from contactfem.contact.state import ContactHistory
from contactfem.contact.tangent import RowScales, linearise
from contactfem.laws.active_set import Status
from contactfem.laws.friction import Coulomb
from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.normals import line_tangents, nodal_normals
from contactfem.mortar.search_range import SearchRange
from contactfem.mortar.sides import circle_side, plane_side, polyline_side

REST = (constant(0.0), constant(0.0))
CENTRE = np.array((0.4, 1.5))


def below(chains, side, **given):
    """Put the wavy nonmortar side of `chains` below an obstacle."""
    mesh, x = chains(**given)
    n = mesh.n_nonmortar
    points = np.vstack((mesh.X[:n], side.X))
    free = np.vstack((mesh.free[:n], np.zeros(side.X.shape, bool)))
    mesh = InterfaceMesh(
        n, mesh.nonmortar, side.facets + n, points, free, directions=side.directions
    )
    return mesh, np.vstack((x[:n], side.X))


def test_plane_gives_its_own_normal(chains):
    """Not that of the waves below it, and nothing turns it."""
    slope = np.array((-0.6, 0.8))
    mesh, x = below(chains, plane_side((0.0, 0.5), -3.0 * slope, 5.0, REST), wave=0.3)
    field = nodal_normals(mesh, x)
    np.testing.assert_allclose(field.n, np.tile(slope, (len(field.n), 1)), atol=1e-15)
    assert abs(field.derivative).max() == 0


@pytest.mark.parametrize("inside", [False, True])
def test_circle_is_met_along_its_radius(chains, inside):
    """Towards its centre from outside, away from it from inside; wherever it has moved."""
    mesh, x = below(chains, circle_side(CENTRE, 0.7, inside, 64, REST), wave=0.3)
    x[mesh.n_nonmortar :] += (0.2, -0.1)
    field = nodal_normals(mesh, x)
    radius = np.add(CENTRE, (0.2, -0.1)) - x[: mesh.n_nonmortar]
    radius *= (-1 if inside else 1) / np.hypot(*radius.T)[:, None]
    np.testing.assert_allclose(field.n, radius, atol=1e-14)


def test_a_node_in_the_centre_has_a_direction(chains):
    mesh, x = below(chains, circle_side((0.0, 0.0), 0.7, True, 64, REST))
    x[3] = x[mesh.n_nonmortar :].mean(0)
    field = nodal_normals(mesh, x)
    np.testing.assert_allclose(np.hypot(*field.n.T), 1.0)
    assert np.isfinite(field.blocks).all()


def test_polylines_with_corners_leave_it_to_the_body(chains):
    """One straight piece is a plane; a chain has no smooth direction of its own."""
    points = np.array(((-1.0, 0.5), (0.4, 0.3), (2.0, 0.5)))
    mesh, x = below(chains, polyline_side(points, False, REST), wave=0.2)
    averaged = nodal_normals(replace(mesh, directions=None), x).n
    np.testing.assert_array_equal(nodal_normals(mesh, x).n, averaged)
    one = below(chains, polyline_side(points[::2], False, REST), wave=0.2)
    np.testing.assert_allclose(
        nodal_normals(*one).n, np.tile((0, 1), (len(averaged), 1)), atol=1e-15
    )


@pytest.mark.parametrize("inside", [False, True])
def test_derivative(chains, inside):
    """Of the normals and of all rows of contact on a circle, by differences at a random state."""
    rng = np.random.default_rng(1)
    centre = (0.45, -1.0) if inside else (0.45, 1.0)
    circle = circle_side(centre, 1.03 if inside else 0.97, inside, 200, REST)
    mesh, start = below(chains, circle, seed=1, wave=0.02, held=((0, 0),))
    n = mesh.n_nonmortar
    moving = np.zeros(start.shape)
    moving[:n] = 1.0
    reach = SearchRange.within(0.3, len(mesh.nonmortar))
    law = ContactLaw(Coulomb(0.4), np.full(n, 5.0), 1.0, 0.7, 1.0, reach)
    contact = Contact(MPI.COMM_SELF, mesh, law)
    operators = contact.operators(start)
    history = ContactHistory.at(operators)
    x = start + 0.004 * moving * rng.normal(size=start.shape)
    field = nodal_normals(mesh, x)
    p, t = rng.uniform(0.2, 1.0, (n, 1)), 0.35 * rng.normal(size=(n, 1))
    multiplier = p * field.n + t * line_tangents(field.n)

    def rows(y):
        c = contact.state(contact.operators(y), multiplier, history)
        forces = -(c.operators.M.T @ c.multiplier.vector)
        normal = c.residuals.normal[:, None] * field.n
        along = tangential(c.residuals.tangential, field.n)
        return np.concatenate((forces.ravel(), normal.ravel(), along.ravel()))

    conditions = contact.state(contact.operators(x), multiplier, history)
    assert {Status.STICK, Status.SLIP} <= set(conditions.status)
    one, zero, first = np.ones(n), np.zeros(n), 2 * mesh.n_nodes
    scales = RowScales(one, zero), RowScales(zero, one)
    parts = [linearise(contact, conditions, s).by_position.scipy() for s in scales]
    exact = sp.vstack((parts[0], parts[1][first:]))
    for _ in range(3):
        v = moving * rng.normal(size=x.shape)
        by_normals = (
            nodal_normals(mesh, x + 1e-6 * v).n - nodal_normals(mesh, x - 1e-6 * v).n
        ) / 2e-6
        found = field.derivative @ v.ravel()
        np.testing.assert_allclose(found, by_normals.ravel(), atol=1e-8 * abs(found).max())
        difference = (rows(x + 1e-6 * v) - rows(x - 1e-6 * v)) / 2e-6
        found = exact @ v.ravel()
        for part in (slice(first), slice(first, first + 2 * n), slice(first + 2 * n, None)):
            scale = abs(found[part]).max()
            assert abs(found[part] - difference[part]).max() <= 1e-6 * scale
