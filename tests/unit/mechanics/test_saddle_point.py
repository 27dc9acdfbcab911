"""The saddle-point system against the condensed one, and its tangent against differences."""

from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.check.check import check_case
from contactfem.common.timers import Timers
from contactfem.contact.slip import tangential
from contactfem.contact.state import ContactHistory
from contactfem.discretisation.discretise import discretise
from contactfem.errors import CaseError
from contactfem.laws.active_set import Status
from contactfem.mechanics.saddle_point import Saddle, row_scales
from contactfem.run.driver import run_case

CASES = Path(__file__).parents[3] / "cases"
SADDLE = "solver.system=saddle"
SLIDING = """
title = "Block of rubber dragged over another one, first sticking, then sliding off its facets"
time = { end = "1 s", step = "0.125 s" }
[materials.soft]
youngs_modulus = "10 MPa"
poisson_ratio = 0.3
[materials.hard]
youngs_modulus = "40 MPa"
poisson_ratio = 0.3
[bodies.lower]
material = "soft"
mesh = { builder = "block", width = "3 mm", height = "1 mm", nx = 14, ny = 4 }
[bodies.upper]
material = "hard"
[bodies.upper.mesh]
builder = "block"
width = "1.23 mm"
height = "0.6 mm"
corner = ["0.61 mm", "1 mm"]
nx = 7
ny = 3
cell = "triangle"
[interfaces.sole]
nonmortar = "upper.bottom"
mortar = "lower.top"
friction = { law = "coulomb", coefficient = 0.3 }
[[conditions]]
on = "lower.bottom"
displacement = ["0 mm", "0 mm"]
[[conditions]]
on = "upper.top"
[conditions.displacement]
x = [["0 s", "0 mm"], ["0.25 s", "0 mm"], ["1 s", "0.7 mm"]]
y = [["0 s", "0 mm"], ["0.25 s", "-0.15 mm"]]
"""


@pytest.fixture
def sliding(tmp_path):
    path = tmp_path / "sliding.toml"
    path.write_text(SLIDING)
    return path


def solve(path, *overrides, variant=None, comm=MPI.COMM_SELF):
    """Run a case, without files."""
    result = run_case(read_case(path, overrides, variant), comm, None)
    assert result.converged, result.message
    return result


def assert_same(a, b, tolerance=1e-9):
    """Displacements, contact values and their history agree."""
    moved = max(abs(body.displacement).max() for body in a.bodies)
    for one, other in zip(a.bodies, b.bodies, strict=True):
        difference = other.displacement - one.displacement
        assert abs(difference).max() <= tolerance * abs(one.displacement).max()
    for one, other in zip(a.interfaces, b.interfaces, strict=True):
        np.testing.assert_array_equal(other.status, one.status)
        size = one.pressure.max()
        assert size > 0
        for name in ("pressure", "traction"):
            found, expected = getattr(other, name), getattr(one, name)
            np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance * size)
        np.testing.assert_allclose(other.slip, one.slip, rtol=0, atol=tolerance * moved)


@pytest.mark.parametrize("variant", [None, "mesh_1_50", "held_ends", "cover_1e-2", "confined"])
def test_patch_is_the_same(variant):
    path = CASES / "patch.toml"
    assert_same(solve(path, variant=variant), solve(path, SADDLE, variant=variant))


def test_frictional_block_is_the_same():
    """Lift-off, slip and stick on a symmetry line; as many iterations, as status decides them."""
    path = CASES / "block.toml"
    condensed, saddle = (solve(path, *o, variant="coarse") for o in ((), (SADDLE,)))
    assert_same(condensed, saddle)
    status = saddle.interfaces[0].status
    assert {Status.NONE, Status.OPEN, Status.STICK, Status.SLIP} == set(status)
    assert saddle.steps[0].iterations == condensed.steps[0].iterations


def test_finite_sliding_is_the_same(sliding):
    """Large strain, friction, mortar facets passed over; the kept multipliers start each step."""
    condensed, saddle = solve(sliding), solve(sliding, SADDLE)
    assert_same(condensed, saddle)
    table = saddle.interfaces[0]
    assert (table.status == Status.SLIP).sum() >= 6
    assert abs(table.slip).max() > 0.2e-3
    assert len(saddle.steps) == 8
    assert saddle.steps[-1].iterations <= condensed.steps[-1].iterations + 1
    assert saddle.steps[-1].residuals[-2] < 1e-6


@pytest.mark.parametrize("law", ["penalty", "augmented"])
def test_other_laws_are_the_same(sliding, law):
    """Conditions with compliances stand in the rows of multipliers as exact ones do."""
    normal = f"interfaces.sole.normal.law={law}"
    condensed, saddle = (solve(sliding, normal, "time.end=0.5 s", *o) for o in ((), (SADDLE,)))
    assert_same(condensed, saddle)
    exact = solve(sliding, SADDLE, "time.end=0.5 s")
    assert abs(exact.interfaces[0].gap[saddle.interfaces[0].status > 0]).max() < 1e-15
    difference = abs(saddle.interfaces[0].pressure / exact.interfaces[0].pressure - 1)[1:-1]
    assert difference.max() < (0.2 if law == "penalty" else 1e-3)


def test_failed_step_gives_multipliers_back(sliding):
    """One iteration too few for some steps: they are cut, and the end is that of the condensed."""
    few = "solver.max_iterations=5"
    condensed, saddle = (solve(sliding, few, *o) for o in ((), (SADDLE,)))
    assert sum(s.cutbacks for s in saddle.steps) > 0
    assert [s.dt for s in saddle.steps] == [s.dt for s in condensed.steps]
    assert_same(condensed, saddle)


@pytest.mark.mpi
@pytest.mark.parametrize("multiplier", ["dual", "standard"])
def test_ranks_agree(sliding, multiplier):
    """The first rank keeps the multipliers; the answer is that of one rank."""
    kind = f"interfaces.sole.multiplier={multiplier}"
    alone, shared = (solve(sliding, SADDLE, kind, comm=c) for c in (MPI.COMM_SELF, MPI.COMM_WORLD))
    if MPI.COMM_WORLD.rank == 0:
        assert_same(alone, shared)


class Unbalanced:
    """The sliding case at a state far from equilibrium, and its residual elsewhere."""

    def __init__(self, path, multiplier, t):
        case = read_case(path, [SADDLE, f"interfaces.sole.multiplier={multiplier}"])
        d = discretise(case, MPI.COMM_SELF, Timers())
        self.system, self.interface, self.t = d.system, d.interfaces[0], t
        self.equations = Saddle(d.system, d.interfaces, Timers())
        before = self.interface.contact.operators(self.interface.nodes.positions(0.0, 1.0))
        self.history = [ContactHistory.at(before)]
        self.system.advance(t, 0.125)
        rng = np.random.default_rng(0)
        n = self.interface.nodes.mesh.n_nonmortar
        pressed = np.column_stack((2e5 * rng.normal(size=n), -8e5 * rng.uniform(-0.2, 1.0, n)))
        self.x = 2e-6 * rng.normal(size=self.system.numbering.n_global)
        self.x[: 2 * n] = (pressed / self.interface.contact.law.c[:, None]).ravel()
        self.conditions, _ = self.at(self.x)
        self.scales = row_scales(self.interface, self.conditions)

    def at(self, x):
        """Conditions and the residual, its rows of multipliers with normals and scales held."""
        self.system.x.array[:] = x
        self.system.spread(self.system.x)
        bulk, out = self.system.x.duplicate(), self.system.x.duplicate()
        self.system.residual(bulk, [None] * len(self.system.bodies))
        positions = [self.interface.nodes.positions(self.t, 0.125)]
        (c,) = self.equations.evaluate(positions, self.history, [None], bulk, out)
        return c, out.array.copy()

    def held(self, x):
        """Residual as the tangent sees it: its combinations of conditions do not turn."""
        c, residual = self.at(x)
        assert (c.status == self.conditions.status).all()
        base = self.conditions.operators
        normals, unknown = base.normals.n, x[: residual.size][: c.slip.size]
        rows = (self.scales.normal * c.residuals.normal)[:, None] * normals
        rows += self.scales.tangential[:, None] * tangential(c.residuals.tangential, normals)
        multiplier = self.interface.contact.law.c[:, None] * unknown.reshape(-1, 2)
        rows = np.where(c.active[:, None], rows, base.full[:, None] * multiplier)
        residual[: rows.size] = rows.ravel()
        return residual


@pytest.mark.parametrize("multiplier", ["dual", "standard"])
@pytest.mark.parametrize("t", [0.125, 0.75])
def test_tangent(sliding, multiplier, t):
    """The whole matrix against central differences of the whole residual, block by block."""
    scene = Unbalanced(sliding, multiplier, t)
    active, start = scene.conditions.active, scene.x
    assert 4 <= active.sum() < len(active)
    np.testing.assert_allclose(scene.held(start), scene.at(start)[1], rtol=1e-12)
    jumps = [None] * len(scene.system.bodies)
    indptr, indices, data = scene.equations.linearise([scene.conditions], jumps).getValuesCSR()
    matrix = sp.csr_matrix((data, indices, indptr))
    blocks = slice(2 * len(active)), slice(2 * len(active), None)
    for columns in blocks:
        v = np.zeros_like(start)
        v[columns] = np.random.default_rng(1).normal(size=len(start[columns]))
        difference = (scene.held(start + 1e-9 * v) - scene.held(start - 1e-9 * v)) / 2e-9
        exact = matrix @ v
        for rows in blocks:
            error = abs(difference - exact)[rows].max()
            assert error < 1e-6 * abs(exact[rows]).max(), (columns, rows)


def test_standard_needs_the_saddle_point_system(sliding):
    with pytest.raises(CaseError, match=r'interfaces\.sole\.multiplier.*solver\.system = "saddle"'):
        read_case(sliding, ["interfaces.sole.multiplier=standard"])


def test_check_says_which_system(sliding):
    texts = [
        check_case(read_case(sliding, overrides))
        for overrides in ([], [SADDLE], [SADDLE, "interfaces.sole.multiplier=standard"])
    ]
    kinds = "condensed: eliminated ", "saddle point: unknown ", "saddle point: unknown "
    names = "multipliers, dual", "multipliers, dual", "multipliers, standard (sole)"
    for text, kind, name in zip(texts, kinds, names, strict=True):
        rows = [" ".join(row.split()) for row in text.splitlines()]
        assert f"system {kind}{name}" in rows


def test_condensed_system_has_no_multipliers(sliding):
    """What is not used costs nothing: neither unknowns nor matrix rows."""
    sizes = [
        discretise(read_case(sliding, o), MPI.COMM_SELF, Timers()).system.numbering
        for o in ([], [SADDLE])
    ]
    assert len(sizes[0].multipliers) == 0
    assert sizes[1].n_global == sizes[0].n_global + 2 * 8
