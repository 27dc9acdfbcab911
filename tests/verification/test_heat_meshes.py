"""Heat and mechanics on meshes of different fineness: changes are of discretisation order."""

import numpy as np
import pytest

from contactfem.laws.conductance import PowerLaw
from contactfem.verification.heat_steady import Bar
from contactfem.verification.homogeneous import NeoHooke
from contactfem.verification.thermoelastic import ConfinedBlock, confined_blocks

LAW = PowerLaw(150e3, 100e6, 1.5)
TIRE = {"bulk_modulus": 333e6, "shear_modulus": 35e6, "expansion": 1e-4}


def exact():
    """Closed form of cases/gap_closure.toml, variant blocks_19."""
    hot, cold = (ConfinedBlock(NeoHooke(**TIRE), Bar(10e-3, 0.2, end)) for end in (100.0, 0.0))
    return confined_blocks(hot, cold, 19e-3, LAW)


def block(name, nx, ny, cell):
    """Thermal mesh of one of its bodies."""
    y = {"hot": 0, "cold": 10}[name]
    return (
        f'bodies.{name}.thermal_mesh={{builder = "block", width = "2 mm", height = "10 mm", '
        f'corner = ["0 mm", "{y} mm"], nx = {nx}, ny = {ny}, cell = "{cell}"}}'
    )


def solution(solved, mechanical, thermal, cell="quadrilateral"):
    """Pressure and both surface temperatures with some cells along the blocks, over the exact."""
    cells = [f"bodies.{name}.mesh.ny={mechanical}" for name in ("hot", "cold")]
    own = [block("hot", 3, thermal, cell), block("cold", 2, thermal, cell)]
    result = solved("gap_closure", *cells, *own, variant="blocks_19")
    table, known = result.interfaces[0], exact()
    found = (table.pressure, table.heat.temperature, table.heat.mortar_temperature)
    expected = (known.pressure, known.nonmortar, known.mortar)
    for values in found:
        assert np.ptp(values) < 1e-7 * values.mean()  # a one-dimensional state stays one
    return np.array([v.mean() / e - 1.0 for v, e in zip(found, expected, strict=True)])


@pytest.mark.parametrize("cell", ["quadrilateral", "triangle"])
@pytest.mark.parametrize("ratio", [8, 1 / 8])
def test_eight_times_finer_or_coarser(solved, ratio, cell):
    """The error falls with h² of the coarser mesh, whichever it is (D29)."""
    errors = []
    for coarse in (2, 4, 8):
        pair = (coarse, 8 * coarse) if ratio > 1 else (8 * coarse, coarse)
        errors.append(np.abs(solution(solved, *pair, cell)))
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert (rates > 1.8).all(), (rates, errors)
    assert np.max(errors[-1]) < 1e-4
