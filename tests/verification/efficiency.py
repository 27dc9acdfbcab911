"""True errors of a run whose temperature is known, beside those that it indicated."""

from dataclasses import dataclass, field

import numpy as np
from verification.watched import subdivided, vertex_temperatures

from contactfem.adaptivity.recovery.norms import quadrature

NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)  # of a step in time


def flux_error(discretisation, state, gradient, times=1):
    """True squares of the error and norm of the heat flux, of all bodies; gradient(x (2, n), t)."""
    total = np.zeros(2)
    for (data, theta), body in zip(
        vertex_temperatures(discretisation, state), discretisation.heat.bodies, strict=True
    ):
        slopes = _slopes(data.points, data.cells)
        flux = -np.einsum("mvi,mv->mi", slopes, theta[data.cells, 0])
        points, cells, origin = subdivided(data.points, data.cells, times)
        rule = quadrature(points, cells)
        exact = -gradient(rule.x.reshape(-1, 2).T, state.t).T.reshape(rule.x.shape)
        k = body.law.conductivity
        for part, values in enumerate((exact - flux[origin][:, None], exact)):
            total[part] += k * np.sum(rule.weights * np.sum(values**2, axis=-1))
    return total


def _slopes(points, cells):
    """Gradients of the three shape functions of triangles, (m, 3, 2)."""
    a, b, c = points[cells].transpose(1, 0, 2)
    opposite = np.stack((c - b, a - c, b - a), axis=1)
    (x1, y1), (x2, y2) = (b - a).T, (c - a).T
    return np.stack((-opposite[..., 1], opposite[..., 0]), -1) / (x1 * y2 - y1 * x2)[:, None, None]


def rate_error(discretisation, state, theta, t, dt, capacity):
    """True squares ∫ <e, e> dt and ∫ <ż, ż> dt of the rate in the last step, at the vertices.

    e = ż - (z(t) - z(t - dt))/dt of the exact temperature at the vertices, so that no error in
    space counts; with the mass matrix as the norm.
    """
    total = np.zeros(2)
    for data, _ in vertex_temperatures(discretisation, state):
        x, h = data.points.T, 1e-6
        mean = (theta(x, t) - theta(x, t - dt)) / dt
        lumped = _lumped(data) * capacity
        for node, weight in zip(NODES, WEIGHTS, strict=True):
            at = t - 0.5 * dt + 0.5 * dt * node
            rate = (theta(x, at + h) - theta(x, at - h)) / (2.0 * h)
            for part, values in enumerate((rate - mean, rate)):
                total[part] += 0.5 * dt * weight * (lumped @ values**2)
    return total


def _lumped(data):
    """∫ N_i dA of triangles or quadrilaterals."""
    weights = quadrature(data.points, data.cells).weights.sum(axis=1)
    share = np.repeat(weights / data.cells.shape[1], data.cells.shape[1])
    return np.bincount(data.cells.ravel(), share, len(data.points))


@dataclass
class Efficiency:
    """Watches a run: indicated and true relative errors of every step.

    `solution` has theta(x, t) and gradient(x, t); `capacity` is ρc [J/m³/K].
    """

    solution: object
    capacity: float
    t: list = field(default_factory=list)
    dt: list = field(default_factory=list)
    cells: list = field(default_factory=list)
    vertices: list = field(default_factory=list)
    space: list = field(default_factory=list)  # (indicated, true)
    time: list = field(default_factory=list)

    def __call__(self, report, state, discretisation):
        data = vertex_temperatures(discretisation, state)[0][0]
        self.t.append(report.t)
        self.dt.append(report.dt)
        self.cells.append(len(data.cells))
        self.vertices.append(len(data.points))
        errors = report.errors
        if data.cells.shape[1] == 3:
            error, norm = flux_error(discretisation, state, self.solution.gradient)
            indicated = errors.heat if errors is not None else np.nan
            self.space.append((indicated, np.sqrt(error / norm)))
        error, norm = rate_error(
            discretisation, state, self.solution.theta, report.t, report.dt, self.capacity
        )
        indicated = errors.time if errors is not None and errors.time else np.nan
        self.time.append((indicated, np.sqrt(error / norm) if norm > 0.0 else np.nan))
