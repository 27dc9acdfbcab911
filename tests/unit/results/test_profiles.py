"""Zones and distances, on nodal values whose answer is known."""

import math

import numpy as np
import pytest

from contactfem.results.data import Status
from contactfem.results.profiles import carriers, error_l2, linearised, position_of, zone
from contactfem.verification.contact import hertz_line, uniform, westergaard


def line(x: np.ndarray) -> np.ndarray:
    return np.stack([x, np.zeros_like(x)], axis=1)


def test_nodes_without_multiplier_show_their_neighbour(table, changed):
    status = np.array([-1, -1, 0, 1, -1, 2, -1], dtype=np.int8)
    seven = changed(table, arc=np.arange(7.0), status=status)
    assert carriers(seven).tolist() == [2, 2, 2, 3, 5, 5, 5]


def test_zone_ends_half_a_facet_out_or_at_the_end(table, changed):
    status = np.array([0, 0, 1, 2, 0, 2, -1], dtype=np.int8)
    seven = changed(table, arc=np.arange(7.0), status=status)
    assert zone(seven, (Status.STICK, Status.SLIP)) == (1.5, 6.0)
    assert zone(seven, (Status.STICK,)) == (1.5, 2.5)
    none = changed(seven, status=np.zeros(7, dtype=np.int8))
    assert zone(none, (Status.STICK,)) is None


def test_position_is_found_in_either_direction():
    assert position_of(np.array([0.0, 1.0, 3.0]), 2.5) == pytest.approx(1.75)
    assert position_of(np.array([3.0, 1.0, 0.0]), 2.5) == pytest.approx(0.25)
    assert position_of(np.array([3.0, 1.0]), 7.0) == 0.0


def test_error_of_a_factor_is_that_factor():
    x = np.linspace(-1.0, 2.0, 8)
    flat = uniform(3.0)
    assert error_l2(line(x), np.full(8, 3.03), flat.pressure, flat) == pytest.approx(0.01)
    upright = line(x)[:, ::-1].copy()
    assert error_l2(upright, np.full(8, 3.03), flat.pressure, flat) == pytest.approx(0.01)


def test_error_of_a_parabola_against_its_interpolant():
    """|x² - x_h| = s(h - s) on a facet of length h, whose square integrates to h⁵/30."""
    x = np.array([0.0, 0.5, 1.0])
    flat = uniform(0.0)
    found = error_l2(line(x), x**2, lambda s: s**2, flat)
    assert found == pytest.approx(math.sqrt(2 * 0.5**5 / 30 / 0.2), rel=1e-12)
    assert math.isnan(error_l2(line(x), x, flat.pressure, flat))


def test_facets_are_split_at_the_contact_edge():
    """With one facet over the whole contact the norm alone is tested: ∫p² = 4 p₀² a / 3."""
    hertz = hertz_line(1.0, 1.0, 1.0)
    a = hertz.half_width
    x = np.array([-2.0 * a, 2.5 * a])
    zero = error_l2(line(x), np.zeros(2), hertz.pressure, hertz)
    assert zero == pytest.approx(1.0, rel=1e-12)
    peak = 2.0 / (math.pi * a)
    constant = error_l2(line(x), np.full(2, peak), hertz.pressure, hertz)
    square = 4.5 * a - 2 * (math.pi * a / 2) + 4 * a / 3
    assert constant == pytest.approx(math.sqrt(square / (4 * a / 3)), rel=2e-4)
    core = error_l2(line(x), np.full(2, 0.5 * peak), hertz.pressure, hertz, 0.9 * a)
    root = 0.9 * math.sqrt(0.19) + math.asin(0.9)
    norm = 1.8 - 2 * 0.9**3 / 3
    assert core == pytest.approx(math.sqrt((0.45 - root + norm) / norm), rel=1e-6)


def test_every_period_has_its_edges():
    wave = westergaard(0.5, 2.0, 0.01, 109.89)
    x = np.linspace(-3.0, 5.0, 9)
    assert error_l2(line(x), np.zeros(9), wave.pressure, wave) == pytest.approx(1.0, rel=1e-12)
    many = np.linspace(-3.0, 5.0, 2049)
    assert error_l2(line(many), wave.pressure(many), wave.pressure, wave) < 5e-3


def test_linearised_undoes_stretch_and_turn_of_the_surface(table, changed):
    """A surface that is 2 % shorter and turned: the same forces act on it."""
    angle, stretch = 0.03, 0.98
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    p = (table.pressure * np.cos(angle) - table.traction * np.sin(angle)) / stretch
    t = (table.traction * np.cos(angle) + table.pressure * np.sin(angle)) / stretch
    forward = changed(
        table,
        x=stretch * table.X @ turn.T,
        facet_length=stretch * table.facet_length,
        pressure=p,
        traction=t,
    )
    backward = changed(
        forward,
        X=forward.X[::-1],
        x=forward.x[::-1],
        facet_length=forward.facet_length[::-1],
        pressure=p[::-1],
        traction=t[::-1],
    )
    found, mirrored = linearised(forward), linearised(backward)
    scale = table.pressure.max()
    np.testing.assert_allclose(found.pressure, table.pressure, rtol=0, atol=1e-12 * scale)
    np.testing.assert_allclose(found.traction, table.traction, rtol=0, atol=1e-12 * scale)
    np.testing.assert_allclose(mirrored.pressure[::-1], table.pressure, rtol=0, atol=1e-12 * scale)
    np.testing.assert_allclose(mirrored.traction[::-1], table.traction, rtol=0, atol=1e-12 * scale)
