"""What `check` says about a case, and the gaps it measures."""

from pathlib import Path

import numpy as np
import pytest

from contactfem.case.obstacles import Circle, Plane
from contactfem.case.read import read_case
from contactfem.check.check import check_case, describe, held, outlines
from contactfem.check.initial_gaps import obstacle_gap, surface_gap
from contactfem.check.resolved_values import listing
from contactfem.errors import CaseError
from contactfem.meshes import MeshData
from contactfem.output.mesh_files import write_msh

ROOT = Path(__file__).resolve().parents[3]
TWO = ROOT / "tests/data/two_blocks.toml"
BLOCK = ROOT / "cases/block.toml"

UNIT_BLOCK = '{builder="block", width="1 m", height="1 m", nx=1, ny=1}'
BOTTOM = np.array([[0.0, 1.0], [2.0, 1.0]])
TOP = np.array([[3.0, 0.25], [-1.0, 0.25]])


def arc(radius, center, start, end, n=400):
    angle = np.linspace(start, end, n)
    return np.array(center) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def test_gap_between_parallel_lines():
    assert surface_gap(BOTTOM, TOP) == pytest.approx(0.75, rel=1e-14)
    assert surface_gap(TOP, BOTTOM) == pytest.approx(0.75, rel=1e-14)


def test_gap_is_negative_where_bodies_overlap():
    assert surface_gap(BOTTOM, TOP + np.array([0.0, 0.8])) == pytest.approx(-0.05, rel=1e-12)


def test_no_gap_where_surfaces_do_not_face_each_other():
    assert surface_gap(BOTTOM, TOP[::-1]) is None
    assert surface_gap(BOTTOM, TOP + np.array([10.0, 0.0])) is None


def test_gap_below_a_cylinder_is_found_between_the_nodes():
    cylinder = arc(8.0, (0.0, 8.3), np.pi, 2 * np.pi)
    assert surface_gap(cylinder, np.array([[9.0, 0.0], [-9.0, 0.0]])) == pytest.approx(
        0.3, abs=1e-4
    )
    # the flat line is nonmortar and has no node below the cylinder
    assert surface_gap(np.array([[9.0, 0.0], [-9.0, 0.0]]), cylinder) == pytest.approx(
        0.3, abs=1e-4
    )


def test_gap_to_obstacles():
    plane = Plane(shape="plane", point=(0.0, 0.5), normal=(0.0, 2.0))
    assert obstacle_gap(BOTTOM, plane) == pytest.approx(0.5, rel=1e-14)
    disk = Circle(shape="circle", center=(1.0, 0.0), radius=0.9)
    assert obstacle_gap(BOTTOM, disk) == pytest.approx(0.1, rel=1e-12)  # in the middle of the line
    hollow = Circle(shape="circle", center=(1.0, 1.0), radius=1.2, inside=True)
    assert obstacle_gap(BOTTOM, hollow) == pytest.approx(0.2, rel=1e-12)


def test_the_whole_text():
    text = check_case(read_case(TWO))
    for line in (
        "A small block pressed onto a larger one",
        "  mechanics  plane strain, finite strain, without inertia",
        "  contact    on: 1 interface",
        "  friction   on: Coulomb 0.3 (joint)",
        "  heat       off; temperature given in lower",
        "  not used   density",
        "  variants   frictionless, fine",
        "  joint  upper.bottom (nonmortar) on lower.top (mortar): gap 0.5 mm",
        "         10 mm x 10 mm, lower corner (0.005, 0.0105) m",
        "         free in x: held only by contact through 'joint'",
        "         held by its conditions",
    ):
        words = [" ".join(row.split()) for row in text.splitlines()]
        assert " ".join(line.split()) in words, line
    assert text.startswith(describe(read_case(TWO)))


def test_bodies_that_nothing_holds_are_found():
    case = read_case(TWO, [f'bodies.loose={{material="steel", mesh={UNIT_BLOCK}}}'])
    lines = outlines(case)
    assert held(case, "loose", lines["loose"]) == (
        "WARNING: free in x, y, rotation: nothing holds it"
    )
    gripped = 'conditions.3={on="loose.top", grip={force={x="0 N/m", y="1 N/m"}}}'
    loose = f'bodies.loose={{material="steel", mesh={UNIT_BLOCK}}}'
    case = read_case(TWO, [loose, gripped])
    assert held(case, "loose", outlines(case)["loose"]) == "WARNING: free in x, y: nothing holds it"


def test_a_load_above_the_stiffness_is_doubted():
    text = check_case(read_case(TWO, ['conditions.2.pressure="6 MPa"']))
    assert (
        "conditions.2.pressure: 6 MPa is 2.03 times Young's modulus of 'rubber'; is the unit right?"
    ) in text
    assert text.count("doubtful") == 1
    assert "doubtful" not in check_case(read_case(TWO, ['conditions.2.pressure="2.9 MPa"']))


def test_touching_and_overlapping_obstacles():
    text = check_case(read_case(BLOCK))
    assert "  sole  block.bottom (nonmortar) on plane (mortar): touching" in text.splitlines()
    text = check_case(read_case(BLOCK, ['obstacles.plane.point=["0 m", "1 um"]']))
    assert "overlap 1 µm" in text
    assert "         held by its conditions" in text.splitlines()


def test_every_value_and_every_default_is_listed():
    rows = {key: (value, default) for key, value, default in listing(read_case(TWO))}
    assert rows["time.end"] == ("1 s", False)
    assert rows["time.step_max"] == ("0.25 s", True)
    assert rows["materials.rubber.shear_modulus"] == ("1000000 Pa", False)
    assert rows["materials.rubber.expansion"] == ("0 1/K", True)
    assert rows["bodies.upper.mesh.corner"] == ("(0.005, 0.0105) m", False)
    assert rows["bodies.lower.temperature"] == ("40 K", False)
    assert rows["conditions.0.displacement.x"] == ("0 m", False)
    assert rows["conditions.1.grip.displacement.y"] == ("0 m at 0 s, -0.002 m at 1 s", False)
    assert rows["conditions.1.grip.force.x"] == ("50000 N/m", False)
    assert rows["conditions.2.pressure"] == ("10000 Pa", False)
    assert rows["interfaces.joint.friction.c_factor"] == ("1", True)
    assert rows["solver.tolerance"] == ("1e-10", True)


def test_gaps_of_surfaces_in_several_chains():
    """A row of NaN keeps chains apart; the last point of the first one counts as well."""
    chains = np.array([[0.0, 2.0], [1.0, 1.5], [np.nan, np.nan], [2.0, 1.75], [3.0, 2.0]])
    plane = Plane(shape="plane", point=(0.0, 0.0), normal=(0.0, 1.0))
    assert obstacle_gap(chains, plane) == pytest.approx(1.5, rel=1e-14)
    floor = np.array([[3.0, 0.25], [-1.0, 0.25]])
    assert surface_gap(chains, floor) == pytest.approx(1.25, rel=1e-14)
    assert surface_gap(floor, chains) == pytest.approx(1.25, rel=1e-14)


@pytest.fixture
def with_file(tmp_path):
    """The sample, its upper body from a mesh file."""
    case = read_case(TWO)
    write_msh(case.bodies["upper"].mesh.build(), tmp_path / "upper.msh")
    (tmp_path / "case.toml").write_text(TWO.read_text())
    return tmp_path / "case.toml"


FROM_FILE = 'bodies.upper.mesh={file="upper.msh", unit="m"}'


def test_a_mesh_file_is_looked_into(with_file):
    case = read_case(with_file, [FROM_FILE])
    text = check_case(case)
    assert "(mortar): gap 0.5 mm" in text
    assert "         surfaces left, right, bottom, top" in text.splitlines()
    data, built = case.bodies["upper"].mesh.build(), read_case(TWO).bodies["upper"].mesh.build()
    assert data.points == pytest.approx(built.points, abs=1e-15)
    assert {k: len(v) for k, v in data.groups.items()} == {
        k: len(v) for k, v in built.groups.items()
    }


def test_a_mesh_in_pieces_is_doubted(with_file):
    data = read_case(TWO).bodies["upper"].mesh.build()
    apart = MeshData(
        np.concatenate((data.points, data.points + 1.0)),
        np.concatenate((data.cells, data.cells + len(data.points))),
        data.cell_type,
        data.groups,
    )
    assert " pieces;" not in check_case(read_case(with_file, [FROM_FILE]))
    write_msh(apart, with_file.parent / "upper.msh")
    warning = "WARNING: in 2 pieces; 'body' takes one group of cells of a file"
    assert warning in check_case(read_case(with_file, [FROM_FILE]))


def test_groups_that_a_mesh_file_lacks(with_file):
    case = read_case(with_file, [FROM_FILE, 'conditions.2.on="upper.lft"'])
    with pytest.raises(CaseError) as caught:
        check_case(case)
    assert str(caught.value) == (
        f"{with_file}: conditions.2.on = upper.lft: 'upper' has no surface 'lft' with facets; "
        "did you mean 'left'?"
    )


def test_a_surface_without_facets(with_file):
    mesh = with_file.parent / "upper.msh"
    text = mesh.read_text().replace('"bottom"', '"base"')
    mesh.write_text(text)
    with pytest.raises(
        CaseError, match=r"interfaces\.joint\.nonmortar = upper\.bottom: 'upper' has"
    ):
        check_case(read_case(with_file, [FROM_FILE]))


def test_sides_are_chosen_of_mesh_files(with_file):
    """As of the builder's mesh; a surface that the file lacks is named."""
    between = 'interfaces.joint.between=["upper.bottom", "lower.top"]'
    built = read_case(TWO, [between]).interfaces["joint"]
    found = read_case(with_file, [FROM_FILE, between]).interfaces["joint"]
    assert found.why
    assert (found.nonmortar, found.why) == (built.nonmortar, built.why)
    with pytest.raises(CaseError) as caught:
        read_case(with_file, [FROM_FILE, between.replace("bottom", "botom")])
    assert str(caught.value) == (
        f"{with_file}: interfaces.joint.between = upper.botom: 'upper' has no surface 'botom' with "
        "facets; did you mean 'bottom'?"
    )


def test_a_surface_in_several_chains_holds_its_body(with_file):
    """Conditions and interfaces on both sides of a body at once, as a mesh file may group them."""
    mesh = with_file.parent / "upper.msh"
    mesh.write_text(mesh.read_text().replace('"left"', '"ends"'))
    lines = mesh.read_text().splitlines()
    names = {line.split('"')[1]: line.split()[1] for line in lines if '"' in line}
    left, right = names["ends"], names["right"]
    moved = [
        line.replace(f" 2 {right} ", f" 2 {left} ") if line.split()[1:2] == ["1"] else line
        for line in lines
    ]
    mesh.write_text("\n".join(moved) + "\n")
    hold = "conditions=[{on='upper.ends', displacement=['0 m', '0 m']}]"
    ends = {"interfaces.joint.nonmortar": "upper.ends", "interfaces.joint.mortar": "wall"}
    wall = "obstacles.wall={shape='plane', point=['0 m', '0 m'], normal=[0, 1]}"
    changes = [FROM_FILE, hold, wall, *(f"{key}={value}" for key, value in ends.items())]
    text = check_case(read_case(with_file, changes))
    assert "held by its conditions" in text
    assert "upper.ends (nonmortar) on wall (mortar): gap 10.5 mm" in text


def test_control_characters_do_not_reach_the_terminal():
    case = read_case(TWO, ['title="a\\u001b[31m"'])
    assert check_case(case).startswith("a\\x1b[31m\n")
    with pytest.raises(CaseError) as caught:
        read_case(TWO, ['bodies.upper.material="a\\nb\\u2028c"'])
    assert "there is no material 'a\\nb\\u2028c'" in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("content", [b"", b"nothing like a mesh", b"$MeshFormat\n2.2 0 8\n"])
def test_files_that_are_not_meshes(with_file, content):
    (with_file.parent / "upper.msh").write_bytes(content)
    with pytest.raises(CaseError) as caught:
        check_case(read_case(with_file, [FROM_FILE]))
    assert str(caught.value).startswith(f"{with_file}: bodies.upper.mesh: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("path", sorted((ROOT / "cases").rglob("*.toml")), ids=lambda p: p.stem)
def test_every_case_file_can_be_described(path):
    text = check_case(read_case(path))
    locks = path.stem == "near_incompressible"  # quadrilaterals of K/mu = 1e4, on purpose
    assert ("WARNING" in text) == locks
