"""Homogeneous neo-Hooke states against independently computed numbers (K = 333, μ = 35)."""

import numpy as np
import pytest

from contactfem.verification.homogeneous import (
    NeoHooke,
    bulk_and_shear_modulus,
    confined_stack,
    youngs_modulus_and_poisson_ratio,
)

RUBBER = NeoHooke(333.0, 35.0)
HOT = NeoHooke(333.0, 35.0, 1e-4, 100.0)
GROUND = NeoHooke(8333.0, 3846.0, 1e-5)


def test_moduli_there_and_back():
    assert bulk_and_shear_modulus(10000.0, 0.3) == pytest.approx((8333.3333333, 3846.1538462))
    assert youngs_modulus_and_poisson_ratio(333.0, 35.0) == pytest.approx(
        (101.446, 0.44923), rel=1e-5
    )
    back = youngs_modulus_and_poisson_ratio(*bulk_and_shear_modulus(70e9, 0.2))
    assert back == pytest.approx((70e9, 0.2), rel=1e-14)


@pytest.mark.parametrize(
    ("stretch", "lateral", "stress", "nominal"),
    [
        (0.5, 1.3727064, -63.172833, -119.038020),
        (0.7, 1.1762676, -32.988559, -45.643151),
        (0.9, 1.0487183, -10.317661, -11.347468),
        (1.2, 0.9222183, 19.944071, 16.962165),
    ],
)
def test_uniaxial_stress(stretch, lateral, stress, nominal):
    found = RUBBER.uniaxial_stress(stretch)
    assert found == pytest.approx((lateral, stress, nominal), rel=1e-7)


@pytest.mark.parametrize(
    ("stretch", "lateral", "stress", "out"),
    [
        (0.5, 1.6817739, -120.461841, -85.421639),
        (0.7, 1.3258815, -50.253882, -30.040749),
        (0.9, 1.0891423, -13.613738, -6.738680),
    ],
)
def test_plane_strain_block(stretch, lateral, stress, out):
    assert RUBBER.plane_strain_block(stretch) == pytest.approx((lateral, stress, out), rel=1e-7)


@pytest.mark.parametrize(
    ("stretch", "axial", "lateral"),
    [
        (0.8, -105.067674, -86.791418),
        (0.9, -44.267756, -36.341208),
        (0.95, -20.457692, -16.740628),
    ],
)
def test_uniaxial_strain(stretch, axial, lateral):
    assert RUBBER.uniaxial_strain(stretch) == pytest.approx((axial, lateral), rel=1e-7)


def test_plane_strain_dead_load():
    found = RUBBER.plane_strain_dead_load(-20.0)
    assert found == pytest.approx((0.87154982, 1.11757027, -17.8959664), rel=1e-8)


def test_simple_shear_has_a_normal_stress_difference():
    stress = RUBBER.cauchy_stress([[1.0, 0.3, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    assert stress[0, 1] == pytest.approx(35.0 * 0.3, rel=1e-14)
    assert stress[0, 0] - stress[1, 1] == pytest.approx(35.0 * 0.09, rel=1e-13)
    assert np.trace(stress) == pytest.approx(0.0, abs=1e-13)


def test_heated_states():
    assert HOT.free_stretch() == pytest.approx(1.0100501671, rel=1e-10)
    assert HOT.principal_stresses(*[HOT.free_stretch()] * 3) == pytest.approx(0.0, abs=1e-12)
    assert HOT.principal_stresses(1.0, 1.0, 1.0) == pytest.approx(-9.99, rel=1e-14)
    assert HOT.uniaxial_stress(1.0) == pytest.approx(
        (1.0146001670, -0.9809156, -1.0097677), rel=1e-7
    )
    assert HOT.plane_strain_block(1.0) == pytest.approx(
        (1.0266322, -1.8081125, -1.8081125), rel=1e-7
    )


def test_confined_stack_cold_and_hot():
    cold = confined_stack(RUBBER, GROUND, 1.0, 1.0, -0.2)
    assert cold.pressure == pytest.approx(99.87536802, rel=1e-9)
    assert cold.stretch_lower == pytest.approx(0.80734487, rel=1e-8)
    assert cold.stretch_upper == pytest.approx(0.99265513, rel=1e-8)
    assert cold.lateral_lower == pytest.approx(-82.465673, rel=1e-8)
    assert cold.lateral_upper == pytest.approx(-42.890201, rel=1e-8)
    hot = confined_stack(HOT, GROUND, 1.0, 1.0, -0.2)
    assert hot.pressure == pytest.approx(111.63993304, rel=1e-9)
    assert hot.stretch_lower == pytest.approx(0.80820033, rel=1e-8)


def test_what_cannot_be_is_said():
    with pytest.raises(ValueError, match="different signs"):
        RUBBER.plane_strain_dead_load(1e6)
