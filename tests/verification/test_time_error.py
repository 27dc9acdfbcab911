"""Errors of space and time on a moving heat source: a Gaussian that goes round the unit square."""

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg
from verification.p1_conduction import jittered

from contactfem.adaptivity.recovery.norms import (
    quadrature,
    relative_error,
    squared_errors,
    squared_norms,
)
from contactfem.adaptivity.recovery.patches import patches
from contactfem.adaptivity.recovery.time import time_error

CAPACITY, CONDUCTIVITY, PEAK, WIDTH, RADIUS, TURN = 2.0, 0.2, 100.0, 0.1, 0.25, 2.0 * np.pi
GAUSS = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)


def offset(x, t):
    """Distance from the centre of the source, and its velocity."""
    turn = np.array([np.cos(TURN * t), np.sin(TURN * t)])
    return x - 0.5 - RADIUS * turn, RADIUS * TURN * np.array([-turn[1], turn[0]])


def temperature(x, t):
    return PEAK * np.exp(-(offset(x, t)[0] ** 2).sum(-1) / WIDTH**2)


def gradient(x, t):
    return -2.0 * offset(x, t)[0] / WIDTH**2 * temperature(x, t)[..., None]


def rate(x, t):
    d, velocity = offset(x, t)
    return 2.0 * (d @ velocity) / WIDTH**2 * temperature(x, t)


def source(x, t):
    square = (offset(x, t)[0] ** 2).sum(-1) / WIDTH**2
    laplacian = (4.0 * square - 4.0) / WIDTH**2 * temperature(x, t)
    return CAPACITY * rate(x, t) - CONDUCTIVITY * laplacian


def test_the_source_is_that_of_the_benchmark():
    x = np.array([0.6, 0.55])
    assert abs(temperature(x, 0.13) - 10.489002) < 1e-6
    assert abs(source(x, 0.13) + 1307.81283) < 1e-5
    np.testing.assert_allclose(gradient(x, 0.13), [149.230759, 277.417651], rtol=1e-8)


class Moving:
    """cG(1) in time: C (z_n - z_(n-1))/h + K (z_n + z_(n-1))/2 = F at two Gauss points."""

    def __init__(self, n, dt, steps):
        self.plate, self.dt = jittered((n, n), conductivity=CONDUCTIVITY, jitter=0.1), dt
        points, cells = self.plate.points, self.plate.cells
        self.rule = quadrature(points, cells)
        local = np.einsum("mq,qi,qj->mij", self.rule.weights, self.rule.shapes, self.rule.shapes)
        entries = (cells.repeat(3, 1).ravel(), np.tile(cells, (1, 3)).ravel())
        self.mass = sp.coo_matrix((local.ravel(), entries), (len(points),) * 2).tocsr()
        held = np.unique(np.concatenate([self.plate.at_edge(a, b) for a in (0, 1) for b in (0, 1)]))
        free = np.setdiff1d(np.arange(len(points)), held)
        K, C = self.plate.stiffness(), CAPACITY * self.mass
        left = (C / dt + K / 2).tocsr()
        solve = scipy.sparse.linalg.factorized(left[free][:, free].tocsc())
        self.z = [temperature(points, 0.0)]
        for k in range(steps):
            load = sum(self.load((k + g) * dt) / 2 for g in GAUSS) + (C / dt - K / 2) @ self.z[-1]
            new = temperature(points, (k + 1) * dt)
            new[free] = solve((load - left[:, held] @ new[held])[free])
            self.z.append(new)

    def load(self, t):
        result = np.zeros(len(self.plate.points))
        values = (self.rule.weights * source(self.rule.x, t)) @ self.rule.shapes
        np.add.at(result, self.plate.cells, values)
        return result

    def time_effectivity(self):
        """Indicated over true error of the last step in the norm of the mass matrix."""
        older, newer = (np.subtract(*self.z[i : i - 2 : -1]) / self.dt for i in (-2, -1))
        change = newer - older
        estimate = time_error(
            change @ self.mass @ change, newer @ self.mass @ newer, self.dt, self.dt
        )
        nodes, weights = np.polynomial.legendre.leggauss(5)
        start, square = (len(self.z) - 2) * self.dt, 0.0
        for s, w in zip(nodes, weights, strict=True):
            off = rate(self.plate.points, start + (s + 1) / 2 * self.dt) - newer
            square += w / 2 * self.dt * (off @ self.mass @ off)
        return estimate.error / np.sqrt(square)

    def space_effectivity(self):
        """Estimated over true error of the heat flux at the end."""
        plate, end = self.plate, (len(self.z) - 1) * self.dt
        discrete = plate.flux(self.z[-1])
        nodal = patches(plate.points, plate.cells).fit(discrete)[:, 0]
        norms = squared_norms(self.rule, discrete)
        estimate = relative_error(squared_errors(self.rule, plate.cells, nodal, discrete), norms)
        off = -CONDUCTIVITY * gradient(self.rule.x, end) - discrete[:, None, :]
        return estimate.error / relative_error(squared_norms(self.rule, off), norms).error


@pytest.mark.parametrize("dt", [0.02, 0.01])
def test_effectivity_in_time(dt):
    assert Moving(64, dt, 4).time_effectivity() == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("n", [32, 48])
def test_effectivity_in_space(n):
    assert Moving(n, 0.005, 10).space_effectivity() == pytest.approx(1.0, abs=0.1)
