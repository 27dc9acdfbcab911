"""Broken and odd mesh files are read or refused, whatever their format is."""

from pathlib import Path

from fuzz.broken_meshes import mesh_files
from fuzz.examining import check
from hypothesis import given
from hypothesis import strategies as st

CASE = """
title = "A plate from a file on a wall"
time = {{ end = "1 s", step = "1 s" }}
materials.rubber = {{ shear_modulus = "1 MPa", bulk_modulus = "5 MPa" }}
bodies.plate = {{ material = "rubber", mesh = {{ file = "{file}", unit = "mm"{body} }} }}
obstacles.wall = {{ shape = "plane", point = ["0 m", "0 m"], normal = [0, 1] }}
interfaces.foot = {{ nonmortar = "plate.{foot}", mortar = "wall" }}
conditions = [{{ on = "plate.{head}", displacement = ["0 mm", "-0.1 mm"] }}]
output = {{ figures = false }}
"""


def case_of(file: Path, body: bool) -> Path:
    """A case file beside a mesh; groups go by name where the format has names."""
    named = file.suffix == ".msh"
    text = CASE.format(
        file=file.name,
        body=f', body = "{"body" if named else "9"}"' if body else "",
        foot="bottom" if named else "1",
        head="top" if named else "3",
    )
    path = file.with_name("case.toml")
    path.write_text(text)
    return path


@given(data=st.data(), body=st.booleans())
def test_any_mesh_file_is_read_or_refused(data: st.DataObject, body: bool, tmp_path: Path) -> None:
    check(case_of(data.draw(mesh_files(tmp_path)), body))


@given(
    data=st.binary(max_size=40),
    head=st.sampled_from((b"", b"$MeshFormat\n", b"<?xml ?>")),
    suffix=st.sampled_from(("msh", "vtu", "xdmf", "inp", "vtk", "stl", "h5", "mesh", "x")),
)
def test_bytes_that_are_no_mesh_are_refused(
    data: bytes, head: bytes, suffix: str, tmp_path: Path
) -> None:
    file = tmp_path / f"mesh.{suffix}"
    file.write_bytes(head + data)
    assert "bodies.plate.mesh" in check(case_of(file, body=False))
