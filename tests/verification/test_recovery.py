"""Recovered heat fluxes of discrete solutions against exact ones: rates, jumps, effectivity."""

import numpy as np
import pytest
from verification.p1_conduction import Joint, Plate, jittered, solve

from contactfem.adaptivity.recovery.constraints import ConstraintRows, with_conditions
from contactfem.adaptivity.recovery.interface import Side, ThermalState, recover_heat_flux
from contactfem.adaptivity.recovery.norms import quadrature, squared_errors, squared_norms
from contactfem.adaptivity.recovery.patches import patches
from contactfem.meshes.polygon import Edge, triangulate

K, CONDUCTANCE, SOURCE = (0.2, 50.0), 0.5, 3.0
REFINEMENTS = (8, 16, 32)
MESHES = [
    (1.0, 1.5),
    (1.5, 1.0),
    (1.0, 1.125),
    (1.0, 4.0),
]  # facets on both sides, times refinement


def amplitudes():
    """Q_k of q_k = Q_k exp(-π|y|) (sin πx, ∓cos πx), from q_1 = h [T] - d/2, q_2 = h [T] + d/2.

    Temperatures at the interface are ∓Q/(kπ) of the heat that leaves it: T_k = Q_k/(k_k π) cos πx,
    Q_1 = d/2 - h D and Q_2 = d/2 + h D for the jump D = T_1 - T_2.
    """
    resistances = [1.0 / (k * np.pi) for k in K]
    D = 0.5 * SOURCE * (resistances[0] - resistances[1]) / (1.0 + CONDUCTANCE * sum(resistances))
    return 0.5 * SOURCE - CONDUCTANCE * D, 0.5 * SOURCE + CONDUCTANCE * D


def temperature(body, x, y):
    return amplitudes()[body] / (K[body] * np.pi) * np.cos(np.pi * x) * np.exp(-np.pi * np.abs(y))


def flux(body, x, y):
    size = amplitudes()[body] * np.exp(-np.pi * np.abs(y))
    return np.stack((size * np.sin(np.pi * x), (-1, 1)[body] * size * np.cos(np.pi * x)), -1)


def dissipation(x):
    return SOURCE * np.cos(np.pi * x)


def frontal(corner, facets, conductivity):
    """Unit square as the program meshes it."""
    x, y = corner
    corners = [(x, y), (x + 1.0, y), (x + 1.0, y + 1.0), (x, y + 1.0)]
    edges = [Edge(corners[i], corners[(i + 1) % 4], (str(i),), fine=True) for i in range(4)]
    mesh = triangulate(edges, 1.0 / facets, 1e-3, 1.0 / facets)
    return Plate(mesh.points, mesh.cells, conductivity)


def one_sided(plate, samples, vertices):
    """(36) without conditions: least squares over the cells around boundary vertices alone."""
    result = []
    for vertex in vertices:
        cells = np.flatnonzero((plate.cells == vertex).any(1))
        offset = plate.points[plate.cells[cells]].mean(1) - plate.points[vertex]
        P = np.column_stack((np.ones(len(cells)), offset))
        result.append(np.linalg.lstsq(P, samples[cells], rcond=None)[0][0])
    return np.array(result)


class Solved:
    """The two bodies, their discrete fluxes, and what recovery makes of them."""

    def __init__(self, facets):
        self.plates = [
            frontal(corner, n, k)
            for corner, n, k in zip([(0.0, -1.0), (0.0, 0.0)], facets, K, strict=True)
        ]
        solutions = Joint(*self.plates, CONDUCTANCE, dissipation).solve(temperature)
        self.samples = [p.flux(T) for p, T in zip(self.plates, solutions, strict=True)]
        self.edges = [plate.at_edge(1, 0.0) for plate in self.plates]
        self.sides = []
        for plate, samples, edge in zip(self.plates, self.samples, self.edges, strict=True):
            fits = patches(plate.points, plate.cells, edge)
            self.sides.append(Side(fits, fits.fit(samples)))

    def joint(self, k):
        x = self.sides[k].patches.centres[:, 0]
        everywhere = np.ones(len(x), bool)
        normals = np.tile([0.0, (1.0, -1.0)[k]], (len(x), 1))
        state = ThermalState(normals, everywhere, dissipation(x), 0.0 * x)
        return recover_heat_flux(self.sides[k], self.sides[1 - k], state)

    def error(self, values):
        """L2 error of q·n along both sides, away from the corners."""
        square = 0.0
        for k, side in enumerate(self.sides):
            x = side.patches.centres[:, 0]
            inner = (x > 0.1) & (x < 0.9)
            off = (values[k] - flux(k, x, 0.0 * x))[:, 1]
            square += np.trapezoid(off[inner] ** 2, x[inner])
        return np.sqrt(square)

    def effectivity(self):
        """Estimated over true error in the energy norm of both bodies."""
        estimated = true = 0.0
        for k, plate in enumerate(self.plates):
            nodal = patches(plate.points, plate.cells).fit(self.samples[k])[:, 0]
            nodal[self.edges[k]] = self.joint(k).standard.values
            rule, metric = quadrature(plate.points, plate.cells), np.eye(2) / K[k]
            discrete = self.samples[k]
            estimated += squared_errors(rule, plate.cells, nodal, discrete, metric).sum()
            off = flux(k, rule.x[..., 0], rule.x[..., 1]) - discrete[:, None, :]
            true += squared_norms(rule, off, metric).sum()
        return np.sqrt(estimated / true)


@pytest.fixture(scope="module")
def solved():
    """Solutions on all refinements, made once for each pair of meshes."""
    kept = {}

    def get(ratios):
        if ratios not in kept:
            kept[ratios] = [Solved([round(r * n) for r in ratios]) for n in REFINEMENTS]
        return kept[ratios]

    return get


def hot_square(plate):
    """T_h of T = e^x sin y: zero load, exact values on all edges."""
    x, y = plate.points.T
    outside = np.unique(np.concatenate([plate.at_edge(a, v) for a in (0, 1) for v in (0.0, 1.0)]))
    exact = np.exp(x) * np.sin(y)
    return solve(plate.stiffness(), np.zeros(len(x)), outside, exact[outside])


def hot_flux(x):
    return -np.exp(x[..., :1]) * np.stack((np.sin(x[..., 1]), np.cos(x[..., 1])), -1)


def errors_of_recovery(plate):
    """Errors of recovered values away from the boundary, of cells, of the smooth field."""
    samples = plate.flux(hot_square(plate))
    inner = (np.abs(plate.points - 0.5) < 0.3).all(1)
    nodal = patches(plate.points, plate.cells).fit(samples)[:, 0]
    off = nodal[inner] - hot_flux(plate.points[inner])
    rule = quadrature(plate.points, plate.cells)
    exact = hot_flux(rule.x)
    raw = squared_norms(rule, exact - samples[:, None, :]).sum()
    smooth = squared_norms(rule, exact - rule.shapes @ nodal[plate.cells]).sum()
    return np.sqrt([(off**2).sum(1).mean(), raw, smooth])


@pytest.mark.parametrize(("name", "least"), [("regular", (1.95, 1.5)), ("frontal", (1.9, 1.5))])
def test_recovered_values_superconverge(name, least):
    """At vertices, and in the mean with the boundary; values in cells are of order 1."""

    def plate(n):
        if name == "regular":
            return jittered((n, n), jitter=0.0)
        return frontal((0.0, 0.0), n, 1.0)

    errors = np.array([errors_of_recovery(plate(n)) for n in (12, 24, 48)])
    orders = np.log2(errors[0] / errors[-1]) / 2
    assert 0.9 < orders[1] < 1.1
    assert orders[0] > least[0]
    assert orders[2] > least[1]


@pytest.mark.parametrize("n", [12, 24, 48])
def test_irregular_meshes_keep_a_tenth_of_the_error(n):
    """Meshes disturbed at random do not superconverge, but errors still cancel."""
    at_vertices, raw, smooth = errors_of_recovery(jittered((n, n), jitter=0.2, seed=5))
    assert at_vertices < 0.1 * raw
    assert smooth < 0.1 * raw


def test_known_heat_flow_improves_the_boundary():
    """A given q·n is met; the component along the edge stays as it was recovered."""
    plate = jittered((24, 24), seed=5)
    samples = plate.flux(hot_square(plate))
    edge = plate.at_edge(1, 0.0)
    fits = patches(plate.points, plate.cells)
    a = fits.fit(samples)
    exact = hot_flux(plate.points[edge])
    normals = np.tile([0.0, -1.0], (len(edge), 1))
    known = ConstraintRows(edge, normals, (exact * normals).sum(1))
    off = [np.abs(c[edge, 0] - exact).max(0) for c in (a, with_conditions(fits, a, known))]
    assert off[1][1] < 1e-6 < 1e-3 < off[0][1]
    assert off[1][0] == pytest.approx(off[0][0], rel=1e-6)


def test_the_exact_solution_balances_heat():
    x = np.array([0.2, 0.7])
    below, above = flux(0, x, 0 * x)[:, 1], flux(1, x, 0 * x)[:, 1]
    np.testing.assert_allclose(above - below, dissipation(x), rtol=1e-13)
    passed = CONDUCTANCE * (temperature(0, x, 0 * x) - temperature(1, x, 0 * x))
    np.testing.assert_allclose(below, passed - dissipation(x) / 2, rtol=1e-13)
    np.testing.assert_allclose(flux(0, 0.2, -0.1), [0.36025280, -0.49584545], rtol=1e-7)
    np.testing.assert_allclose(flux(1, 0.2, 0.1), [0.92770699, 1.27687912], rtol=1e-7)


@pytest.mark.parametrize("ratios", MESHES)
def test_recovered_fluxes_jump_by_the_dissipation(solved, ratios):
    for case in solved(ratios):
        for k, outward in enumerate((1.0, -1.0)):
            fit = case.joint(k)
            jump = outward * (fit.standard.values - fit.extended.values)[:, 1]
            x = case.sides[k].patches.centres[:, 0]
            assert np.abs(jump + dissipation(x)).max() < 1e-6


@pytest.mark.parametrize("ratios", MESHES)
def test_flux_at_the_interface(solved, ratios):
    """Order 1.5 at least; far better than one-sided patches, better than without conditions."""
    found, without, classical = [], [], []
    for case in solved(ratios):
        found.append(case.error([case.joint(k).standard.values for k in (0, 1)]))
        without.append(case.error([side.coefficients[:, 0] for side in case.sides]))
        classical.append(
            case.error(
                [
                    one_sided(*args)
                    for args in zip(case.plates, case.samples, case.edges, strict=True)
                ]
            )
        )
    orders = np.log2(found[0] / found[-1]) / (len(found) - 1)
    assert orders > 1.5
    assert (5.0 * np.array(found) < classical).all()
    assert (1.2 * np.array(found) < without).all()


@pytest.mark.parametrize("ratios", MESHES)
def test_effectivity(solved, ratios):
    found = [case.effectivity() for case in solved(ratios)]
    assert all(0.9 < value < 1.1 for value in found)
