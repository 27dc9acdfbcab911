"""Closed forms of contact against published or independently derived numbers."""

import math

import numpy as np
import pytest

from contactfem.verification import contact as ref


def at(profile: ref.Profile, *x: float) -> list[float]:
    return profile(np.array(x)).tolist()


def integral(profile: ref.Profile, center: float, half_width: float) -> float:
    """Integrate with x = center + a sin s, which smooths the edges."""
    s = np.linspace(-0.5 * math.pi, 0.5 * math.pi, 20001)
    values = profile(center + half_width * np.sin(s)) * half_width * np.cos(s)
    return float(np.sum(0.5 * (values[1:] + values[:-1]) * np.diff(s)))


def test_hertz_of_the_nafems_cylinder():
    modulus = ref.effective_modulus(210e9, 0.3, 70e9, 0.3)
    hertz = ref.hertz_line(35e6, 0.05, modulus)
    assert hertz.half_width == pytest.approx(6.214628e-3, rel=1e-6)
    assert at(hertz.pressure, 0.0)[0] == pytest.approx(3585.362e6, rel=1e-6)
    expected = np.array([3538.6, 3394.6, 3139.9, 2744.0, 2129.3, 934.1]) * 1e6
    found = at(hertz.pressure, *(1e-3 * k for k in range(1, 7)))
    assert found == pytest.approx(expected, rel=5e-5)


def test_hertz_carries_its_load_about_its_center():
    hertz = ref.hertz_line(7.0, 2.0, 300.0, radius_2=5.0, center=0.4)
    assert integral(hertz.pressure, 0.4, hertz.half_width) == pytest.approx(7.0, rel=1e-7)
    assert at(hertz.pressure, 0.4 + 1.001 * hertz.half_width) == [0.0]


def test_cattaneo_mindlin_of_two_half_cylinders():
    modulus = ref.effective_modulus(200.0, 0.3, 200.0, 0.3)
    solution = ref.cattaneo_mindlin(10.0, 0.93622, 0.2, 8.0, modulus, radius_2=8.0)
    assert solution.half_width == pytest.approx(0.6807784, rel=1e-6)
    assert solution.stick_half_width == pytest.approx(0.4964970, rel=1e-5)
    x = (0.0, 0.2, 0.4, 0.5, 0.55, 0.6, 0.65)
    p = (9.35135, 8.93870, 7.56691, 6.34638, 5.51095, 4.41828, 2.78000)
    t = (0.50627, 0.53930, 0.70535, 1.26928, 1.10219, 0.88366, 0.55600)
    assert at(solution.pressure, *x) == pytest.approx(p, rel=2e-6)
    assert at(solution.traction, *x) == pytest.approx(t, rel=2e-5)
    force = integral(solution.traction, 0.0, solution.half_width)
    assert force == pytest.approx(0.93622, rel=1e-5)


def test_cattaneo_mindlin_turns_with_its_load_and_slips_at_the_limit():
    one = ref.cattaneo_mindlin(10.0, 1.0, 0.2, 8.0, 100.0)
    other = ref.cattaneo_mindlin(10.0, -1.0, 0.2, 8.0, 100.0)
    x = np.linspace(-1.0, 1.0, 11)
    assert np.array_equal(one.traction(x), -other.traction(x))
    limit = ref.cattaneo_mindlin(10.0, 2.0, 0.2, 8.0, 100.0)
    assert limit.stick_half_width == 0.0
    assert np.allclose(limit.traction(x), 0.2 * limit.pressure(x), rtol=1e-15)
    with pytest.raises(ValueError, match="tangential_load"):
        ref.cattaneo_mindlin(10.0, 2.1, 0.2, 8.0, 100.0)


@pytest.mark.parametrize(
    ("mean", "half_width", "peak"),
    [(0.5, 0.36179292, 1.8580365), (1.0, 0.55071350, 2.6276604), (2.0, 1.0, 3.7261498)],
)
def test_westergaard(mean, half_width, peak):
    modulus = ref.effective_modulus(200.0, 0.3, 200.0, 0.3)
    wave = ref.westergaard(mean, 2.0, 0.01, modulus)
    assert wave.half_width == pytest.approx(half_width, rel=1e-7)
    assert at(wave.pressure, 0.0)[0] == pytest.approx(peak, rel=1e-7)
    assert integral(wave.pressure, 0.0, wave.half_width) == pytest.approx(2.0 * mean, rel=1e-6)
    assert at(wave.pressure, 2.3, -1.7) == pytest.approx(at(wave.pressure, 0.3) * 2, rel=1e-9)


def test_westergaard_inside_and_at_the_valley():
    modulus = ref.effective_modulus(200.0, 0.3, 200.0, 0.3)
    partial = ref.westergaard(0.5, 2.0, 0.01, modulus)
    assert at(partial.pressure, 0.1, 0.4) == pytest.approx([1.7559300, 0.0], rel=1e-7)
    assert at(ref.westergaard(2.0, 2.0, 0.01, modulus).pressure, 1.0) == pytest.approx(
        [0.2738502], rel=1e-6
    )


def test_case_files_reach_every_closed_form():
    moduli = {"youngs_modulus_1": 210e9, "poisson_ratio_1": 0.3}
    both = moduli | {"youngs_modulus_2": 70e9, "poisson_ratio_2": 0.3}
    pair = ref.effective_modulus(210e9, 0.3, 70e9, 0.3)
    cylinder = {"load": 35e6, "radius": 0.05}
    named = ref.closed_form("hertz_line", cylinder | both)
    plain = ref.closed_form("hertz_line", cylinder | {"effective_modulus": pair})
    assert named.half_width == plain.half_width == ref.hertz_line(35e6, 0.05, pair).half_width
    rigid = ref.closed_form("hertz_line", cylinder | moduli)
    assert rigid.half_width < named.half_width
    shear = {"tangential_load": 1e6, "friction_coefficient": 0.1}
    assert ref.closed_form("cattaneo_mindlin", cylinder | both | shear).stick_half_width > 0.0
    wave = {"mean_pressure": 1.0, "wave_length": 2.0, "amplitude": 0.1}
    assert ref.closed_form("westergaard", wave | moduli).period == 2.0
    level = ref.closed_form("uniform", {"pressure": 3.0})
    assert at(level.pressure, 7.0) == [3.0]
    assert at(level.traction, 7.0) == [0.0]


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"load": 1.0}, "missing 'radius'"),
        ({"load": 1.0, "radius": 1.0, "force": 1.0}, "unknown 'force'"),
        ({"load": 1.0, "radius": 1.0}, "give effective_modulus, or"),
        (
            {
                "load": 1.0,
                "radius": 1.0,
                "effective_modulus": 1.0,
                "youngs_modulus_1": 1.0,
                "poisson_ratio_1": 0.3,
            },
            "give effective_modulus, or",
        ),
        (
            {"load": 0.0, "radius": 1.0, "effective_modulus": 1.0},
            "hertz_line has no solution for these values: .*division by zero",
        ),
    ],
)
def test_parameters_that_do_not_fit(parameters, message):
    with pytest.raises(ValueError, match=message):
        ref.closed_form("hertz_line", parameters)
