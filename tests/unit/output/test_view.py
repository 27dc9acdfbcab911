"""The page that shows fields, what it is made of, and pictures where pyvista is installed."""

import base64
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from contactfem.cli.main import main
from contactfem.errors import CaseError
from contactfem.output.view.page import NAN, scene, write_view
from contactfem.output.view.pictures import draw, has_pyvista
from contactfem.output.view.reader import FieldReader, outer_triangles
from contactfem.output.vtkhdf import Block, VtkHdfFile

pytest.importorskip("h5py")


def brick(n):
    """Points and hexahedra of a unit cube, dolfinx order."""
    s = np.linspace(0, 1, n + 1)
    z, y, x = np.meshgrid(s, s, s, indexing="ij")
    number = np.arange((n + 1) ** 3).reshape(n + 1, n + 1, n + 1)
    corners = [
        number[a : n + a, b : n + b, c : n + c].ravel()
        for a in (0, 1) for b in (0, 1) for c in (0, 1)
    ]  # fmt: skip
    return np.column_stack((x.ravel(), y.ravel(), z.ravel())), np.column_stack(corners)


@pytest.fixture
def run(tmp_path):
    """Folder of a run of a cube and its upper face over 60 steps, on a mesh that changes once."""
    file = VtkHdfFile(tmp_path / "fields.vtkhdf", None)
    for k in range(60):
        points, cells = brick(3 if k < 50 else 4)
        t = (k + 1) / 60
        stress = np.zeros((len(points), 6))
        stress[:, 1] = -t * points[:, 1]
        fields = {"displacement": -t * points / 10, "stress": stress, "von_mises": t * points[:, 1]}
        top = points[points[:, 1] == 1.0]
        line = np.column_stack((np.arange(len(top) - 1), np.arange(1, len(top))))
        gap = np.where(top[:, 0] > 0.5, np.nan, t)
        surface = {"displacement": 0 * top, "pressure": t * top[:, 0], "gap": gap}
        file.append(
            t,
            [
                Block("cube", points, cells, "hexahedron", fields),
                Block("sole", top, line, "interval", surface),
            ],
        )
    return tmp_path


def unpacked(text, kind):
    return np.frombuffer(base64.b64decode(text), kind)


@pytest.mark.parametrize("n", [1, 2, 5])
def test_a_cube_is_seen_by_its_six_faces(n):
    points, cells = brick(n)
    triangles, edges = outer_triangles(cells[:, [0, 1, 3, 2, 4, 5, 7, 6]], 12)
    a, b, c = points[triangles.T]
    normals = np.cross(b - a, c - a)
    assert np.linalg.norm(normals, axis=1).sum() / 2 == pytest.approx(6.0)
    middle = (a + b + c) / 3 - 0.5
    assert (np.einsum("ij,ij->i", middle, normals) > 0).all()  # outward
    assert len(edges) == 12 * n * n


def test_two_tetrahedra_hide_the_face_between_them():
    triangles, edges = outer_triangles(np.array([[0, 1, 2, 3], [1, 2, 3, 4]]), 10)
    assert len(triangles) == 6 and len(edges) == 9
    assert [1, 2, 3] not in np.sort(triangles, axis=1).tolist()


def test_the_page_carries_the_fields(run):
    data = scene(FieldReader(run))
    assert data["all"] == 60 and len(data["times"]) == 40
    assert (data["times"][0], data["times"][-1]) == (1 / 60, 1.0)
    cube, sole = data["blocks"]
    assert (cube["name"], sole["name"]) == ("cube", "sole")
    assert [m["mesh"] for m in cube["frames"]] == sorted(m["mesh"] for m in cube["frames"])
    assert len(cube["meshes"]) == 2
    last = cube["frames"][-1]
    x = unpacked(cube["meshes"][last["mesh"]]["points"], np.float32).reshape(-1, 3)
    found = last["fields"]["von_mises"]
    values = found["low"] + (found["high"] - found["low"]) * unpacked(found["data"], "u2") / 65534
    assert np.allclose(values, x[:, 1], atol=2e-5)
    assert np.allclose(unpacked(last["u"], np.float32).reshape(-1, 3), -x / 10)
    assert cube["units"]["stress.yy"] == "Pa"
    gap = unpacked(sole["frames"][-1]["fields"]["gap"]["data"], "u2")
    assert (gap == NAN).any() and not (gap == NAN).all()


def test_the_page_needs_nothing_from_elsewhere(run):
    page = write_view(run).read_text()
    assert not re.search(r"""(src|href)\s*=\s*["']?(https?:)?//|@import|url\(""", page)
    data = re.search(r'<script id="data" type="application/json">(.*?)</script>', page, re.S)
    assert json.loads(data[1].replace("<\\/", "</"))["all"] == 60


def test_the_command_says_where_the_page_is(run, capsys, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert main(["view", str(run)]) == 0
    assert capsys.readouterr().out == f"{run / 'view.html'}\n"
    assert (run / "view.html").stat().st_size > 10_000


def test_a_run_without_fields_is_told(tmp_path, capsys):
    assert main(["view", str(tmp_path)]) == 2
    assert "has no fields.vtkhdf; output.fields = true" in capsys.readouterr().err
    (tmp_path / "fields.vtkhdf").write_bytes(b"not HDF5")
    assert main(["view", str(tmp_path)]) == 2
    assert "is not a file of fields" in capsys.readouterr().err


def test_pictures_without_pyvista_are_told(run, monkeypatch):
    monkeypatch.setattr("contactfem.output.view.pictures.has_pyvista", lambda: False)
    with pytest.raises(CaseError, match=r"pip install 'contactfem\[view\]'"):
        draw(run, window=False)


def test_looking_at_a_page_loads_no_pyvista(run):
    program = (
        f"import sys; from contactfem.cli.main import main; main(['view', {str(run)!r}, '--out', "
        f"{str(run / 'a.html')!r}]); assert not {{'pyvista', 'dolfinx', 'matplotlib'}} & "
        "set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", program], check=True, stdout=subprocess.DEVNULL)


@pytest.mark.skipif(not has_pyvista(), reason="pyvista is not installed")
def test_pictures_are_drawn(run):
    found = draw(run, window=False)
    assert [path.name for path in found] == ["view_von_mises.png", "view_pressure.png"]
    assert all(Path(path).stat().st_size > 10_000 for path in found)
