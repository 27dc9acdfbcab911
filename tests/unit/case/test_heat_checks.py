"""What is said about cases whose heat is not right, and what right ones become."""

import re
from pathlib import Path

import pytest

from contactfem.case.read import read_case
from contactfem.common.time_table import constant
from contactfem.errors import CaseError
from contactfem.results.measures import measurable

BARS = Path(__file__).parents[3] / "cases" / "two_bars.toml"

# what is changed in two_bars.toml, and the line it gives after the file's name
BROKEN = {
    # the laws of an interface
    'interfaces.contact.heat.law="insulated"': "interfaces.contact.heat: law = 'insulated' takes "
    "none of these; found conductance, hardness, exponent",
    'interfaces.contact.heat.law="constant"': "interfaces.contact.heat: law = 'constant' takes "
    "conductance; found conductance, hardness, exponent",
    'interfaces.contact.heat.law="gas"': "interfaces.contact.heat: law = 'gas' takes "
    "gas_conductivity, gas_distance; found conductance, hardness, exponent",
    'interfaces.contact.heat.law="presure"': "interfaces.contact.heat.law = presure: must",
    "interfaces.contact.heat.exponent=0": "interfaces.contact.heat.exponent = 0: must be > 0",
    "interfaces.contact.heat.partition=1.5": "interfaces.contact.heat.partition = 1.5: must be "
    "<= 1",
    'interfaces.contact.heat.hardness="1 mm"': "interfaces.contact.heat.hardness = 1 mm: is a "
    "length, not a stress",
    'interfaces.contact.heat.conductivity="1 W/m/K"': "interfaces.contact.heat.conductivity: "
    "unknown key; did you mean 'gas_conductivity'?",
    # the table
    'heat.scheme="cG(9)"': "heat.scheme = cG(9): must be",
    "heat.max_passes=0": "heat.max_passes = 0: must be >= 1",
    "heat.relaxation=2.0": "heat.relaxation = 2.0: must be 'aitken' or a factor above 0 "
    "and at most 1",
    'heat.relaxation="none"': "heat.relaxation = none: must be 'aitken' or a factor",
    'heat.sheme="cG(1)"': "heat.sheme: unknown key; did you mean 'scheme'?",
    # what materials lack
    'heat.scheme="cG(1)"': "materials.solid: heat needs density, heat_capacity",
    "heat.thermoelastic=true": "materials.solid: heat needs reference_temperature",
    'materials.solid.conductivity="-1 W/m/K"': "materials.solid.conductivity = -1 W/m/K: "
    "must be > 0",
    # what goes without heat, or only with it
    "heat=false": "conditions.4.temperature: heat is not solved for; add [heat]",
    'bodies.hot.temperature="5 K"': "bodies.hot.temperature: is solved for; give "
    "initial_temperature, or leave [heat] out",
    # meshes
    'bodies.hot.thermal_mesh={builder="box", width="1 m", height="1 m", depth="1 m", nx=1, ny=1,'
    " nz=1}": "bodies.hot.thermal_mesh: is in 3D; dimension = plane strain",
    'bodies.hot.thermal_mesh={builder="disk", radius="1 m", facets=8, layers=1}': "bodies.hot."
    "thermal_mesh: has no surface 'top', which conditions.4.on names",
    # functions
    'bodies.hot.initial_temperature="none.py:f"': "bodies.hot.initial_temperature = none.py:f: "
    "there is no file 'none.py'",
    'conditions.4.temperature="none.py:f"': "conditions.4.temperature = none.py:f: there is no "
    "file 'none.py'",
    'conditions.4.temperature="5 mm"': "conditions.4.temperature = 5 mm: is a length, not a",
    'conditions.4.heat_flux="5 W/m^2"': "conditions.4: must have one of",
}


@pytest.mark.parametrize("change", BROKEN)
def test_mistakes(change):
    """One clear line: the key, what was found and what is allowed."""
    with pytest.raises(CaseError) as raised:
        read_case(BARS, [change])
    lines = str(raised.value).splitlines()
    assert any(line.startswith(f"{BARS}: {BROKEN[change]}") for line in lines), lines


def test_heat_alone_needs_a_pressure():
    """Without mechanics there is none that a law could take."""
    with pytest.raises(CaseError) as raised:
        read_case(BARS, ["mechanics=false"])
    assert "interfaces.contact.heat: without mechanics law = 'pressure' needs a pressure" in str(
        raised.value
    )
    with pytest.raises(CaseError, match="mechanics = false: leaves nothing to solve"):
        read_case(BARS, ["mechanics=false", "heat=false"])
    case = read_case(BARS, ["mechanics=false", 'interfaces.contact.heat.pressure="4 MPa"'])
    assert case.interfaces["contact"].heat.pressure == constant(4e6)


def test_bodies_that_do_not_move_have_no_stress_to_probe():
    """Nor is it asked for as an expectation."""
    probe = "probes.middle={on='hot', at=['0 m', '12 mm'], value='%s'}"
    still = ["mechanics=false", 'interfaces.contact.heat.pressure="4 MPa"', "expect={}"]
    with pytest.raises(CaseError, match=r"probes.middle.value = stress.xx: bodies do not move"):
        read_case(BARS, [*still, probe % "stress.xx"])
    case = read_case(BARS, [*still, probe % "temperature"])
    assert {"probe.middle", "heat.temperature_max"} <= measurable(case).keys()
    assert "hot.stress_xx.max" not in measurable(case)
    assert "hot.stress_xx.max" in measurable(read_case(BARS))


def test_nothing_holds_a_steady_temperature(tmp_path):
    """A body without storage needs something that holds its temperature, if only by its contact."""
    path = tmp_path / "bars.toml"
    path.write_text(re.sub("heat = { law.*", "", BARS.read_text()))
    read_case(path)  # each bar has a wall
    with pytest.raises(CaseError) as raised:
        read_case(path, ["conditions.5.on=hot.top"])
    found = "bodies.cold: nothing holds its temperature, as scheme = 'steady' needs"
    assert str(raised.value).startswith(f"{path}: {found}")
    read_case(BARS, ["conditions.5.on=hot.top"])  # the contact may hold it


def test_what_a_case_becomes():
    """Values in SI, and what is not said."""
    case = read_case(BARS)
    assert case.heat is not None
    assert (case.heat.max_passes, case.heat.relaxation) == (None, "aitken")
    heat = case.interfaces["contact"].heat
    assert (heat.conductance, heat.hardness, heat.partition) == (constant(150e3), 100e6, 0.5)
    assert case.materials["solid"].conductivity == 0.2
    assert case.bodies["hot"].thermal_mesh is None
    assert read_case(BARS.with_name("block.toml")).heat is None
