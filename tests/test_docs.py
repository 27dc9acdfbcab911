"""The documentation is true: its examples run, its quotations are exact, its tables are fresh."""

import json
import re
import runpy
import shutil
import subprocess
import sys
from math import log
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from contactfem.cli.key_reference import case_schema, reference_page
from contactfem.cli.main import main
from contactfem.meshes.size_field import SizeField

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
EXAMPLES = DOCS / "examples"


@pytest.fixture
def examples(tmp_path):
    """Copy the examples to where they may be changed."""
    return shutil.copytree(EXAMPLES, tmp_path / "examples")


@pytest.fixture
def laws():
    return runpy.run_path(str(EXAMPLES / "laws.py"))


def run(path, *changes, out=None):
    """Run a case file quietly and return its results."""
    from mpi4py import MPI

    from contactfem.case.read import read_case
    from contactfem.run.driver import run_case

    result = run_case(read_case(path, changes), MPI.COMM_SELF, out)
    assert result.converged, result.message
    return result


def replaced(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def test_the_keys_are_those_of_the_models():
    assert (DOCS / "case_file.md").read_text() == reference_page() + "\n", (
        "./run contactfem schema --markdown > docs/case_file.md"
    )


def test_every_key_has_a_description():
    schema = case_schema()
    tables = {"Case": schema, **schema["$defs"]}
    bare = [
        f"{name}.{key}"
        for name, table in tables.items()
        for key, value in table.get("properties", {}).items()
        if not value.get("description")
    ]
    assert bare == [], "give them Field(description=...)"


def test_the_schema_explains_keys():
    schema = case_schema()
    assert schema["$defs"]["Block"]["properties"]["nx"]["description"] == "cells in x"
    length = schema["$defs"]["Block"]["properties"]["width"]["description"]
    assert length == "size in x: a length such as '10 mm'"
    modulus = schema["$defs"]["Material"]["properties"]["bulk_modulus"]
    assert modulus["description"] == "bulk modulus K; give it with `shear_modulus`"
    assert schema["properties"]["time"]["description"] == "end of the run and its steps"
    time = schema["properties"]["time"]
    assert time["allOf"] == [{"$ref": "#/$defs/Time"}]


def quotations():
    """Pages, files that they quote, and what they quote of them."""
    for page in sorted(DOCS.glob("*.md")):
        found = re.findall(r"<!-- (\S+) -->\n+```\w*\n(.*?)```", page.read_text(), re.DOTALL)
        yield from (
            pytest.param(DOCS / name, text, id=f"{page.stem}-{name}") for name, text in found
        )


@pytest.mark.parametrize(("path", "text"), quotations())
def test_quotations_are_exact(path, text):
    assert text in path.read_text()


def test_every_python_block_is_a_quotation():
    for page in DOCS.glob("*.md"):
        text = page.read_text()
        blocks = re.findall(r"(-->\n+)?```python", text)
        assert all(blocks), f"{page.name} shows code that no test runs"


def test_the_tutorial(tmp_path):
    for name in ("brake.py", "brake.toml"):
        shutil.copy(DOCS / "tutorial" / name, tmp_path)
    subprocess.run([sys.executable, "brake.py"], cwd=tmp_path, check=True, timeout=60)
    out = tmp_path / "runs"
    changes = ["--set", "output.fields=false"]
    assert main(["run", str(tmp_path / "brake.toml"), "--out", str(out), *changes]) == 0
    summary = json.loads((out / "summary.json").read_text())
    assert sum(step["cutbacks"] for step in summary["steps"]) == 0
    for step in summary["steps"][3:]:
        x, y = step["forces"]["rub"]
        assert -x / y == pytest.approx(0.35, rel=1e-3)
        assert step["heat"]["friction"] == pytest.approx(step["dissipation"], rel=1e-12)
    pressed = [-step["forces"]["rub"][1] for step in summary["steps"][3:]]
    assert (np.diff(pressed) > 0).all()  # the pad swells between its back and the rail


def test_the_example_from_python(capsys):
    runpy.run_path(str(EXAMPLES / "api.py"))
    said = capsys.readouterr().out.splitlines()
    assert said[3].startswith("t = 1.00 s  largest pressure 12")
    assert said[4] == "2 1e-05"


def energy(stretch, height, K, mu, share):
    """Energy of the solid of Mooney and Rivlin in plane strain, by its principal stretches."""
    J = stretch * height
    a, b, c = (s**2 * J ** (-2 / 3) for s in (stretch, height, 1.0))
    c2 = share * mu / 2
    return (mu / 2 - c2) * (a + b + c - 3) + c2 * (a * b + b * c + c * a - 3) + K / 2 * log(J) ** 2


def slope(function, x, h=1e-5):
    return (function(x + h) - function(x - h)) / (2 * h)


def test_a_material_of_ones_own(examples):
    """Uniform compression between smooth plates, against the energy in principal stretches."""
    path = examples / "pressed.toml"
    replaced(path, 'friction = { law = "laws.py:capped_friction" }', "")
    rows = 'displacement.x = [["0 s", "0 mm"], ["1 s", "0 mm"], ["2 s", "8 mm"]]\n'
    replaced(path, rows, "")
    still = '[[conditions]]\non = "block.top"\n'
    middle = '[[conditions]]\non = "block"\nat = ["10 mm", "10 mm"]\ndisplacement.x = "0 mm"\n'
    replaced(path, still, middle + still)
    result = run(path, "time.end='1 s'", "materials.rubber.parameters.share=0.4")
    numbers = (100e6, 10e6, 0.4)
    side = brentq(lambda s: slope(lambda z: energy(z, 0.9, *numbers), s), 1.0, 1.2, xtol=1e-12)
    force = slope(lambda z: energy(side, z, *numbers), 0.9) * 0.02
    assert result.steps[-1].forces["sole"][1] == pytest.approx(force, rel=1e-6)


def test_friction_of_ones_own(laws, examples):
    law = laws["capped_friction"]
    p = np.array([0.0, 1e3, 5e6, 2e7])
    b, by_pressure, by_speed = law(p, p, p)
    h = 10.0
    assert (by_speed == 0.0).all()
    assert by_pressure == pytest.approx(
        (law(p + h, p, p)[0] - law(p - h, p, p)[0]) / (2 * h), rel=1e-6
    )
    assert b[-1] < laws["LARGEST"]
    sole = run(examples / "pressed.toml").interfaces[0]
    slides = sole.status == 2
    assert slides.sum() == 8
    at_limit = law(sole.pressure, 0 * sole.pressure, 0 * sole.pressure)[0]
    assert np.abs(sole.traction[slides]) == pytest.approx(at_limit[slides], rel=1e-8)
    assert (np.abs(sole.traction) <= at_limit * (1 + 1e-9)).all()


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("return pressure", "laws.py:own: gives no limit with its two slopes"),
        ("return pressure, pressure, pressure[:2]", "laws.py:own: gives no limit"),
        ("return pressure, 1.0, 1.0 / 0.0", "ZeroDivisionError"),
        ("return pressure, 1.0, float('nan')", "laws.py:own: gives a value that is not finite"),
    ],
)
def test_friction_that_is_none(examples, capsys, body, said):
    (examples / "laws.py").write_text(f"def own(pressure, speed, temperature):\n    {body}\n")
    path = examples / "pressed.toml"
    replaced(path, "capped_friction", "own")
    assert main(["run", str(path), "--out", str(examples / "out")]) == 2
    assert said in capsys.readouterr().err


BARS = """
title = "Two bars, one on the other"
mechanics = false
time = { end = "1 s", step = "1 s" }
heat = { scheme = "steady" }
materials.steel = { youngs_modulus = "210 GPa", poisson_ratio = 0.3, conductivity = "45 W/m/K" }
[bodies]
lower.material = "steel"
lower.mesh = { builder = "block", width = "1 mm", height = "10 mm", nx = 2, ny = 5 }
upper.material = "steel"
upper.mesh.builder = "block"
upper.mesh.corner = ["0 mm", "10 mm"]
upper.mesh.width = "1 mm"
upper.mesh.height = "20 mm"
upper.mesh.nx = 3
upper.mesh.ny = 5
[interfaces.joint]
nonmortar = "upper.bottom"
mortar = "lower.top"
heat = { law = "laws.py:coated", pressure = "3 MPa" }
[[conditions]]
on = "lower.bottom"
temperature = "0 K"
[[conditions]]
on = "upper.top"
temperature = "100 K"
"""


def test_conductance_of_ones_own(laws, examples):
    """Resistances in series: two bars, spots in contact and a film."""
    (examples / "bars.toml").write_text(BARS)
    result = run(examples / "bars.toml")
    spots = laws["SPOTS"] * 3e6 / laws["HARDNESS"]
    resistance = 0.03 / 45.0 + 1.0 / spots + laws["FILM"]
    assert result.steps[-1].heat is not None
    assert result.steps[-1].heat.flow["joint"] == pytest.approx(100.0 / resistance * 1e-3, rel=1e-9)
    assert laws["coated"](np.zeros(1), np.ones(1)) == 0.0


def cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def test_a_builder_of_ones_own(examples):
    Trapezoid = runpy.run_path(str(EXAMPLES / "trapezoid.py"))["Trapezoid"]
    given = {"width": 0.02, "top_width": 0.012, "height": 0.01, "corner": (1.0, 2.0)}
    solid = Trapezoid(nx=6, ny=4, **given)
    mesh = solid.build()
    a, b, c, d = (mesh.points[mesh.cells[:, k]] for k in (0, 1, 3, 2))
    area = 0.5 * cross(c - a, d - b).sum()
    assert area == pytest.approx(0.5 * (0.02 + 0.012) * 0.01, rel=1e-12)
    for name, side in solid.outline().items():  # the mesh lies on its outline
        facets = mesh.points[mesh.groups[name]]
        along, ends = side[1] - side[0], facets.reshape(-1, 2) - side[0]
        assert np.abs(cross(along, ends)).max() < 1e-15
        assert np.linalg.norm(np.diff(facets, axis=1), axis=2).sum() == pytest.approx(
            np.linalg.norm(along), rel=1e-12
        )
    old = Trapezoid(nx=2, ny=2, cell="triangle", **given).build()
    fine = solid.adapted(SizeField(old.points, old.cells, np.full(len(old.points), 1e-3)))
    assert len(fine.cells) > 200
    assert {*fine.groups} == {*mesh.groups} == {"left", "right", "bottom", "top"}


def test_a_run_with_a_builder_of_ones_own(examples):
    """The narrow top of a trapezoid is pressed: the force is that of the same mesh from a file."""
    from mpi4py import MPI

    from contactfem.case.read import read_case
    from contactfem.output.mesh_files import write_msh
    from contactfem.run.driver import run_case

    Trapezoid = runpy.run_path(str(EXAMPLES / "trapezoid.py"))["Trapezoid"]
    solid = Trapezoid(width=0.02, top_width=0.012, height=0.01, nx=8, ny=4)
    case = read_case(examples / "pressed.toml", ["time.end='0.5 s'"])
    body = case.bodies["block"].model_copy(update={"mesh": solid})
    built = case.model_copy(update={"bodies": {"block": body}})
    force = run_case(built, MPI.COMM_SELF, None).steps[-1].forces["sole"][1]
    write_msh(solid.build(), examples / "block.msh")
    block = '{ builder = "block", width = "20 mm", height = "10 mm", nx = 8, ny = 4 }'
    replaced(examples / "pressed.toml", block, '{ file = "block.msh", unit = "m" }')
    again = run(examples / "pressed.toml", "time.end='0.5 s'").steps[-1].forces["sole"][1]
    assert force == pytest.approx(again, rel=1e-9)


def test_the_script(examples, tmp_path):
    found = subprocess.run(
        [sys.executable, "script.py", str(tmp_path / "out")],
        cwd=examples, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert found.returncode == 0, found.stderr
    lines = [line for line in found.stdout.splitlines() if line.startswith("t = ")]
    assert len(lines) == 8
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    x, y = summary["steps"][-1]["forces"]["sole"]
    assert lines[-1].endswith(f"{x:10.1f} {y:10.1f} N/m")
    assert (
        "0.5"
        in dict((k, v) for k, v, _ in summary["resolved"])["materials.rubber.parameters.share"]
    )
