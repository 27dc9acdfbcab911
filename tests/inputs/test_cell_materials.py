"""Several materials in one body, by groups of cells: layers, whose answers are exact."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from inputs.mesh_files import block, write_msh

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.cli.main import main
from contactfem.errors import ExitCode, Interrupted
from contactfem.run.driver import Invocation, run_case
from contactfem.run.resume import prepare

# Layers of 3 and 5 under a pressure, without lateral strain: p (h1/M1 + h2/M2) with the moduli of
# the oedometer, M = E (1 - nu) / ((1 + nu) (1 - 2 nu)); with nu = 0 M = E. Warm from below, the
# flux is q = dT / (h1/k1 + h2/k2), and the temperature between the layers T - q h1/k1.
LAYERS = """
title = "Two layers in one body"
strain = "small"
time = { end = "1 s", step = "1 s" }
output = { fields = false, figures = false }
heat = { scheme = "steady" }
[materials.hard]
youngs_modulus = "10 MPa"
poisson_ratio = 0.0
conductivity = "20 W/m/K"
[materials.soft]
youngs_modulus = "1 MPa"
poisson_ratio = 0.0
conductivity = "1 W/m/K"
[bodies.upper]
materials = { bottom = "hard", rest = "soft" }
mesh = { file = "layers.msh", unit = "mm" }
[obstacles.floor]
shape = "plane"
point = ["0 mm", "0 mm"]
normal = [0, 1]
[interfaces.foot]
nonmortar = "upper.sole"
mortar = "floor"
[[conditions]]
on = "upper.upper_left"
displacement.x = "0 mm"
[[conditions]]
on = "upper.top"
pressure = "10 kPa"
[[conditions]]
on = "upper.sole"
temperature = "0 K"
[[conditions]]
on = "upper.top"
temperature = "10 K"
[probes.between]
on = "upper"
at = ["6 mm", "4 mm"]
value = "temperature"
[expect] # 10 kPa (4 mm / 10 MPa + 4 mm / 1 MPa)
"foot.pressure_max" = { value = "10 kPa", rel = 1e-4 }
"upper.displacement_y.min" = { value = "-4.4e-2 mm", rel = 1e-4 }
"probe.between" = { value = "0.47619047619 K", rel = 1e-6 }
"""


def layers(folder: Path, quads: int = 0) -> Path:
    """A block of height 8 whose cells below 4 are a group of their own; and its case file."""
    whole = block("upper", 6, 4, 0.0, 8.0, quads)
    straight = np.stack(np.meshgrid(np.linspace(0, 12, 7), np.linspace(0, 8, 5)), axis=-1)
    points = straight.reshape(-1, 2)
    parts = []
    for name, low, high in (("bottom", 0, 4), ("rest", 4, 8)):
        inside = [
            rows[(low < points[rows].mean(axis=1)[:, 1]) & (points[rows].mean(axis=1)[:, 1] < high)]
            for rows in (whole.triangles, whole.quads)
        ]
        sides = whole.sides if name == "rest" else {}
        parts.append(replace(whole, name=name, points=points, sides=sides))
        parts[-1] = replace(parts[-1], triangles=inside[0], quads=inside[1])
    write_msh(folder / "layers.msh", (parts[0], parts[1]), shared=True)
    path = folder / "case.toml"
    path.write_text(LAYERS)
    return path


def run(path: Path, *changes: str) -> tuple[int, dict[str, object]]:
    out = path.parent / "out"
    sets = [word for change in changes for word in ("--set", change)]
    code = main(["run", str(path), "--out", str(out), *sets])
    return code, json.loads((out / "summary.json").read_text())


@pytest.mark.parametrize("quads", [0, 3, 9])
def test_layers(tmp_path: Path, quads: int) -> None:
    """Of triangles, of triangles and split quadrilaterals, of quadrilaterals."""
    code, summary = run(layers(tmp_path, quads))
    assert code == ExitCode.DONE, summary["verdicts"]


BOTH = 'materials = { bottom = "hard", rest = "soft" }'


def test_one_group_and_a_material_for_the_other_cells(tmp_path: Path) -> None:
    """With finite strain and a small load as well."""
    path = layers(tmp_path)
    one = 'materials = { bottom = "hard" }\nmaterial = "soft"'
    text = LAYERS.replace(BOTH, one).replace('strain = "small"\n', "")
    path.write_text(text.replace("10 kPa", "1 Pa").replace("-4.4e-2 mm", "-4.4e-6 mm"))
    code, summary = run(path)
    assert code == ExitCode.DONE, summary["verdicts"]


def test_two_names_of_one_incompressible_material(tmp_path: Path) -> None:
    """MINI elements with numbers by cell give what they give with one for all."""
    path = layers(tmp_path)
    text = LAYERS[: LAYERS.index("[probes")].replace("poisson_ratio = 0.0", "poisson_ratio = 0.49")
    text = text.replace("10 MPa", "1 MPa")
    lowest = []
    for materials in (BOTH, 'material = "hard"'):
        path.write_text(text.replace(BOTH, materials) + "[probes.top]\n" + PROBE)
        code, summary = run(path)
        assert code == ExitCode.DONE
        values = summary["values"]
        assert isinstance(values, dict)
        lowest.append(values["probe.top"])
    assert lowest[0] == pytest.approx(lowest[1], rel=1e-9)


PROBE = 'on = "upper"\nat = ["12 mm", "8 mm"]\nvalue = "displacement.y"\n'


def test_a_checkpoint_keeps_the_groups_of_cells(tmp_path: Path) -> None:
    """A run that is stopped after two steps of four goes on to the same answer."""
    path = layers(tmp_path)
    path.write_text(LAYERS.replace('step = "1 s"', 'step = "0.25 s"'))
    case, answers = read_case(path), iter([False, False, True])
    with pytest.raises(Interrupted):
        run_case(case, MPI.COMM_SELF, tmp_path / "out", Invocation("", 0.0, lambda: next(answers)))
    checkpoint = prepare(tmp_path / "out", ()).checkpoint
    assert checkpoint is not None
    result = run_case(case, MPI.COMM_SELF, None, resumed=checkpoint)
    assert len(result.steps) == 4
    assert result.probes["between"] == pytest.approx(10.0 / 21.0, rel=1e-6)


@pytest.mark.mpi
def test_layers_on_several_ranks(tmp_path: Path) -> None:
    """Numbers by cell reach the cells, and those that are ghosts, of every rank."""
    comm = MPI.COMM_WORLD
    folder = Path(comm.bcast(str(tmp_path)))
    if comm.rank == 0:
        layers(folder, 3)
    comm.Barrier()
    result = run_case(read_case(folder / "case.toml"), comm, None)
    if comm.rank == 0:
        assert result.probes["between"] == pytest.approx(10.0 / 21.0, rel=1e-6)
        assert result.interfaces[0].pressure == pytest.approx(1e4, rel=1e-4)


def test_check_says_which_cells_are_of_what(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", str(layers(tmp_path))]) == ExitCode.DONE
    said = capsys.readouterr().out
    assert "upper  hard (bottom): Hooke, E = 10 MPa" in said
    assert "         soft (rest): Hooke, E = 1 MPa" in said


BUILT = 'bodies.upper.mesh={builder="block", width="1 m", height="1 m", nx=1, ny=1}'


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ('bodies.upper.materials={bottm="hard"}', "bottm: there is no such group of cells; did"),
        ('bodies.upper.materials.bottom="hart"', "bottom = hart: there is no material 'hart'"),
        ('materials.soft.model="a.py:f"', "all must have one model, with the same parameters"),
        (BUILT, "needs groups of cells; mesh is of a builder"),
        ("adaptivity={tolerance=0.1}", "adaptivity makes new meshes without groups of cells"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("command", ["check", "run"])
def test_mistakes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str, change: str, words: str
) -> None:
    path = layers(tmp_path)
    (tmp_path / "a.py").write_text("f = None\n")
    assert main([command, str(path), "--set", change]) == ExitCode.BAD_CASE
    assert words in capsys.readouterr().err


def test_cells_without_a_material(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = layers(tmp_path)
    path.write_text(LAYERS.replace(BOTH, 'materials = { bottom = "hard" }'))
    assert main(["check", str(path)]) == ExitCode.BAD_CASE
    said = capsys.readouterr().err
    assert "bodies.upper.materials: 24 of 48 cells are in none of these groups; 'material'" in said


def test_a_body_of_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = layers(tmp_path)
    path.write_text(LAYERS.replace('materials = { bottom = "hard", rest = "soft" }\n', ""))
    assert main(["check", str(path)]) == ExitCode.BAD_CASE
    assert "must have 'material', or 'materials' by groups" in capsys.readouterr().err
