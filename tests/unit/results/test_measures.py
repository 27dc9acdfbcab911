"""Numbers measured on a made-up run whose answers are known."""

import math

import numpy as np
import pytest

from contactfem.results.data import Status
from contactfem.results.measures import floor_seconds, measurable, measure, von_mises


def test_every_name_is_measured_and_every_number_has_a_name(make_run):
    run = make_run()
    assert set(measure(run)) == set(measurable(run.case))


def test_interface_numbers_of_the_closed_form(make_run, solution):
    values = measure(make_run())
    h = 3 * solution.half_width / 60
    assert values["sole.pressure_max"] == pytest.approx(9.351351e6, rel=1e-6)
    assert values["sole.pressure_at_center"] == values["sole.pressure_max"]
    assert values["sole.mortar_pressure_at_center"] == pytest.approx(9.351351e6, rel=1e-3)
    assert values["sole.normal_force"] == pytest.approx(10e3, rel=5e-3)
    assert values["sole.tangential_force"] == pytest.approx(936.22, rel=2e-2)
    assert values["sole.force_x"] == 936.22
    assert values["sole.force_y"] == -10e3
    assert values["sole.moment_defect"] == 4e-4
    assert values["sole.contact_half_width"] == pytest.approx(solution.half_width, abs=0.51 * h)
    assert values["sole.stick_half_width"] == pytest.approx(solution.stick_half_width, abs=h / 2)
    assert values["sole.stick_edge_max"] == pytest.approx(-values["sole.stick_edge_min"])
    assert values["sole.contact_edge_max"] == pytest.approx(values["sole.contact_half_width"])
    assert values["sole.stick"] + values["sole.slip"] == values["sole.active"] == 39
    assert values["sole.pressure_error_l2"] < 0.02
    assert values["sole.pressure_error_l2_core"] < 1e-3
    assert values["sole.pressure_error_max"] == 0.0
    assert values["sole.traction_error_max"] == 0.0
    assert values["sole.gap_min"] == 0.0


def test_a_factor_of_one_percent_is_seen(make_run, table, changed):
    off = changed(table, pressure=1.01 * table.pressure, traction=1.01 * table.traction)
    values = measure(make_run(off))
    assert values["sole.pressure_error_max"] == pytest.approx(0.01, rel=1e-9)
    assert values["sole.pressure_error_l2_core"] == pytest.approx(0.01, rel=0.05)
    assert values["sole.traction_error_l2"] > 0.01


def test_prescribed_ends_take_their_neighbours_pressure(make_run, table, changed):
    n = 61
    status = np.full(n, Status.STICK, dtype=np.int8)
    status[[0, -1]] = Status.NONE
    p = np.where(status == Status.NONE, 0.0, 5.0)
    level = {"sole": type("C", (), {"solution": "uniform", "parameters": {"pressure": 5.0}})}
    patch = changed(table, pressure=p, traction=np.zeros(n), status=status)
    values = measure(make_run(patch, closed_form=level))
    assert values["sole.pressure_error_l2"] == 0.0
    assert values["sole.pressure_min"] == values["sole.pressure_max"] == 5.0
    assert values["sole.contact_half_width"] == pytest.approx(0.5 * table.arc[-1], rel=1e-15)
    assert math.isnan(values["sole.traction_error_l2"])


def test_no_contact_at_all(make_run, table, changed):
    n = 61
    none = changed(table, status=np.zeros(n, dtype=np.int8), pressure=np.zeros(n))
    values = measure(make_run(none, closed_form={}))
    assert values["sole.pressure_max"] == values["sole.contact_half_width"] == 0.0
    assert math.isnan(values["sole.contact_edge_min"])
    assert math.isnan(values["sole.pressure_min"])


def test_an_obstacle_has_no_mortar_nodes(make_run, table, changed):
    rigid = changed(table, mortar_x=np.empty((0, 2)), mortar_pressure=np.empty(0))
    assert "sole.mortar_pressure_max" not in measure(make_run(rigid))


def test_numbers_of_the_run(make_run):
    values = measure(make_run())
    assert values["steps"] == 4
    assert values["cutbacks"] == 1
    assert values["iterations.max"] == 6
    assert values["iterations.mean"] == pytest.approx(4.75)
    assert values["dissipation"] == pytest.approx(1e-5)
    assert values["converged"] == 1.0
    assert values["probe.tip"] == 2e-5
    assert values["cost.solve_to_floor"] == pytest.approx(2.0 / 1.5)
    assert values["cost.contact_share"] == pytest.approx(0.2 / 1.5)
    assert floor_seconds({"assembly": 1.0, "solve": 0.5}) == 1.5


def test_extremes_of_a_body(make_run):
    run = make_run()
    values = measure(run)
    stress = run.bodies[0].fields["stress"]
    assert values["lower.stress_yy.min"] == stress[:, 1].min()
    assert values["lower.stress_xy.max"] == stress[:, 3].max()
    assert values["upper.displacement_y.max"] == run.bodies[1].displacement[:, 1].max()


def test_von_mises_of_simple_states():
    states = np.array([[2.0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 3.0, 0], [5.0, 5.0, 5.0, 0, 0, 0]])
    assert von_mises(states) == pytest.approx([2.0, 3.0 * math.sqrt(3.0), 0.0])
