"""Smallest gap between two surfaces in space."""

import numpy as np
import pytest

from contactfem.check.spatial_gap import spatial_gap
from contactfem.meshes.box import Box
from contactfem.meshes.data import Surface


def side(name, height=0.0, cells=3, cell="hexahedron"):
    low = height - 1.0 if name == "top" else height
    sizes = {"width": "2 m", "height": "1 m", "depth": "2 m"}
    counts = {"nx": cells, "ny": 1, "nz": cells}
    corner = ("0 m", f"{low} m", "0 m")
    return Box(**sizes, **counts, corner=corner, cell=cell).build().surface(name)


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
@pytest.mark.parametrize("gap", [0.0, 0.02, -0.01, 0.7])
def test_flat_sides(gap, cell):
    found = spatial_gap(side("top", cells=3), side("bottom", gap, 4, cell))
    assert found == pytest.approx(gap, abs=1e-14)


def test_round_side_touches_between_nodes():
    """A dome whose highest node lies over the middle of a single facet."""
    dome = side("bottom", 0.3, 4)
    r = dome.X[:, [0, 2]] - 1.0
    X = dome.X + 0.1 * (r**2).sum(1)[:, None] * (0, 1, 0)
    assert spatial_gap(side("top", cells=1), Surface(dome.vertices, dome.facets, X)) == (
        pytest.approx(0.3, abs=1e-14)
    )


def test_sides_that_look_away():
    assert spatial_gap(side("top"), side("top", 0.1)) is None


def test_sides_beside_each_other():
    away = side("bottom", 0.1)
    moved = Surface(away.vertices, away.facets, away.X + np.array([5.0, 0.0, 0.0]))
    assert spatial_gap(side("top"), moved) is None
