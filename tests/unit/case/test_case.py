"""Case files that are right, and what is said about those that are not."""

import math
import os
import re
import shutil
import tomllib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contactfem.case.overrides import override
from contactfem.case.read import read_case
from contactfem.case.schema import Case
from contactfem.case.settings import ClosedForm
from contactfem.common.time_table import Table, constant
from contactfem.errors import CaseError
from contactfem.verification.contact import CLOSED_FORMS

ROOT = Path(__file__).resolve().parents[3]
TWO = ROOT / "tests/data/two_blocks.toml"
BLOCK = ROOT / "cases/block.toml"

# what is changed in two_blocks.toml, and the line it gives after the file's name
BROKEN = {
    # keys
    'titel="x"': "titel: unknown key; did you mean 'title'?",
    'interfaces.joint.slave="x"': "interfaces.joint.slave: unknown key; did you mean 'nonmortar'?",
    'interfaces.joint.master="x"': "interfaces.joint.master: unknown key; did you mean 'mortar'?",
    'interfaces.joint.primary="x"': "interfaces.joint.primary: unknown key; known: nonmortar, "
    "mortar, between, search_radius, multiplier, normal, friction, heat, "
    "interference, clearance, adjust",
    "interfaces.joint.friction.mu=0.3": "interfaces.joint.friction.mu: unknown key; did you mean "
    "'coefficient'?",
    'materials.rubber.mu="1 MPa"': "materials.rubber.mu: unknown key; did you mean "
    "'shear_modulus'?",
    'bodies.upper.mesh.hight="1 m"': "bodies.upper.mesh.hight: unknown key; did you mean 'height'?",
    'conditions.1.grip.forces.x="1 N"': "conditions.1.grip.forces: unknown key; did you mean "
    "'force'?",
    'path="x"': "path: unknown key",
    'bodies."a b".material="steel"': 'bodies."a b": must be a name of letters, digits, '
    "'_' and '-'",
    # values
    "materials.rubber.shear_modulus=3": "materials.rubber.shear_modulus = 3: has no unit; give a "
    "stress such as '210 GPa'",
    'materials.rubber.shear_modulus="1 mm"': "materials.rubber.shear_modulus = 1 mm: is a length, "
    "not a stress; give a stress such as '210 GPa'",
    'materials.rubber.shear_modulus="1 MPaa"': "materials.rubber.shear_modulus = 1 MPaa: 'MPaa' is "
    "not a known unit; did you mean 'MPa'?; give a stress such as '210 GPa'",
    'materials.rubber.shear_modulus="-1 MPa"': "materials.rubber.shear_modulus = -1 MPa: "
    "must be > 0",
    'materials.rubber.shear_modulus="nan Pa"': "materials.rubber.shear_modulus = nan Pa: is not a "
    "finite number followed by a unit; give a stress such as '210 GPa'",
    'materials.rubber.youngs_modulus="1 MPa"': "materials.rubber: give either bulk_modulus and "
    "shear_modulus, or youngs_modulus and poisson_ratio",
    "materials.steel.poisson_ratio=nan": "materials.steel.poisson_ratio = NaN: must be a finite "
    "number",
    "materials.steel.poisson_ratio=0.5": "materials.steel.poisson_ratio = 0.5: must be < 0.5",
    'materials.steel.model="ogden"': "materials.steel.model = ogden: must be 'neo-hooke' or "
    "'file.py:function'",
    'materials.steel.model="law.py:psi"': "materials.steel.model = law.py:psi: there is no file "
    "'law.py'",
    "interfaces.joint.friction.coefficient=-0.3": "interfaces.joint.friction.coefficient = -0.3: "
    "must be >= 0",
    'interfaces.joint.friction.coefficient="0.3"': "interfaces.joint.friction.coefficient = 0.3: "
    "must be a plain number",
    'interfaces.joint.friction.law="tresco"': "interfaces.joint.friction.law = tresco: must be "
    "one of coulomb, tresca, rough or 'file.py:function'; did you mean 'tresca'?",
    'interfaces.joint.friction.law="laws.py:own"': "interfaces.joint.friction: law = 'laws.py:own' "
    "takes no coefficient",
    'interfaces.joint.heat.law="presure"': "interfaces.joint.heat.law = presure: must be one of "
    "insulated, pressure, constant, gas or 'file.py:function'; did you mean 'pressure'?",
    'interfaces.joint.friction.law="tresca"': "interfaces.joint.friction: law = 'tresca' takes one "
    "of limit",
    'interfaces.joint.friction={coefficient_table=[["0 MPa", 0.5], ["0 m", 0.3]]}': "interfaces."
    'joint.friction.coefficient_table = [["0 MPa", 0.5], ["0 m", 0.3]]: must be a table over '
    "pressure, slip speed or temperature, ascending, with values >= 0, such as [['0 MPa', 0.5], "
    "['9 MPa', 0.3]]",
    'strain="finit"': "strain = finit: must be one of finite, small; did you mean 'finite'?",
    'output.fields="yes"': "output.fields = yes: must be one of vtkhdf, vtx, false",
    "solver.max_iterations=0": "solver.max_iterations = 0: must be >= 1",
    "solver.tolerance=inf": "solver.tolerance = Infinity: must be < 1",
    "bodies.upper.mesh.nx=2.5": "bodies.upper.mesh.nx = 2.5: must be a whole number",
    "bodies.upper=3": "bodies.upper = 3: must be a table",
    "conditions=3": "conditions = 3: must be a list",
    'bodies.upper.temperature="20 degRe"': "bodies.upper.temperature = 20 degRe: 'degRe' has a "
    "zero of its own; give kelvin; give a temperature such as '20 K'",
    # meshes
    'bodies.upper.mesh.builder="blok"': "bodies.upper.mesh.builder = blok: must have 'file' or a "
    "'builder', one of block, box, cylinder, die, disk, extrusion, graded_block, graded_box, "
    "revolution, ring, tire, wave; did you mean 'block'?",
    'bodies.upper.mesh={file="no.msh", unit="mm"}': "bodies.upper.mesh.file = no.msh: there is no "
    f"file '{TWO.parent / 'no.msh'}'",
    'bodies.upper.mesh={file="two_blocks.toml"}': "bodies.upper.mesh.unit: is missing",
    'bodies."a b"=3': 'bodies."a b" = 3: must be a table',
    'bodies.upper.mesh={builder="block", width="1 m", height="1 m", nx=1}': "bodies.upper.mesh.ny: "
    "is missing",
    # names
    'bodies.upper.material="ruber"': "bodies.upper.material = ruber: there is no material 'ruber'; "
    "did you mean 'rubber'?",
    'interfaces.joint.mortar="lower.topp"': "interfaces.joint.mortar = lower.topp: 'lower' has no "
    "surface 'topp'; did you mean 'top'?",
    'interfaces.joint.nonmortar="uper.top"': "interfaces.joint.nonmortar = uper.top: there is no "
    "body 'uper'; did you mean 'upper'?",
    'interfaces.joint.mortar="upper.bottom"': "interfaces.joint.mortar = upper.bottom: is the "
    "nonmortar side too; give another surface",
    'interfaces.joint.mortar="plane"': "interfaces.joint.mortar = plane: there is no obstacle "
    "'plane'",
    'interfaces.joint.mortar="lower"': "interfaces.joint.mortar = lower: must be 'body.surface'",
    'interfaces.b={nonmortar="upper.bottom", mortar="lower.left"}': "interfaces.b.nonmortar = "
    "upper.bottom: is the nonmortar side of 'joint' already",
    'conditions.0.on="lower.botom"': "conditions.0.on = lower.botom: 'lower' has no surface "
    "'botom'; did you mean 'bottom'?",
    'conditions.3={on="lower.top", body_force.y="1 N/m^3"}': "conditions.3.on = lower.top: there "
    "is no body 'lower.top'; did you mean 'lower'?",
    'probes.corner.on="uper"': "probes.corner.on = uper: there is no body 'uper'; did you mean "
    "'upper'?",
    'probes.corner.at=["1 m","1 m"]': "probes.corner.at: lies outside of 'upper' in x",
    'probes.corner.value="stress.xz"': "probes.corner.value = stress.xz: is zero in plane strain",
    # conditions
    'conditions.0.pressure="1 MPa"': "conditions.0: must have one of displacement, traction, "
    "pressure, body_force, grip, temperature, "
    "heat_flux, heat_source, convection; found displacement and pressure",
    'conditions.3={on="upper.left"}': "conditions.3: must have one of displacement, traction, "
    "pressure, body_force, grip, temperature, "
    "heat_flux, heat_source, convection; found none",
    'conditions.0={on="lower.left", displacement=["0 m"]}': 'conditions.0.displacement = ["0 m"]: '
    "must be a table with x, y or z, or a list of 2",
    'conditions.3={on="lower.left", displacement.z="0 m"}': "conditions.3.displacement.z: there is "
    "no z in plane strain",
    'conditions.1.grip.force.y="1 N/m"': "conditions.1.grip: 'y' is given both as displacement and "
    "as force",
    'conditions.1.grip.force.x="50 N"': "conditions.1.grip.force.x = 50 N: is a force, not a force "
    "per length; give a force per length such as '35 kN/m'",
    'conditions.3={on="lower.bottom", displacement.y="0 m"}': "conditions.3.displacement.y: "
    "conditions.0 prescribes y on 'lower.bottom' already",
    'conditions.3={on="upper.top", displacement.y="0 m"}': "conditions.3.displacement: "
    "conditions.1 holds 'upper.top' by a grip",
    'conditions.3={on="lower.left", displacement.x="1 mm"}': "conditions.3: prescribes another x "
    "than conditions.0 at their common point (0, 0) m",
    'conditions.3={on="upper.left", displacement.x="1 mm"}': "conditions.3: a grip that is free in "
    "x is held at their common point (0.005, 0.0205) m (conditions.1)",
    'conditions.3={on="upper", at=["5 mm","20 mm"], pressure="1 Pa"}': "conditions.3: 'at' goes "
    "with a displacement only",
    'conditions.3={on="upper", at=["5 m","20 mm"], displacement.y="1 m"}': "conditions.3.at: lies "
    "outside of 'upper' in x",
    # times
    'conditions.1.grip.displacement.y=[["1 s","0 m"],["0 s","1 m"]]': "conditions.1.grip."
    'displacement.y = [["1 s", "0 m"], ["0 s", "1 m"]]: times are out of order: 0 s follows 1 s; '
    "give ascending times",
    'time.step="2 s"': "time: step = 2 s is longer than end = 1 s",
    'time.step_min="0.5 s"': "time: step_min = 0.5 s is longer than step = 0.25 s",
    'time.end="0 s"': "time.end = 0 s: must be > 0",
    'output.times=["2 s"]': "output.times: 2 s is after the end, 1 s",
    'output.times=["0.5 s","0.2 s"]': 'output.times = ["0.5 s", "0.2 s"]: times are out of order; '
    "give ascending times",
    # obstacles, closed forms, expectations
    'obstacles.a={shape="plain"}': "obstacles.a.shape = plain: must be one of plane, "
    "circle, polyline, sphere, cylinder, surface; did you mean 'plane'?",
    'obstacles.a={radius="1 m"}': "obstacles.a.shape: is missing",
    'obstacles.a={shape="plane", point=["0 m","0 m"], normal=[0,0]}': "obstacles.a.normal = "
    "[0, 0]: must not be zero",
    'obstacles.upper={shape="plane", point=["0 m","0 m"], normal=[0,1]}': "obstacles.upper: a body "
    "has this name",
    'closed_form.join={solution="uniform", parameters={pressure="1 Pa"}}': "closed_form.join: "
    "there is no interface 'join'; did you mean 'joint'?",
    'closed_form.joint={solution="uniform", parameters={pressure="1 m"}}': "closed_form.joint."
    "parameters: pressure = 1 m: is a length, not a stress; give a stress such as '210 GPa'",
    'closed_form.joint={solution="uniform"}': "closed_form.joint: missing 'pressure'; uniform "
    "takes pressure, traction",
    "expect.steps={value=3}": "expect.steps: must have 'value' with 'rel' or 'abs', or else 'min' "
    "or 'max'",
    "expect.steps={min=3, max=1}": "expect.steps: min is above max",
    'expect."probe.corner".rel=-1': 'expect."probe.corner".rel = -1: must be >= 0',
    'dimension="2d"': "dimension = 2d: must be one of plane strain, axisymmetric, 3d",
    # the override itself
    "conditions.9.pressure=1": "conditions.9: must be an index from 0 to 3",
    "title": "--set title: must be of the form a.b.c=value",
    "a b=3": "--set a b=3: 'a b' is not a dotted key",
}


def complaints(*changes, path=TWO, variant=None):
    with pytest.raises(CaseError) as caught:
        read_case(path, changes, variant)
    lines = str(caught.value).splitlines()
    assert all(line.startswith(f"{path}: ") for line in lines)
    return [line.removeprefix(f"{path}: ") for line in lines]


@pytest.mark.parametrize(("change", "line"), BROKEN.items())
def test_a_mistake_gives_one_clear_line(change, line):
    assert line in complaints(change)


def test_the_table_of_mistakes_is_long():
    assert len(BROKEN) >= 60


def test_every_component_of_a_grip_is_given():
    one = 'conditions.3={on="lower.left", grip={displacement={y="0 m"}}}'
    assert complaints(one) == ["conditions.3.grip: 'x' is neither a displacement nor a force"]


def test_all_mistakes_are_told_at_once():
    found = complaints('titel="x"', "solver.max_iterations=0", 'time.end="3 m"')
    assert len(found) == 3


@pytest.fixture
def folder(tmp_path):
    shutil.copy(TWO, tmp_path / "case.toml")
    return tmp_path


def test_files_that_are_no_case_files(folder):
    path = folder / "case.toml"
    assert complaints(path=folder) == [
        f"is a folder, not a case file; give one of its files, such as {path}"
    ]
    assert complaints(path=folder / "no.toml") == ["there is no such file"]
    near = f"there is no such file; did you mean '{path}'?"
    assert complaints(path=folder / "cas.toml") == [near]
    assert complaints(path=path / "x") == ["cannot be read: Not a directory"]
    path.write_bytes(b"title = '\xff'")
    assert complaints(path=path) == ["is not UTF-8 text (byte 9)"]
    path.write_text("title = 'a'\ntitle = 'b'\n")
    assert complaints(path=path)[0].startswith("is not TOML: a key is there twice (at line 2")
    path.write_text("x = [" * 5000)
    assert complaints(path=path)[0].startswith("is not TOML: ")
    path.write_text(f"x = {'9' * 5000}")
    assert complaints(path=path)[0].startswith("is not TOML: ")
    path.write_text("")
    assert complaints(path=path)[0] == "title: is missing"


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_that_may_not_be_read(folder):
    (folder / "case.toml").chmod(0)
    assert complaints(path=folder / "case.toml") == ["cannot be read: Permission denied"]


BOX = '{builder="box", width="1 m", height="1 m", depth="1 m", nx=1, ny=1, nz=1}'
IN_SPACE = (
    'dimension="3d"',
    'conditions=[{on="lower.bottom", displacement=["0 m","0 m","0 m"]}]',
    f"bodies.upper.mesh={BOX}",
    f"bodies.lower.mesh={BOX}",
    'probes.corner.at=["0 m","0 m","0 m"]',
)


def test_obstacles_in_space_are_spatial():
    floor = 'obstacles.floor={shape="plane", point=["0 m","0 m"], normal=[0,1]}'
    found = complaints(*IN_SPACE, floor, 'interfaces.joint.mortar="floor"')
    assert found == [
        "obstacles.floor.point: must have 3 coordinates",
        "obstacles.floor.normal: must have 3 coordinates",
    ]


def test_a_body_in_3d_does_not_fit_plane_strain():
    box = '{builder="box", width="1 m", height="1 m", depth="1 m", nx=1, ny=1, nz=1}'
    change = f'bodies.third={{material="steel", mesh={box}}}'
    assert complaints(change) == ["bodies.third.mesh: is in 3D; dimension = plane strain"]


def test_the_sample_is_read_in_si():
    case = read_case(TWO)
    assert case.path == TWO
    assert case.time.model_dump() == {
        "end": 1.0,
        "step": 0.25,
        "step_min": 0.25 / 1024,
        "step_max": 0.25,
    }
    upper, lower = case.bodies["upper"], case.bodies["lower"]
    assert upper.mesh.corner == (0.005, 0.0105)
    assert lower.temperature == constant(40.0)
    assert upper.temperature is None
    bottom, top, left = case.conditions
    assert bottom.displacement == {"x": constant(0.0), "y": constant(0.0)}
    assert (bottom.kind, bottom.body, bottom.surface) == ("displacement", "lower", "bottom")
    assert top.grip.displacement == {"y": Table((0.0, 1.0), (0.0, -0.002))}
    assert top.grip.force == {"x": constant(50e3)}
    assert top.components() == {"y": Table((0.0, 1.0), (0.0, -0.002))}
    assert (left.kind, left.pressure, left.components()) == ("pressure", constant(1e4), {})
    assert case.interfaces["joint"].friction.coefficient == 0.3
    assert case.interfaces["joint"].normal.c_factor == 1.0
    assert case.expect["probe.corner"].value == -0.002
    assert (case.axes, case.strain, case.solver.tolerance) == (2, "finite", 1e-10)


def test_both_pairs_of_moduli_describe_the_same_material():
    rubber, steel = (read_case(TWO).materials[name] for name in ("rubber", "steel"))
    assert (rubber.K, rubber.mu, steel.E, steel.nu) == (20e6, 1e6, 210e9, 0.3)
    for m in (rubber, steel):
        assert pytest.approx(m.K, rel=1e-14) == m.E / (3 * (1 - 2 * m.nu))
        assert pytest.approx(m.mu, rel=1e-14) == m.E / (2 * (1 + m.nu))
    assert steel.K == pytest.approx(175e9, rel=1e-14)
    assert rubber.nu == pytest.approx(58 / 122, rel=1e-14)


def test_cases_are_frozen():
    case = read_case(TWO)
    with pytest.raises(ValueError, match="frozen"):
        case.title = "x"


def test_overrides_reach_everything():
    case = read_case(
        TWO,
        [
            "title=two words",
            'time.end="2 s"',
            "time.step=0.5 s",
            "conditions.2.pressure = 2 bar",
            "conditions.0.displacement.y=1 mm",
            'conditions.3={on="lower", body_force.y="1 N/m^3"}',
            'expect."probe.corner".abs="1 um"',
        ],
    )
    assert (case.title, case.time.end, case.time.step) == ("two words", 2.0, 0.5)
    assert case.conditions[2].pressure == constant(2e5)
    assert case.conditions[0].displacement == {"x": constant(0.0), "y": constant(0.001)}
    assert case.conditions[3].body_force == {"y": constant(1.0)}
    assert case.expect["probe.corner"].abs == 1e-6


def test_another_builder_replaces_the_whole_mesh():
    wave = (
        'bodies.upper.mesh={builder="wave", width="10 mm", height="10 mm", nx=8, ny=2, '
        'corner=["5 mm", "10.5 mm"], amplitude="1 mm", wavelength="10 mm"}'
    )
    assert read_case(TWO, [wave]).bodies["upper"].mesh.builder == "wave"


def test_another_file_keeps_the_other_keys_of_the_mesh():
    """A table with a unit of its own is whole, and so is one with a builder."""
    first = 'bodies.upper.mesh={file="coarse.msh", unit="mm", body="part", merge="1 um"}'

    def mesh(*changes):
        raw = tomllib.loads(TWO.read_text())
        for change in (first, *changes):
            raw = override(raw, change)
        table = raw["bodies"]["upper"]["mesh"]
        return {key: value for key, value in table.items() if key != "file"}, table.get("file")

    kept = {"unit": "mm", "body": "part", "merge": "1 um"}
    assert mesh("bodies.upper.mesh.file=fine.msh") == (kept, "fine.msh")
    assert mesh('bodies.upper.mesh={file="fine.msh", body="b"}') == (
        kept | {"body": "b"},
        "fine.msh",
    )
    assert mesh('bodies.upper.mesh={file="fine.msh", unit="m"}') == ({"unit": "m"}, "fine.msh")
    assert mesh('bodies.upper.mesh={builder="block"}') == ({"builder": "block"}, None)


def test_a_file_with_a_byte_order_mark(tmp_path):
    path = tmp_path / "case.toml"
    path.write_bytes(b"\xef\xbb\xbf" + TWO.read_bytes())
    assert read_case(path).title == read_case(TWO).title


def test_variants_change_the_case_and_its_expectations():
    base = read_case(TWO)
    free = read_case(TWO, variant="frictionless")
    assert free.interfaces["joint"].friction is None
    assert (len(base.expect), len(free.expect)) == (2, 0)
    fine = read_case(TWO, ["bodies.upper.mesh.ny=7"], variant="fine")
    assert (fine.bodies["upper"].mesh.nx, fine.bodies["upper"].mesh.ny) == (30, 7)
    assert fine.conditions[3].body_force == {"y": constant(-78500.0)}
    assert len(fine.expect) == 2
    assert base.bodies["upper"].mesh.nx == 3


@pytest.mark.parametrize(
    ("variant", "line"),
    [
        ("fin = {}", "variants: there is no 'fine'; did you mean 'fin'?"),
        ("fine.tim.end = '1 s'", "tim: unknown key; did you mean 'time'?"),
        ('fine."a b" = 3', "variants.fine.a b: is not a dotted key"),
        ('fine."conditions.9.on" = 3', "variants.fine.conditions.9: must be an index from 0 to 3"),
        ("fine.base_expect = 1", "variants.fine.base_expect: must be true or false"),
        ("fine.expect = 1", "variants.fine.expect: must be a table"),
    ],
)
def test_variants_that_are_wrong(folder, variant, line):
    path = folder / "case.toml"
    text = path.read_text().partition("[variants")[0]
    path.write_text(f"{text}\n[variants]\n{variant}\n")
    assert complaints(path=path, variant="fine") == [line]


def test_an_obstacle_is_at_rest_unless_told():
    case = read_case(BLOCK)
    plane = case.obstacles["plane"]
    assert plane.displacement == {"x": constant(0.0), "y": constant(0.0)}
    moved = read_case(BLOCK, ["obstacles.plane={displacement={y='1 mm'}, normal=[0,2]}"])
    assert moved.obstacles["plane"].displacement == {"x": constant(0.0), "y": constant(0.001)}
    assert moved.obstacles["plane"].normal == (0.0, 1.0)


def test_the_block_has_the_data_of_its_source():
    case = read_case(BLOCK)
    steel = case.materials["steel"]
    assert (steel.E, steel.nu, case.strain) == (1.3e11, 0.2, "small")
    assert case.conditions[1].at == (0.04, 0.0)
    pushed, pressed = (condition.traction for condition in case.conditions[2:])
    assert pushed == {"y": Table((0.0, 1.0), (0.0, -5e7))}
    assert pressed == {"x": Table((0.0, 1.0), (0.0, 15e7))}
    assert read_case(BLOCK, variant="ten_steps").time.step == 0.1


@pytest.mark.parametrize("path", sorted((ROOT / "cases").rglob("*.toml")), ids=lambda p: p.stem)
def test_every_case_file_and_variant_is_right(path):
    for variant in (None, *read_case(path).variants):
        read_case(path, variant=variant)


def test_closed_forms_are_those_of_the_references():
    names = ClosedForm.model_json_schema()["properties"]["solution"]["enum"]
    assert sorted(names) == sorted(CLOSED_FORMS)


def test_equal_values_at_a_common_point_do_not_contradict():
    same = 'conditions.3={on="lower.left", displacement.x="0 m"}'
    assert len(read_case(TWO, [same]).conditions) == 4


KEYS = [
    "title", "references", "dimension", "strain", "time", "time.end", "time.step", "materials",
    "materials.rubber", "materials.rubber.shear_modulus", "materials.steel.model",
    "materials.steel.parameters", "bodies", "bodies.upper", "bodies.upper.mesh",
    "bodies.upper.mesh.builder", "bodies.upper.mesh.nx", "bodies.upper.mesh.corner",
    "bodies.upper.mesh.cell", "bodies.upper.temperature", "obstacles.wall",
    "obstacles.wall.shape", "interfaces", "interfaces.joint", "interfaces.joint.mortar",
    "interfaces.joint.friction", "interfaces.joint.friction.coefficient",
    "interfaces.joint.search_radius", "conditions", "conditions.0", "conditions.0.on",
    "conditions.0.displacement", "conditions.0.displacement.x", "conditions.1.grip",
    "conditions.1.grip.force", "conditions.2.pressure", "conditions.2.at", "probes.corner.at",
    "probes.corner.value", "closed_form", "closed_form.joint", "closed_form.joint.parameters",
    "closed_form.joint.solution", "solver", "solver.petsc", "output.times", "expect", "expect.x",
    "expect.x.value", "variants", "variants.fine", "zz", '"a.b"."c d"',
]  # fmt: skip
VALUES = st.sampled_from(
    [
        "0", "-1", "1e400", "nan", "-inf", "true", "false", '""', '"x"', '"1 mm"', '"-1 Pa"', "[]",
        "{}", "[[]]", "[{}]", "[1]", '["1 m"]', '["1 m", "2 m"]', '[["0 s","0 m"],["1 s","1 m"]]',
        '{x="1 m"}', '{solution="uniform"}', '{builder="block"}', '{file="."}', '{file=3}',
        '{file="case.toml", unit="mm"}', "1979-05-27T07:32:00Z", "07:32:00", '"upper.bottom"',
        '"lower"', '"plane"', '"3d"', '"é"', "9" * 400, '{shape=[]}', '{shape="circle"}',
        '{builder=[]}', '{on={}}', '{""=1}', '"a.py:b"', '"\\u0000"', '"\\u0000.py:f"',
    ]
)  # fmt: skip


@settings(max_examples=400, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(KEYS), VALUES), min_size=1, max_size=3))
def test_nonsense_never_gives_a_traceback(changes):
    try:
        case = read_case(TWO, [f"{key}={value}" for key, value in changes])
    except CaseError as error:
        assert all(line.startswith(f"{TWO}: ") for line in str(error).splitlines())
    else:
        assert math.isfinite(case.time.end)


TYPES = {"object": dict, "array": list, "string": str, "boolean": bool, "integer": int}


def fits(value, part, schema):
    """Whether a value is what a JSON schema allows, as far as ours use the language."""
    if "$ref" in part:
        return fits(value, schema["$defs"][part["$ref"].rpartition("/")[2]], schema)
    for key, count in (("anyOf", any), ("oneOf", lambda found: sum(found) == 1)):
        if key in part:
            return count([fits(value, choice, schema) for choice in part[key]])
    kind = part.get("type")
    if kind == "null":
        return value is None
    if kind == "number" and not isinstance(value, int | float):
        return False
    if not isinstance(value, TYPES.get(kind, object)):
        return False
    if value != part.get("const", value) or value not in part.get("enum", [value]):
        return False
    if isinstance(value, list):
        items = part.get("prefixItems", [part.get("items", {})] * len(value))
        enough = part.get("minItems", 0) <= len(value) <= part.get("maxItems", 10**9)
        return enough and all(fits(v, p, schema) for v, p in zip(value, items, strict=False))
    if isinstance(value, dict):
        return table_fits(value, part, schema)
    return True


def table_fits(value, part, schema):
    rest = part.get("additionalProperties", {})
    for key, item in value.items():
        matching = [p for k, p in part.get("patternProperties", {}).items() if re.match(k, key)]
        inner = part.get("properties", {}).get(key, matching[0] if matching else rest)
        if inner is False or not (inner is True or fits(item, inner, schema)):
            return False
    return set(part.get("required", [])) <= value.keys()


@pytest.mark.parametrize("path", [TWO, *sorted((ROOT / "cases").rglob("*.toml"))], ids=str)
def test_case_files_fit_the_schema(path):
    assert fits(tomllib.loads(path.read_text()), Case.model_json_schema(), Case.model_json_schema())


@pytest.mark.parametrize(
    "change",
    [
        'titel="x"',
        "time.end=1",
        "bodies.upper.mesh.nx=2.5",
        'bodies.upper.mesh.builder="blok"',
        "conditions.0.displacement=[1]",
        'interfaces.joint.friction.law="x"',
        'interfaces."a b"=3',
        'obstacles.a={shape="x"}',
    ],
)
def test_the_schema_refuses_mistakes(change):
    raw = override(tomllib.loads(TWO.read_text()), change)
    schema = Case.model_json_schema()
    assert not fits(raw, schema, schema) or change.startswith("interfaces.")
    complaints(change)


def test_the_schema_is_for_editors():
    schema = Case.model_json_schema()
    assert set(schema["required"]) == {"title", "time", "materials", "bodies"}
    assert "path" not in schema["properties"]
    modulus = schema["$defs"]["Material"]["properties"]["shear_modulus"]["anyOf"][0]
    assert modulus["type"] == "string"
    assert modulus["examples"] == ["210 GPa"]
    tables = [part for part in schema["$defs"].values() if part.get("type") == "object"]
    assert len(tables) >= 15
    assert all(part["additionalProperties"] is False for part in tables)
    assert all(part.get("description") for part in tables)
