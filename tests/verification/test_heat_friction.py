"""Work of friction becomes heat: nothing is lost between the meshes, and it enters both sides."""

from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.verification.heat_steady import rise_by_sliding

CASES = Path(__file__).parents[2] / "cases"
CAPACITY = 2.43e6  # ρc of cases/sliding_block.toml [J/m³/K]
SIDE, STROKE, FRICTION, PRESSURE = 1.25e-3, 3.75e-3, 0.2, 10e6
COARSE = ("bodies.base.mesh.nx=30", "bodies.base.mesh.ny=3", "bodies.block.mesh.nx=7")


def held_heat(picture):
    """∫ ρc ϑ over a mesh of rectangles or triangles [J/m], by the means of linear fields."""
    X, theta = picture.points[picture.cells], picture.fields["temperature"][picture.cells, 0]
    if X.shape[1] == 3:
        a, b = X[:, 1] - X[:, 0], X[:, 2] - X[:, 0]
        area = 0.5 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    else:
        area = np.prod(np.ptp(X, axis=1), axis=1)
    return CAPACITY * float(area @ theta.mean(1))


@pytest.mark.parametrize("partition", [0.5, 0.3])
@pytest.mark.parametrize("variant", [None, "meshes", "conducting"])
def test_energy_of_every_step(solved, variant, partition):
    """Σ ρc Δϑ = work of friction in each step to 1e-10, on equal and on different meshes (D23)."""
    share = f"interfaces.slide.heat.partition={partition}"
    result = solved("sliding_block", *COARSE, share, variant=variant)
    assert sum(step.slip > 0 for step in result.steps) >= 15
    for step in result.steps:
        assert step.heat.stored == pytest.approx(step.dissipation, rel=1e-10)
        assert step.heat.friction == pytest.approx(step.dissipation, rel=1e-12)
        assert abs(step.heat.defect) <= 1e-12 * step.dissipation
    work = sum(step.dissipation for step in result.steps)
    found = {picture.name: held_heat(picture) for picture in result.heat}
    assert sum(found.values()) == pytest.approx(work, rel=1e-10)
    if variant != "conducting":  # each body keeps what entered it
        assert found["block"] == pytest.approx(partition * work, rel=1e-10)


def test_rise_of_a_block_that_takes_half(solved):
    """f μ p s / (ρc H), but for what it shears before it slips and after (D23)."""
    result = solved("sliding_block", *COARSE)
    block = next(picture for picture in result.heat if picture.name == "block")
    rise = held_heat(block) / (CAPACITY * SIDE**2)
    expected = rise_by_sliding(0.5 * FRICTION * PRESSURE * STROKE, CAPACITY * SIDE)
    assert rise == pytest.approx(expected, rel=1e-3)


def test_the_defect_of_interpolation_is_reported(solved):
    """Between different meshes the interpolated power is off, and made right; on equal ones hardly.

    What is left on equal meshes comes from the operators at the start of a step, that weigh the
    power of mechanics, while heat enters at its end.
    """
    equal = solved("sliding_block", *COARSE).steps[-1].heat.friction_defect
    different = solved("sliding_block", *COARSE, variant="meshes").steps[-1].heat.friction_defect
    assert 0.0 <= equal < 1e-3
    assert 10 * equal < different < 0.2


def test_heat_is_where_the_block_rubs(solved):
    """Both surfaces are warm along the way, the base behind the block as well, its far end not."""
    result = solved("sliding_block", *COARSE)
    base = next(picture for picture in result.heat if picture.name == "base")
    top = np.isclose(base.points[:, 1], base.points[:, 1].max())
    x, theta = base.points[top, 0], base.fields["temperature"][top, 0]
    assert 0.625e-3 + STROKE < x[np.argmax(theta)] < 0.625e-3 + STROKE + SIDE
    assert theta[x > 6.2e-3].max() < 0.05 * theta.max()
    assert theta[np.isclose(x, 1.25e-3, atol=1e-4)].min() > 0.05 * theta.max()


def test_friction_that_grows_with_temperature(written):
    """μ of the nonmortar surface, node by node, at the fixed point of the passes."""
    text = (CASES / "sliding_block.toml").read_text()
    table = 'coefficient_table = [["0 K", 0.2], ["10 K", 0.4]]'
    passes = 'heat = { scheme = "cG(1)", max_passes = 30, tolerance = 1e-10 }'
    changed = text.replace("coefficient = 0.2", table)
    changed = changed.replace('heat = { scheme = "dG(1)" }', passes)
    assert table in changed and passes in changed
    result = written(changed, *COARSE, 'time.end="2 ms"')
    table = result.interfaces[0]
    sliding = table.status == 2
    assert sliding.sum() >= 3
    expected = np.interp(table.heat.temperature, [0.0, 10.0], [0.2, 0.4])
    assert np.ptp(expected[sliding]) > 0.01
    np.testing.assert_allclose(
        np.abs(table.traction[sliding]), (expected * table.pressure)[sliding], rtol=1e-7
    )


@pytest.mark.mpi
@pytest.mark.parametrize("variant", ["meshes", "conducting"])
def test_the_same_on_any_ranks(solved, variant):
    """Temperatures, heat and mechanics agree with those of one rank to 1e-9."""
    short = (*COARSE, 'time.end="1 ms"')
    if variant == "conducting":
        short += (
            "bodies.block.thermal_mesh={builder='block', width='1.25 mm', height='1.25 mm',"
            " corner=['0.625 mm', '1.25 mm'], nx=5, ny=4}",
        )
    alone = solved("sliding_block", *short, variant=variant)
    both = solved("sliding_block", *short, variant=variant, comm=MPI.COMM_WORLD)
    for a, b in zip(alone.steps, both.steps, strict=True):
        assert b.heat.stored == pytest.approx(a.heat.stored, rel=1e-9)
        assert b.heat.temperature_max == pytest.approx(a.heat.temperature_max, rel=1e-9)
        assert b.heat.flow["slide"] == pytest.approx(a.heat.flow["slide"], rel=1e-9, abs=1e-12)
    first, second = alone.interfaces[0].heat, both.interfaces[0].heat
    for name in first._fields:
        expected = getattr(first, name)
        scale = np.nanmax(np.abs(expected))
        np.testing.assert_allclose(getattr(second, name), expected, rtol=0, atol=1e-9 * scale)
    for a, b in zip(alone.heat, both.heat, strict=False):
        scale = np.abs(a.fields["temperature"]).max()
        np.testing.assert_allclose(
            b.fields["temperature"], a.fields["temperature"], rtol=0, atol=1e-9 * scale
        )
