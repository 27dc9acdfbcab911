"""Units that numbers are shown in."""

import math

import pytest

from contactfem.common.unit_display import engineering, scale_for


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (3.585362e9, "Pa", "3585.4 MPa"),
        (-210e9, "Pa", "-210 GPa"),
        (2.5e4, "Pa", "25 kPa"),
        (0.04, "m", "40 mm"),
        (28.6e-6, "m", "28.6 µm"),
        (35e6, "N/m", "35 kN/mm"),
        (936.22, "N/m", "0.93622 N/mm"),
        (0.25, "s", "0.25 s"),
        (0.0, "Pa", "0 Pa"),
        (0.3, "", "0.3"),
        (2.0, "K", "2 K"),
    ],
)
def test_values_read_as_engineers_write_them(value, unit, text):
    assert engineering(value, unit) == text


def test_what_is_not_a_number_stays_in_si():
    assert engineering(math.nan, "Pa") == "nan Pa"
    assert scale_for(math.inf, "m").factor == 1.0
