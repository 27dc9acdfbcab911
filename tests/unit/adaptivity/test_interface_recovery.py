"""Joint fits across an interface: exact where both fields are linear, and balanced everywhere."""

import numpy as np
import pytest
from verification.p1_conduction import jittered

from contactfem.adaptivity.recovery.constraints import traction_rows
from contactfem.adaptivity.recovery.interface import (
    MechanicalState,
    Side,
    ThermalState,
    closest,
    recover_heat_flux,
    recover_stress,
)
from contactfem.adaptivity.recovery.patches import patches

NORMALS = (np.array([0.0, 1.0]), np.array([0.0, -1.0]))  # outward from the lower and the upper body


@pytest.fixture
def plates():
    return jittered((9, 7), (0.0, -1.0), seed=1), jittered((13, 11), seed=2)


def side(plate, samples):
    fits = patches(plate.points, plate.cells, plate.at_edge(1, 0.0))
    return Side(fits, fits.fit(samples))


def noise(plate, components, seed):
    return np.random.default_rng(seed).normal(size=(len(plate.cells), components))


def thermal(points, normal, active=True, dissipation=0.0, outflow=0.0):
    k = len(points)
    values = [np.broadcast_to(v, k) for v in (active, dissipation, outflow)]
    return ThermalState(np.tile(normal, (k, 1)), *values)


def mechanical(points, normal, active=True, frictionless=False):
    k = len(points)
    return MechanicalState(
        np.tile(normal, (k, 1)), *[np.broadcast_to(v, k) for v in (active, frictionless)]
    )


def test_closest_vertices_both_ways():
    a, b = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]), np.array([[1.6, 0.1], [0.3, 0.1]])
    assert closest(a, b).tolist() == [1, 0, 0]
    assert closest(b, a).tolist() == [2, 0]


def test_right_linear_fluxes_stay_as_they_are(plates):
    """q = (x, 1) below and (2 x, 4 + x) above: d = q_y above - q_y below = 3 + x."""
    q = [lambda x: np.column_stack((x[:, 0], 0 * x[:, 0] + 1.0))]
    q.append(lambda x: np.column_stack((2.0 * x[:, 0], 4.0 + x[:, 0])))
    centres = [plate.points[plate.cells].mean(1) for plate in plates]
    sides = [side(plate, f(c)) for plate, f, c in zip(plates, q, centres, strict=True)]
    for k in (0, 1):
        x = sides[k].patches.centres
        state = thermal(x, NORMALS[k], dissipation=3.0 + x[:, 0])
        fit = recover_heat_flux(sides[k], sides[1 - k], state)
        np.testing.assert_allclose(fit.standard.values, q[k](x), atol=1e-12)
        np.testing.assert_allclose(fit.extended.values, q[1 - k](x), atol=1e-12)


def test_heat_balance_holds_whatever_the_samples(plates):
    """Heat that leaves the lower body and d enter the upper one: q_y above - q_y below = d."""
    sides = [side(plate, noise(plate, 2, k)) for k, plate in enumerate(plates)]
    for k in (0, 1):
        x = sides[k].patches.centres
        d = 2.0 + np.cos(3 * x[:, 0])
        fit = recover_heat_flux(sides[k], sides[1 - k], thermal(x, NORMALS[k], dissipation=d))
        flows = [fit.standard.values[:, 1], fit.extended.values[:, 1]]
        rise = flows[1] - flows[0] if k == 0 else flows[0] - flows[1]
        assert np.abs(rise - d).max() < 1e-6
        assert np.abs(sides[k].coefficients[:, 0, 1] - fit.standard.values[:, 1]).max() > 0.1


def test_open_vertices_obey_their_own_condition_alone(plates):
    sides = [side(plate, noise(plate, 2, k)) for k, plate in enumerate(plates)]
    x = sides[0].patches.centres
    state = thermal(x, NORMALS[0], active=x[:, 0] < 0.5, dissipation=1.0, outflow=0.25)
    fit = recover_heat_flux(*sides, state)
    free = x[:, 0] >= 0.5
    assert np.abs(fit.standard.values[free, 1] - 0.25).max() < 1e-7
    partner = closest(x, sides[1].patches.centres)[free]
    np.testing.assert_array_equal(fit.extended.coefficients[free], sides[1].coefficients[partner])
    jump = fit.extended.values[~free, 1] - fit.standard.values[~free, 1]
    assert np.abs(jump - 1.0).max() < 1e-6


def test_tractions_follow_the_status(plates):
    """Open: none on either body. Frictionless: no tangential one. Otherwise: [[σn]] = 0."""
    sides = [side(plate, noise(plate, 4, k)) for k, plate in enumerate(plates)]
    for k in (0, 1):
        x = sides[k].patches.centres
        touching, smooth = x[:, 0] < 0.7, x[:, 0] < 0.3
        state = mechanical(x, NORMALS[k], touching, smooth)
        fit = recover_stress(sides[k], sides[1 - k], state)
        rows = traction_rows(state.normals)
        own, other = (np.einsum("krc,kc->kr", rows, e.values) for e in (fit.standard, fit.extended))
        assert np.abs(own[~touching]).max() < 1e-6
        assert np.abs(own[smooth, 1]).max() < 1e-6
        assert np.abs((own - other)[touching, 0]).max() < 1e-6
        assert np.abs((own - other)[touching & ~smooth, 1]).max() < 1e-6
        assert np.abs(own[touching]).max() > 0.1


def test_right_linear_stresses_stay_as_they_are(plates):
    """Equal yy and xy along y = 0; xx and zz may jump."""

    def stress(x, k):
        return np.column_stack(
            ((1 + k) * x[:, 0], -2.0 + x[:, 0] + k * x[:, 1], k + x[:, 1], 0.5 - x[:, 0])
        )

    sides = [side(p, stress(p.points[p.cells].mean(1), k)) for k, p in enumerate(plates)]
    for k in (0, 1):
        x = sides[k].patches.centres
        fit = recover_stress(sides[k], sides[1 - k], mechanical(x, NORMALS[k]))
        np.testing.assert_allclose(fit.standard.values, stress(x, k), atol=1e-12)


def test_the_coarser_side_gives_way(plates):
    """A wrong jump is spread as h² on both sides."""
    sides = [side(plate, np.zeros((len(plate.cells), 2))) for plate in plates]
    x = sides[0].patches.centres
    fit = recover_heat_flux(*sides, thermal(x, NORMALS[0], dissipation=1.0))
    inner = slice(2, -2)
    own, other = -fit.standard.values[inner, 1], fit.extended.values[inner, 1]
    partner = closest(x, sides[1].patches.centres)[inner]
    ratio = sides[1].patches.sizes[partner] / sides[0].patches.sizes[inner]
    np.testing.assert_allclose(own + other, 1.0, atol=1e-7)
    assert np.abs(np.log(other / own) - 2 * np.log(ratio)).max() < np.log(3.0)
    assert other.mean() < own.mean()


def test_chosen_vertices_give_the_same(plates):
    sides = [side(plate, noise(plate, 2, k)) for k, plate in enumerate(plates)]
    state = thermal(sides[0].patches.centres, NORMALS[0], dissipation=2.0)
    some = np.array([7, 2, 3])
    whole, part = (recover_heat_flux(*sides, state, chosen) for chosen in (None, some))
    np.testing.assert_allclose(
        part.standard.coefficients, whole.standard.coefficients[some], atol=1e-13
    )
