"""Resultants of loads on facets."""

import numpy as np
import pytest

from contactfem.audit.loads import of_pressure, on_surface
from contactfem.meshes.box import Box


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
def test_traction_and_pressure_on_a_side_of_a_box(cell):
    mesh = Box(width="2 m", height="1 m", depth="3 m", nx=2, ny=1, nz=2, cell=cell).build()
    top = mesh.surface("top")
    force = on_surface(top.X, top.facets, np.array([1.0, -2.0, 0.5]), axisymmetric=False)
    np.testing.assert_allclose(force, [6.0, -12.0, 3.0], rtol=1e-14)
    pressed = of_pressure(top.X, top.facets, 4.0, axisymmetric=False)
    np.testing.assert_allclose(pressed, [0.0, -24.0, 0.0], atol=1e-13)
