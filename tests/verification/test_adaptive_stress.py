"""Estimated errors of stress in whole runs against closed forms of wavy and of round contact."""

import numpy as np
import pytest
from verification.conftest import CASES
from verification.watched import stress_error, watch
from verification.westergaard_stress import WavyContact

from contactfem.case import read_case
from contactfem.estimate import StressEstimator, total

E, NU, WAVE, AMPLITUDE = 200e6, 0.3, 2e-3, 1e-7  # slopes of 3e-4: the linear theory
FULL = np.pi * E / (2.0 * (1.0 - NU**2)) * AMPLITUDE / WAVE
TRIANGLES = ('bodies.wavy.mesh.cell="triangle"', 'bodies.flat.mesh.cell="triangle"')


def effectivity(case, exact):
    """Estimated over true error of the only step, and the true relative error."""
    found = []

    def compare(report, state, discretisation):
        estimated = total(StressEstimator(case, discretisation)(state.conditions, report.t))
        true = np.sum(list(stress_error(case, discretisation, exact).values()), axis=0)
        found.append((estimated.error / np.sqrt(true[0]), np.sqrt(true[0] / true[1])))

    watch(case, compare)
    return found[0]


def wavy(pressure, facets, *overrides):
    """Bodies one and a half wave lengths deep, so that nothing of the wave is left there."""
    given = [f'bodies.wavy.mesh.amplitude="{AMPLITUDE} m"']
    given += [f'conditions.0.traction.y="-{pressure} Pa"']
    given += ['bodies.flat.mesh.corner=["0 mm", "-3 mm"]']
    for body, n in zip(("wavy", "flat"), facets, strict=True):
        given += [f"bodies.{body}.mesh.n{axis}={n}" for axis in "xy"]
        given += [f'bodies.{body}.mesh.height="3 mm"']
    return read_case(CASES / "westergaard.toml", [*given, *overrides])


def test_westergaards_function():
    """Pressures of the closed form at the surface, and equilibrium inside by differences."""
    for share in (0.3, 1.2):
        solution = WavyContact(share * FULL, FULL, WAVE, NU)
        x = np.array([[0.0, 1e-15], [0.3e-3, 0.2e-3]])
        p0 = 2.0 * share * FULL / solution.edge if share < 1.0 else (share + 1.0) * FULL
        assert -solution.stress("", x)[0, 1] == pytest.approx(p0, rel=1e-6)
        h = 1e-8
        shift = h * np.eye(2)
        up, down = (solution.stress("", x[1] + sign * shift) for sign in (1, -1))
        dx, dy = (up - down) / (2.0 * h)
        scale = FULL / WAVE
        assert abs(dx[0] + dy[3]) < 1e-6 * scale
        assert abs(dx[3] + dy[1]) < 1e-6 * scale
        assert abs(dx[0]) > 0.05 * scale


@pytest.mark.parametrize(
    ("pressure", "ratio", "overrides", "room"),
    [
        pytest.param(1.2, (1, 1), (), 0.1, id="full"),
        pytest.param(1.2, (1, 1), TRIANGLES, 0.1, id="full, triangles"),
        pytest.param(1.2, (1.5, 1), (), 0.1, id="full, nonmortar finer"),
        pytest.param(1.2, (1, 1.5), TRIANGLES, 0.1, id="full, mortar finer"),
        pytest.param(0.3, (1, 1), (), 0.12, id="partial"),
    ],
)
def test_wavy_contact(pressure, ratio, overrides, room):
    exact = WavyContact(pressure * FULL, FULL, WAVE, NU).stress
    found = []
    for n in (16, 32, 64):
        facets = [round(r * n) for r in ratio]
        found.append(effectivity(wavy(pressure * FULL, facets, *overrides), exact))
    effectivities, errors = np.array(found).T
    assert np.all(np.abs(effectivities - 1.0) < room)
    assert np.abs(effectivities[-1] - 1.0) < 0.02  # it comes closer with the mesh
    assert np.log2(errors[0] / errors[-1]) / 2 > 0.95


def lame(body, x):
    """Stress of the interference fit at the pressure p: uniform in the core, Lamé's in the ring."""
    p, a, b, nu = 0.47021944e6, 10e-3, 20e-3, 0.45
    r = np.hypot(x[..., 0], x[..., 1])
    c, s = x[..., 0] / r, x[..., 1] / r
    f = p * a**2 / (b**2 - a**2)
    rr, tt = f * (1.0 - b**2 / r**2), f * (1.0 + b**2 / r**2)
    if body == "core":
        rr = tt = np.full_like(r, -p)
    return np.stack(
        (rr * c**2 + tt * s**2, rr * s**2 + tt * c**2, nu * (rr + tt), (rr - tt) * c * s), -1
    )


@pytest.mark.parametrize("ratio", [(3, 4), (4, 4)])
def test_shrink_fit(ratio):
    """Nearly all of the error is that of the ring, whose facets do not match those of the core."""
    for n in (16, 32):
        core, ring = (f"bodies.{body}.mesh." for body in ("core", "ring"))
        facets = [f"{core}facets={ratio[0] * n}", f"{ring}facets={ratio[1] * n}"]
        layers = [f"{core}layers={6 * n // 16}", f"{ring}layers={8 * n // 16}"]
        case = read_case(CASES / "shrink_fit.toml", facets + layers)
        assert abs(effectivity(case, lame)[0] - 1.0) < 0.03
