"""Estimated errors of stress in whole runs against closed forms of wavy and of round contact."""

import numpy as np
import pytest
from verification.conftest import CASES
from verification.watched import stress_error, watch
from verification.westergaard_stress import WavyContact

from contactfem.adaptivity.estimators import StressEstimator, total
from contactfem.case.read import read_case
from contactfem.results.measures import measure

E, NU, WAVE, AMPLITUDE = 200e6, 0.3, 2e-3, 1e-7  # slopes of 3e-4: the linear theory
FULL = np.pi * E / (2.0 * (1.0 - NU**2)) * AMPLITUDE / WAVE
TRIANGLES = ('bodies.wavy.mesh.cell="triangle"', 'bodies.flat.mesh.cell="triangle"')


def run(case, exact):
    """Of the only step: estimated over true error, true relative error; and the result."""
    found = []

    def compare(report, state, discretisation):
        estimated = total(StressEstimator(case, discretisation)(state.conditions, report.t))
        true = np.sum(list(stress_error(case, discretisation, exact).values()), axis=0)
        found.append((estimated.error / np.sqrt(true[0]), np.sqrt(true[0] / true[1])))

    result = watch(case, compare)
    return *found[0], result


def wavy(pressure, facets, *overrides):
    """Bodies one and a half wave lengths deep, so that nothing of the wave is left there."""
    given = [f'bodies.wavy.mesh.amplitude="{AMPLITUDE} m"']
    given += [f'conditions.0.traction.y="-{pressure} Pa"']
    given += [f'closed_form.contact.parameters.mean_pressure="{pressure} Pa"']
    given += [f'closed_form.contact.parameters.amplitude="{AMPLITUDE} m"']
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
        found.append(run(wavy(pressure * FULL, facets, *overrides), exact)[:2])
    effectivities, errors = np.array(found).T
    assert np.all(np.abs(effectivities - 1.0) < room)
    assert np.abs(effectivities[-1] - 1.0) < 0.02  # it comes closer with the mesh
    assert np.log2(errors[0] / errors[-1]) / 2 > 0.95


@pytest.mark.parametrize("tolerance", [0.1, 0.05, 0.02, pytest.param(0.01, marks=pytest.mark.slow)])
def test_the_error_asked_for(tolerance):
    """The true error is within the tolerance, and not far within."""
    exact = WavyContact(0.3 * FULL, FULL, WAVE, NU).stress
    case = wavy(0.3 * FULL, (8, 8), f"adaptivity.tolerance={tolerance}")
    ratio, true, result = run(case, exact)
    assert 0.7 * tolerance < true < tolerance
    assert ratio == pytest.approx(1.0, abs=0.02)
    assert result.steps[0].errors.mechanics < tolerance


def test_pressures_of_adapted_meshes():
    """Less than half of the error in L2 that an even mesh of as many unknowns leaves.

    In the mean over loads: it depends on where between two nodes the edge of contact lies.
    """
    adapted, even = [], []
    for share in (0.25, 0.29, 0.33, 0.37):
        exact = WavyContact(share * FULL, FULL, WAVE, NU).stress
        case = wavy(share * FULL, (8, 8), "adaptivity.tolerance=0.02")
        adapted.append(pressure_error(run(case, exact)[2]))
        grading = [f"bodies.{body}.mesh.grading=[1, 1]" for body in ("wavy", "flat")]
        deep = [f"bodies.{body}.mesh.ny=96" for body in ("wavy", "flat")]
        even.append(pressure_error(run(wavy(share * FULL, (32, 32), *grading, *deep), exact)[2]))
    (unknowns, error), (unknowns0, error0) = np.mean(adapted, axis=0), np.mean(even, axis=0)
    assert unknowns == pytest.approx(unknowns0, rel=0.1)
    assert error < 0.5 * error0


def pressure_error(result):
    """Unknowns, and the error of the pressure in L2 over its norm."""
    return result.sizes["unknowns"], measure(result)["contact.pressure_error_l2"]


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
        assert abs(run(case, lame)[0] - 1.0) < 0.03
