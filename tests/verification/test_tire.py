"""The tire on coarse meshes: contact, friction, heat and all three kinds of adaptivity at once."""

import csv
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.run.driver import run_case

CASE = Path(__file__).parents[2] / "cases" / "tire_small.toml"
FRICTION = 0.4
SLIDES = 0.060  # a time at which the whole tread slides [s]


def nodes(folder, t):
    """Columns of the nodes of the interface at a time."""
    with (folder / f"interface_patch_t={t:g}.csv").open() as file:
        rows = list(csv.DictReader(file))
    names = {name: name.split(" ")[0] for name in rows[0]}
    columns = {names[key]: [row[key] for row in rows] for key in rows[0] if key != "status"}
    found = {key: np.array(column, float) for key, column in columns.items()}
    found["status"] = np.array([row["status"] for row in rows])
    return found


def key_numbers(result, folder):
    """What the regression holds: pressure, width, friction, temperature, balance, remeshes."""
    node = nodes(folder, SLIDES)
    active = node["status"] != "open"
    weight = node["cover"] * node["facet_length"]
    (step,) = (step for step in result.steps if math.isclose(step.t, SLIDES))
    made = [r for step in result.steps for r in step.errors.remeshes]
    heat = [step.heat for step in result.steps]
    return {
        "pressure": node["pressure"].max(),
        "front": node["x"][active].max(),
        "width": weight[active].sum(),
        "friction": step.forces["patch"][0],
        "pressing": -step.forces["patch"][1],
        "hottest": max(h.temperature_max for h in heat),
        "work": sum(step.dissipation for step in result.steps),
        "heat": sum(h.friction for h in heat),
        "stored": sum(h.stored - sum(h.held.values()) for h in heat),
        "stress_remeshes": sum(r.problem == "mechanics" and r.body == "tire" for r in made),
        "heat_remeshes": sum(r.problem == "heat" and r.body == "tire" for r in made),
        "repeats": sum(step.errors.repeats for step in result.steps),
    }


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tire")
    result = run_case(read_case(CASE), MPI.COMM_SELF, folder)
    return result, folder, key_numbers(result, folder)


def sliding(result):
    """Steps in which the whole tread slides forwards."""
    return [s for s in result.steps if s.stick == 0 and s.slip > 0 and 0.02 < s.t <= 0.075]


def test_it_gets_to_the_end(run):
    result, _, _ = run
    assert result.converged
    assert result.steps[-1].t == pytest.approx(0.1)


@pytest.mark.parametrize("t", [0.045, 0.060, 0.075])
def test_traction_is_at_its_limit_where_the_tread_slides(run, t):
    """Node by node, so the friction force is the coefficient times the normal force, exactly."""
    _, folder, _ = run
    node = nodes(folder, t)
    active = node["status"] != "open"
    assert set(node["status"][active]) == {"slip"}
    weight = node["cover"] * node["facet_length"]
    friction, normal = weight @ node["traction"], weight @ node["pressure"]
    assert abs(friction) == pytest.approx(FRICTION * normal, rel=1e-9)


def test_plateau(run):
    """Upwards the tread carries what is put on it, to the tolerance of Newton's method.

    The horizontal force is its share to within the inclination of the ground under the tread.
    """
    result, _, _ = run
    steps = sliding(result)
    assert len(steps) > 10
    for step in steps:
        horizontal, vertical = step.forces["patch"]
        assert vertical == pytest.approx(-26.4e3, rel=1e-8)  # p_i over the opening, and 2 F_v
        tilt = math.atan2(horizontal, -vertical) - math.atan(FRICTION)
        assert abs(tilt) < math.radians(0.02)


def test_all_work_of_friction_becomes_heat(run):
    result, _, numbers = run
    assert numbers["heat"] == pytest.approx(numbers["work"], rel=1e-8)
    assert numbers["stored"] == pytest.approx(numbers["heat"], rel=1e-8)
    for step in result.steps:
        assert step.heat.friction == pytest.approx(step.dissipation, rel=1e-8, abs=1e-12)


def test_heating_starts_with_sliding(run):
    result, _, numbers = run
    first = sliding(result)[0].t
    before = [s.heat.temperature_max for s in result.steps if s.t < first]
    assert max(before) < 0.01 * numbers["hottest"]
    after = [s.heat.temperature_max for s in sliding(result)]
    assert max(after) == after[-1]
    little = 0.005 * after[-1]  # a short step may lose this
    assert all(b > a - little for a, b in pairwise(after))


def test_the_hottest_place_is_on_the_tire(run):
    """Its tread stays in contact, the ground under it does not."""
    _, folder, _ = run
    node = nodes(folder, 0.075)
    side = {key: np.nanmax(node[key]) for key in ("temperature", "mortar_temperature")}
    assert side["temperature"] > 1.3 * side["mortar_temperature"] > 0.0


def test_it_springs_back(run):
    """When the rim has gone back the tread rests: it sticks, without work, and cools."""
    result, _, numbers = run
    rest = [step for step in result.steps if step.t > 0.0875]
    assert abs(rest[-1].forces["patch"][0]) < 0.5 * FRICTION * 26.4e3
    assert sum(step.dissipation for step in rest) < 1e-5 * numbers["work"]
    hottest = [step.heat.temperature_max for step in rest]
    assert all(a > b for a, b in pairwise(hottest))


def test_all_kinds_of_adaptivity_act(run):
    """Stresses from t1 on, heat and steps as soon as there is heat; and the meshes differ."""
    result, _, numbers = run
    assert numbers["stress_remeshes"] >= 1
    assert numbers["heat_remeshes"] >= 1
    assert numbers["repeats"] >= 1
    for step in result.steps:
        assert (step.errors.mechanics is None) == (step.t <= 0.010 * (1.0 + 1e-9))
        assert step.errors.heat is None or step.t > 0.02
    last = result.steps[-1].errors
    assert last.cells != last.thermal_cells


def test_errors_stay_within_their_tolerances(run):
    """In every accepted step, also where sliding sets in and the layer of heat has no thickness."""
    result, _, _ = run
    asked = result.case.adaptivity
    errors = [step.errors for step in result.steps if step.t > asked.start]
    assert max(e.mechanics for e in errors if e.mechanics is not None) <= asked.for_mechanics()
    assert max(e.heat for e in errors if e.heat is not None) <= asked.for_heat()


@pytest.mark.mpi
def test_ranks_agree():
    """Until the tread slides, with several new meshes."""
    case = read_case(CASE, ('time.end="30 ms"', "output.times=[]"))
    alone, together = (run_case(case, comm, None) for comm in (MPI.COMM_SELF, MPI.COMM_WORLD))
    assert len(alone.steps) == len(together.steps)
    assert sum(len(step.errors.remeshes) for step in alone.steps) >= 4
    for one, many in zip(alone.steps, together.steps, strict=True):
        assert many.errors.cells == one.errors.cells
        if one.errors.mechanics is not None:
            assert many.errors.mechanics == pytest.approx(one.errors.mechanics, rel=1e-6)
        assert many.forces["patch"] == pytest.approx(one.forces["patch"], rel=1e-6, abs=1e-6)
        hottest = pytest.approx(one.heat.temperature_max, rel=1e-8, abs=1e-12)
        assert many.heat.temperature_max == hottest


# Found on this case's first meshes. With facets of 3 mm instead of 4 mm on the first tread, and of
# 0.7 mm instead of 1 mm on later ones, the numbers move by 0.7 % (pressure), 0.4 mm (width), 20 um
# (front), 1e-4 (friction), 0.5 % (temperature), 5e-4 (work), 0 and 2 (new meshes); with the meshes
# of another version of gmsh the pressure, of a single node, by 2.1 %; on three ranks all by 4e-8 at
# most. The bounds are some twice that, a facet for the ends of the contact, 3 % for the pressure.
REGRESSION = {
    "pressure": (0.6446e6, 0.03 * 0.6446e6),
    "width": (54.33e-3, 1.0e-3),
    "front": (97.92e-3, 1.0e-3),
    "friction": (10559.6, 2e-4 * 10559.6),
    "hottest": (46.27, 0.01 * 46.27),
    "work": (460.78, 1e-3 * 460.78),
    "stress_remeshes": (3, 1),
    "heat_remeshes": (12, 3),
}


@pytest.mark.parametrize("key", REGRESSION)
def test_regression(run, key):
    value, allowed = REGRESSION[key]
    assert run[2][key] == pytest.approx(value, abs=allowed)
