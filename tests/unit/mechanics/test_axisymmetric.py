"""Bodies of revolution: weights and derivatives at the interface, closed forms, what check says."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.case.schema import Case
from contactfem.check.check import check_case
from contactfem.errors import CaseError
from contactfem.mortar.interface_mesh import InterfaceMesh, facet_lengths, half_lengths
from contactfem.mortar.normals import nodal_normals
from contactfem.mortar.operators import D_ENTRY, GAP_ENTRY, Mortar, assemble
from contactfem.mortar.segments import cut, find_pairs
from contactfem.results.data import RunResult
from contactfem.results.expectations import judge
from contactfem.results.measures import measure
from contactfem.run.driver import run_case

CASES = Path(__file__).parents[3] / "cases"
OFF = np.array((0.4, 0.0))  # of the surfaces from the axis

HEAD = """
title = "test"
dimension = "axisymmetric"
strain = "{strain}"
time = {{ end = "1 s", step = "{step}" }}
[materials.solid]
youngs_modulus = "100 MPa"
poisson_ratio = {poisson_ratio}
"""
# a thick tube, held in length
TUBE = """
[bodies.tube]
material = "solid"
[bodies.tube.mesh]
builder = "block"
width = "10 mm"
height = "1 mm"
corner = ["10 mm", "0 mm"]
nx = {n}
ny = 1
cell = "{cell}"
[[conditions]]
on = "tube.bottom"
displacement.y = "0 mm"
[[conditions]]
on = "tube.top"
displacement.y = "0 mm"
[[conditions]]
on = "tube.left"
pressure = "{pressure} MPa"
[probes]
inner = {{ on = "tube", at = ["10 mm", "0 mm"], value = "displacement.x" }}
"""
# two cylinders on each other with facets that do not match
STACK = """
[bodies.lower]
material = "solid"
mesh = { builder = "block", width = "10 mm", height = "10 mm", nx = 3, ny = 2 }
[bodies.upper]
material = "solid"
[bodies.upper.mesh]
builder = "block"
width = "10 mm"
height = "10 mm"
corner = ["0 mm", "10 mm"]
nx = 5
ny = 2
[interfaces.contact]
nonmortar = "lower.top"
mortar = "upper.bottom"
[[conditions]]
on = "lower.bottom"
displacement.y = "0 mm"
[[conditions]]
on = "upper.top"
grip = { displacement.x = "0 mm", force.y = "-3 kN" }
"""


def head(strain: str = "small", poisson_ratio: float = 0.3, step: str = "1 s") -> str:
    return HEAD.format(strain=strain, poisson_ratio=poisson_ratio, step=step)


def read(folder: Path, text: str) -> Case:
    path = folder / "case.toml"
    path.write_text(text)
    return read_case(path)


def solve(folder: Path, text: str) -> RunResult:
    result = run_case(read(folder, text), MPI.COMM_SELF, None)
    assert result.converged, result.message
    return result


def operators(mesh: InterfaceMesh, x: np.ndarray, *, differentiate: bool = False) -> Mortar:
    normals = nodal_normals(mesh, x)
    pairs = find_pairs(mesh, x, normals.n, np.arange(len(mesh.nonmortar)), 0.5)
    return assemble(mesh, x, cut(mesh, x, normals.n, pairs, differentiate=differentiate), normals)


def entry_sums(mesh: InterfaceMesh, found: Mortar) -> np.ndarray:
    """D, g and M as one vector."""
    width = mesh.n_nodes + 2
    column = found.row * width + found.col + 2
    return np.bincount(column, found.value, mesh.n_nonmortar * width)


def slope(function: Callable[[np.ndarray], np.ndarray], x: np.ndarray, v: np.ndarray) -> np.ndarray:
    step = 1e-6
    return (function(x + step * v) - function(x - step * v)) / (2 * step)


@pytest.mark.parametrize("held", [(), ((0, 0), (0, 1), (5, 1))])
def test_derivatives(chains, held):
    """Of D, M, g and the facets' areas, by central differences."""
    mesh, x = chains(seed=2, wave=0.2, held=held)
    mesh, x = replace(mesh, axisymmetric=True), x + OFF
    rng = np.random.default_rng(0)
    found = operators(mesh, x, differentiate=True)
    place = found.row * (mesh.n_nodes + 2) + found.col + 2
    for _ in range(4):
        v = rng.normal(size=x.shape)
        exact = np.bincount(
            place, found.derivative.scipy() @ v.ravel(), mesh.n_nonmortar * (mesh.n_nodes + 2)
        )
        difference = slope(lambda y: entry_sums(mesh, operators(mesh, y)), x, v)
        np.testing.assert_allclose(exact, difference, rtol=0, atol=1e-7 * abs(exact).max())
        exact = facet_lengths(mesh, x)[1].scipy() @ v.ravel()
        difference = slope(lambda y: facet_lengths(mesh, y)[0], x, v)
        np.testing.assert_allclose(exact, difference, rtol=0, atol=1e-7 * abs(exact).max())


def test_weights_are_circumferences(chains):
    """Areas add up to π (r1² - r0²) on a flat face; far from the axis all is as without one."""
    mesh, x = chains(wave=0.0, noise=0.0, span=(-0.1, 1.1))
    around = replace(mesh, axisymmetric=True)
    area = facet_lengths(around, x + OFF)[0]
    assert area.sum() == pytest.approx(np.pi * (1.4**2 - 0.4**2), rel=1e-14)
    found = operators(around, x + OFF)
    D = np.bincount(found.row[found.col == D_ENTRY], found.value[found.col == D_ENTRY])
    np.testing.assert_allclose(D, area, rtol=1e-13)
    assert half_lengths(around, x).sum() == pytest.approx(1.0, rel=1e-14)
    far = 1e7
    plane, ring = (entry_sums(m, operators(m, x + np.array((far, 0.0)))) for m in (mesh, around))
    np.testing.assert_allclose(ring / (2 * np.pi * far), plane, atol=1e-6)


def test_gap_is_weighted_by_the_circumference():
    """Two discs at a constant distance: the mean gap is it at every node, also on the axis."""
    lower = np.column_stack((np.linspace(1, 0, 5), np.zeros(5)))
    upper = np.column_stack((np.linspace(0, 1.2, 4), np.full(4, 0.01)))
    X = np.vstack((lower, upper))
    facets = [np.column_stack((np.arange(4), np.arange(1, 5)))]
    facets.append(np.column_stack((np.arange(5, 8), np.arange(6, 9))))
    free = np.ones(X.shape, bool)
    free[4, 0] = False
    mesh = InterfaceMesh(5, *facets, X, free, axisymmetric=True)
    found = operators(mesh, X)
    D, gap = (
        np.bincount(found.row[found.col == kind], found.value[found.col == kind], 5)
        for kind in (D_ENTRY, GAP_ENTRY)
    )
    np.testing.assert_allclose(gap / D, 0.01, rtol=1e-13)
    assert D.sum() == pytest.approx(np.pi, rel=1e-14)


def test_cylinders_on_each_other_pass_pressure_exactly(tmp_path):
    """Uniaxial stress F / π R², linear displacement: exact on any meshes; force in newtons."""
    result = solve(tmp_path, head(poisson_ratio=0.0) + STACK)
    table, pressure = result.interfaces[0], 3e3 / (np.pi * 0.01**2)
    np.testing.assert_allclose(table.pressure, pressure, rtol=1e-9)
    assert result.steps[-1].forces["contact"][1] == pytest.approx(3e3, rel=1e-9)
    values = measure(result)
    assert values["contact.normal_force"] == pytest.approx(3e3, rel=1e-9)
    assert values["lower.stress_yy.min"] == pytest.approx(-pressure, rel=1e-9)


def test_tube_under_pressure_is_lames(tmp_path):
    """u(a) = (1 + ν) p a ((1 - 2ν) a² + b²) / (E (b² - a²)), of second order; σ_θ is stress.zz."""
    a, b, p, E, nu = 0.01, 0.02, 5e6, 1e8, 0.3
    exact = (1 + nu) * p * a * ((1 - 2 * nu) * a**2 + b**2) / (E * (b**2 - a**2))
    errors = []
    for n in (8, 16):
        tube = TUBE.format(n=n, cell="quadrilateral", pressure=5)
        result = solve(tmp_path, head() + tube)
        errors.append(abs(result.probes["inner"] / exact - 1))
    assert errors[1] < 1e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)
    hoop = p * a**2 / (b**2 - a**2) * (1 + b**2 / a**2)
    assert result.bodies[0].fields["stress"][:, 2].max() == pytest.approx(hoop, rel=0.06)


def test_inflated_rubber_tube(tmp_path):
    """Incompressible, p = μ ∫ (λ² - λ⁻²) dr/r with r² = R² + C: MINI and a follower pressure."""
    a, b, mu, p = 0.01, 0.02, 1e8 / 3, 12e6

    def load(C: float) -> float:
        def slope(r: float) -> float:
            square = r**2 / (r**2 - C)
            return mu * (square - 1 / square) / r

        return quad(slope, (a**2 + C) ** 0.5, (b**2 + C) ** 0.5)[0]

    C = brentq(lambda C: load(C) - p, 0.0, a**2)
    tube = TUBE.format(n=20, cell="triangle", pressure=12)
    result = solve(tmp_path, head("finite", 0.49995, "0.25 s") + tube)
    exact = (a**2 + C) ** 0.5 - a
    assert exact > 0.2 * a
    assert result.probes["inner"] == pytest.approx(exact, rel=4e-3)
    assert all(step.iterations <= 6 for step in result.steps)


def test_friction_at_finite_strain_converges_quadratically(tmp_path):
    """A rubber cylinder pressed flat by a fifth on a rough plate: sticks inside, slips outside."""
    text = (
        head("finite", 0.4, "0.25 s")
        + """
[bodies.block]
material = "solid"
mesh = { builder = "block", width = "10 mm", height = "10 mm", nx = 12, ny = 12 }
[obstacles.plate]
shape = "plane"
point = ["0 mm", "0 mm"]
normal = [0.0, 1.0]
[interfaces.contact]
nonmortar = "block.bottom"
mortar = "plate"
friction = { law = "coulomb", coefficient = 0.2 }
[[conditions]]
on = "block.top"
displacement.y = [["0 s", "0 mm"], ["1 s", "-2 mm"]]
displacement.x = "0 mm"
"""
    )
    result = solve(tmp_path, text)
    last = result.steps[-1]
    assert last.stick > 2
    assert last.slip > 2
    assert all(step.iterations <= 7 for step in result.steps)
    before, after = last.residuals[-3:-1]
    assert after < 100 * before**2
    table = result.interfaces[0]
    slips = table.status == 2
    assert np.allclose(abs(table.traction[slips]), 0.2 * table.pressure[slips], rtol=1e-8)
    force = measure(result)["contact.normal_force"]
    assert result.reactions["block.top.y"][0] == pytest.approx(-force, rel=1e-8)


@pytest.mark.parametrize("case", ["sphere", "spheres", "punch"])
def test_case(case):
    read_ = read_case(CASES / f"{case}.toml")
    verdicts = judge(read_, measure(run_case(read_, MPI.COMM_SELF, None)))
    assert all(verdict.passed for verdict in verdicts), verdicts


def test_punch_extrapolated_over_the_size_of_the_half_space():
    depth = [
        run_case(read_case(CASES / "punch.toml", variant=variant), MPI.COMM_SELF, None).probes[
            "depth"
        ]
        for variant in ("box_25", "box_50")
    ]
    assert 2 * depth[1] - depth[0] == pytest.approx(-0.02275e-3, rel=0.01)


def test_check_names_units_and_the_axis(tmp_path):
    text = head() + STACK
    assert "axisymmetric, small strain" in check_case(read(tmp_path, text))
    assert "held only by contact" in check_case(read(tmp_path, text))
    with pytest.raises(CaseError, match=r"force\.y = -3 N/mm: is a force per length"):
        read(tmp_path, text.replace("3 kN", "3 N/mm"))
    with pytest.raises(CaseError, match=r"reaches to x = -0\.001 m; x is the distance"):
        read(tmp_path, text.replace('["0 mm", "10 mm"]', '["-1 mm", "10 mm"]'))
    with pytest.raises(CaseError, match="there is no radial force"):
        read(tmp_path, text.replace('displacement.x = "0 mm", ', 'force.x = "1 N", '))
