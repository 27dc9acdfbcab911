"""Meshes that are written for others can be read again."""

import numpy as np
import pytest

from contactfem.meshes import MeshFile
from contactfem.meshes.block import Block
from contactfem.meshes.box import Box
from contactfem.output.mesh_files import write_msh

FLAT = {"width": 2.0, "height": 1.0, "nx": 3, "ny": 2}
SOLID = FLAT | {"depth": 0.5, "nz": 2}


@pytest.mark.parametrize(
    "builder",
    [
        Block(**FLAT),
        Block(**FLAT, cell="triangle", pattern="crossed"),
        Box(**SOLID),
        Box(**SOLID, cell="tetrahedron"),
    ],
    ids=lambda builder: builder.cell,
)
def test_a_mesh_makes_the_round_trip(tmp_path, builder):
    mesh = builder.build()
    write_msh(mesh, tmp_path / "mesh.msh")
    again = MeshFile(file=tmp_path / "mesh.msh", unit=1.0).build()
    assert again.cell_type == mesh.cell_type
    assert again.points == pytest.approx(mesh.points, abs=1e-15)
    assert np.array_equal(np.sort(again.cells), np.sort(mesh.cells))
    assert again.groups.keys() == mesh.groups.keys()
    for name, facets in mesh.groups.items():
        found = {tuple(sorted(facet)) for facet in again.groups[name].tolist()}
        assert found == {tuple(sorted(facet)) for facet in facets.tolist()}
