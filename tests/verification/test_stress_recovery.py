"""Recovered stresses of two elastic bodies in full wavy contact, against the closed form."""

from dataclasses import dataclass

import numpy as np
import pytest
import scipy.sparse as sp
from verification.p1_conduction import Plate, jittered, solve

from contactfem.adaptivity.recovery.constraints import traction_rows
from contactfem.adaptivity.recovery.interface import MechanicalState, Side, recover_stress
from contactfem.adaptivity.recovery.norms import (
    elastic_compliance,
    quadrature,
    squared_errors,
    squared_norms,
)
from contactfem.adaptivity.recovery.patches import patches
from contactfem.meshes.polygon import Edge, triangulate

WAVE, AMPLITUDE = np.pi, 2.0  # p = 2 cos πx at y = 0, without friction
REFINEMENTS = (8, 16, 32)


@dataclass(frozen=True)
class Body:
    """A linear elastic half space in plane strain, cut out as a square below or above y = 0."""

    plate: Plate
    side: int  # 1 above, -1 below
    E: float
    nu: float

    @property
    def mu(self):
        return self.E / (2.0 * (1.0 + self.nu))

    def displacement(self, x):
        """u = p/(2μk) e^(-k|y|) ((2ν - 1 + k|y|) sin kx, ±(2 - 2ν + k|y|) cos kx)."""
        a, y = WAVE * x[..., 0], WAVE * np.abs(x[..., 1])
        size = AMPLITUDE / (2.0 * self.mu * WAVE) * np.exp(-y)
        return np.stack(
            (
                size * (2 * self.nu - 1 + y) * np.sin(a),
                self.side * size * (2 - 2 * self.nu + y) * np.cos(a),
            ),
            -1,
        )

    def stress(self, x):
        """σ = -p e^(-k|y|) ((1 - k|y|) cos, (1 + k|y|) cos, 2ν cos, ±k|y| sin) of kx."""
        a, y = WAVE * x[..., 0], WAVE * np.abs(x[..., 1])
        size = -AMPLITUDE * np.exp(-y)
        xx, yy = size * (1 - y) * np.cos(a), size * (1 + y) * np.cos(a)
        return np.stack((xx, yy, self.nu * (xx + yy), self.side * size * y * np.sin(a)), -1)

    def samples(self):
        """Discrete stresses with exact displacements on all edges."""
        slopes, area = self.plate.shapes()
        B = np.zeros((len(area), 4, 6))
        B[:, 0, 0::2], B[:, 1, 1::2] = slopes[..., 0], slopes[..., 1]
        B[:, 3, 0::2], B[:, 3, 1::2] = slopes[..., 1], slopes[..., 0]
        lame = 2 * self.mu * self.nu / (1 - 2 * self.nu)
        C = np.diag([2.0, 2.0, 2.0, 1.0]) * self.mu
        C[:3, :3] += lame
        dofs = (2 * self.plate.cells[:, :, None] + [0, 1]).reshape(-1, 6)
        local = area[:, None, None] * B.transpose(0, 2, 1) @ C @ B
        entries = (dofs.repeat(6, 1).ravel(), np.tile(dofs, (1, 6)).ravel())
        n = len(self.plate.points)
        matrix = sp.coo_matrix((local.ravel(), entries), (2 * n, 2 * n)).tocsr()
        edges = [(0, 0.0), (0, 1.0), (1, 0.0), (1, float(self.side))]
        outside = np.unique(np.concatenate([self.plate.at_edge(*edge) for edge in edges]))
        held = (2 * outside[:, None] + [0, 1]).ravel()
        exact = self.displacement(self.plate.points).ravel()
        u = solve(matrix, np.zeros(2 * n), held, exact[held])
        return np.einsum("mij,mj->mi", C @ B, u[dofs])


def frontal(y, facets):
    corners = [(0.0, y), (1.0, y), (1.0, y + 1.0), (0.0, y + 1.0)]
    edges = [Edge(corners[i], corners[(i + 1) % 4], (str(i),), fine=True) for i in range(4)]
    mesh = triangulate(edges, 1.0 / facets, 1e-3, 1.0 / facets)
    return Plate(mesh.points, mesh.cells)


class Solved:
    """Both bodies with other meshes and moduli, and what recovery makes of their stresses."""

    def __init__(self, n):
        self.bodies = (
            Body(frontal(-1.0, n), -1, 1.0e3, 0.3),
            Body(frontal(0.0, round(1.5 * n)), 1, 2.0e4, 0.2),
        )
        self.samples = [body.samples() for body in self.bodies]
        self.sides = []
        for body, samples in zip(self.bodies, self.samples, strict=True):
            fits = patches(body.plate.points, body.plate.cells, body.plate.at_edge(1, 0.0))
            self.sides.append(Side(fits, fits.fit(samples)))

    def state(self, k, frictionless):
        n = len(self.sides[k].patches.vertices)
        normals = np.tile([0.0, (1.0, -1.0)[k]], (n, 1))
        everywhere = np.ones(n, bool)
        return MechanicalState(normals, everywhere, frictionless & everywhere)

    def joint(self, k, frictionless=True):
        return recover_stress(self.sides[k], self.sides[1 - k], self.state(k, frictionless))

    def error(self, values):
        """L2 error of the traction on both sides, away from the corners."""
        square = 0.0
        for k, (body, side) in enumerate(zip(self.bodies, self.sides, strict=True)):
            x = side.patches.centres
            inner = (x[:, 0] > 0.1) & (x[:, 0] < 0.9)
            off = (values[k] - body.stress(x))[inner][:, [1, 3]]
            square += np.trapezoid((off**2).sum(1), x[inner, 0])
        return np.sqrt(square)

    def effectivity(self):
        """Estimated over true error in the norm of the complementary energy."""
        estimated = true = 0.0
        for k, body in enumerate(self.bodies):
            plate, discrete = body.plate, self.samples[k]
            nodal = patches(plate.points, plate.cells).fit(discrete)[:, 0]
            nodal[self.sides[k].patches.vertices] = self.joint(k).standard.values
            rule, metric = (
                quadrature(plate.points, plate.cells),
                elastic_compliance(body.E, body.nu),
            )
            estimated += squared_errors(rule, plate.cells, nodal, discrete, metric).sum()
            true += squared_norms(rule, body.stress(rule.x) - discrete[:, None, :], metric).sum()
        return np.sqrt(estimated / true)


@pytest.fixture(scope="module")
def solved():
    return [Solved(n) for n in REFINEMENTS]


def test_the_closed_form_is_elastic_and_in_equilibrium():
    """By differences: σ = C ε(u), div σ = 0, and no shear at the interface."""
    h, x = 1e-5, np.array([[0.3, 0.2], [0.8, 0.05]])
    for side in (1, -1):
        body, at = Body(jittered((2, 2)), side, 1.0e3, 0.3), x * [1, side]
        du, ds = (
            np.stack([(f(at + h * e) - f(at - h * e)) / (2 * h) for e in np.eye(2)], -1)
            for f in (body.displacement, body.stress)
        )
        lame = 2 * body.mu * body.nu / (1 - 2 * body.nu)
        volume = lame * (du[:, 0, 0] + du[:, 1, 1])
        expected = np.column_stack(
            (
                2 * body.mu * du[:, 0, 0] + volume,
                2 * body.mu * du[:, 1, 1] + volume,
                volume,
                body.mu * (du[:, 0, 1] + du[:, 1, 0]),
            )
        )
        np.testing.assert_allclose(body.stress(at), expected, atol=1e-7)
        assert np.abs(ds[:, 0, 0] + ds[:, 3, 1]).max() < 1e-6
        assert np.abs(ds[:, 3, 0] + ds[:, 1, 1]).max() < 1e-6
        assert np.abs(body.stress(x * [1, 0])[:, 3]).max() == 0.0


def test_tractions_are_continuous(solved):
    for case in solved:
        for k in (0, 1):
            rows = traction_rows(case.state(k, True).normals)
            for frictionless in (False, True):
                fit = case.joint(k, frictionless)
                own, other = (
                    np.einsum("krc,kc->kr", rows, side.values)
                    for side in (fit.standard, fit.extended)
                )
                assert np.abs(own - other)[:, 0].max() < 1e-6
                shear = own if frictionless else own - other
                assert np.abs(shear[:, 1]).max() < 1e-6


@pytest.mark.parametrize(("frictionless", "order"), [(False, 1.4), (True, 1.7)])
def test_tractions_at_the_interface(solved, frictionless, order):
    """Half the error without conditions, at least; the shear is known to be 0 without friction."""
    found, without = [], []
    for case in solved:
        values = [case.joint(k, frictionless).standard.values for k in (0, 1)]
        found.append(case.error(values))
        without.append(case.error([side.coefficients[:, 0] for side in case.sides]))
    orders = np.log2(found[0] / found[-1]) / (len(found) - 1)
    assert orders > order
    assert (2.0 * np.array(found) < without).all()


def test_effectivity(solved):
    found = [case.effectivity() for case in solved]
    assert all(0.9 < value < 1.1 for value in found)
