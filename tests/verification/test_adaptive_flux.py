"""Estimated errors of heat flux in whole runs: two bodies that conduct and rub each other warm."""

from unittest.mock import patch

import numpy as np
import pytest
from verification.watched import subdivided, watch

from contactfem.adaptivity.estimators import FluxEstimator, total
from contactfem.adaptivity.recovery.norms import quadrature, squared_norms
from contactfem.case.read import read_case
from contactfem.fem.gathered_mesh import MeshView
from contactfem.heat.interface import HeatExchange
from contactfem.thermomechanics.interface_transfer import InterfaceLink
from contactfem.verification.manufactured import harmonic_bodies

K, CONDUCTANCE, SOURCE = (0.2, 50.0), 0.5, 3.0
BODIES = dict(zip(("below", "above"), harmonic_bodies(K, CONDUCTANCE, SOURCE), strict=True))
FUNCTIONS = """
from contactfem.verification.manufactured import harmonic_bodies

first, second = harmonic_bodies((0.2, 50.0), 0.5, 3.0)

def below(x, t):
    return first.theta(x)

def above(x, t):
    return second.theta(x)
"""
CASE = """
title = "Two bodies that rub"
mechanics = false
strain = "small"
time = { end = "1 s", step = "1 s" }
[heat]
scheme = "steady"
[interfaces.rub]
nonmortar = "below.top"
mortar = "above.bottom"
heat = { law = "constant", conductance = "0.5 W/m^2/K", pressure = "1 Pa" }
"""
BODY = """
[materials.{name}]
youngs_modulus = "1 Pa"
poisson_ratio = 0.0
conductivity = "{k} W/m/K"
[bodies.{name}]
material = "{name}"
mesh = {{ builder = "block", width = "1 m", height = "1 m", corner = ["0 m", "{low} m"], \
nx = {n}, ny = {n}, cell = "triangle" }}
"""


def rub(link, c, t, dt, ramp_end) -> HeatExchange:
    """Frictional heat d_0 cos πx, which no table over time can say."""
    nodes = link.heat.nodes
    d = SOURCE * np.cos(np.pi * nodes.mesh.X[: nodes.mesh.n_nonmortar, 0])
    return link.heat.exchange(nodes.mesh.X, np.ones_like(d), d, None)


def compare(folder, facets):
    """Effectivity, and errors of the flow through the interface with and without joining."""
    (folder / "exact.py").write_text(FUNCTIONS)
    text = CASE
    for name, k, low, n in zip(BODIES, K, (-1, 0), facets, strict=True):
        text += BODY.format(name=name, k=k, low=low, n=n)
        sides = ("left", "right", {"below": "bottom", "above": "top"}[name])
        for side in sides:
            text += f'[[conditions]]\non = "{name}.{side}"\ntemperature = "exact.py:{name}"\n'
    (folder / "case.toml").write_text(text)
    case, found = read_case(folder / "case.toml"), []

    def see(report, state, discretisation):
        estimator = FluxEstimator(case, discretisation)
        errors = estimator(state.theta, state.exchanges, report.t)
        square = 0.0
        for body, theta in zip(discretisation.heat.bodies, state.theta, strict=True):
            view = MeshView.of(discretisation.system.comm, body.mesh)
            body.theta.x.array[:] = theta
            points, cells, origin = subdivided(view.data.points, view.data.cells, 1)
            rule = quadrature(points, cells)
            exact = BODIES[body.name].flux(rule.x.reshape(-1, 2).T).T.reshape(rule.x.shape)
            flux = view.cells(body.flux_at(None).values())[origin]
            square += squared_norms(rule, exact - flux).sum() / body.law.conductivity
        found.append(total(errors).error / np.sqrt(square))

    with patch.object(InterfaceLink, "exchange", rub):
        watch(case, see)
    return found[0]


@pytest.mark.parametrize("ratio", [(1, 1), (2, 3), (3, 2), (1, 4)])
def test_effectivity(tmp_path, ratio):
    found = [compare(tmp_path, [r * n for r in ratio]) for n in (8, 16, 32)]
    assert np.all(np.abs(np.array(found) - 1.0) < 0.03)
