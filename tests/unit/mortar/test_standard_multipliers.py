"""Standard multipliers: their operators, the patch test, and a pressure with a closed form."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.mortar.normals import nodal_normals
from contactfem.mortar.operators import D_ENTRY, GAP_ENTRY, assemble
from contactfem.mortar.segments import cut, find_pairs
from contactfem.results.expectations import judge, measure
from contactfem.run.driver import run_case

CASES = Path(__file__).parents[3] / "cases"
SADDLE = "solver.system=saddle"


def solve(*overrides, variant):
    """Run Westergaard's case, without files."""
    return run_case(read_case(CASES / "westergaard.toml", overrides, variant), MPI.COMM_SELF, None)


def entries(mesh, x, differentiate=False):
    normals = nodal_normals(mesh, x)
    pairs = find_pairs(mesh, x, normals.n, np.arange(len(mesh.nonmortar)), 0.4)
    return assemble(mesh, x, cut(mesh, x, normals.n, pairs, differentiate), normals)


def matrix_of(mesh, found):
    """Find D_jj, M and the weighted gap."""
    D, gap = (
        np.bincount(found.row[found.col == k], found.value[found.col == k], mesh.n_nonmortar)
        for k in (D_ENTRY, GAP_ENTRY)
    )
    at = found.col >= 0
    shape = (mesh.n_nonmortar, mesh.n_nodes)
    return D, sp.coo_matrix((found.value[at], (found.row[at], found.col[at])), shape).toarray(), gap


PRESCRIBED = ((0, 0), (0, 1), (3, 1))


@pytest.mark.parametrize("held", [(), PRESCRIBED])
def test_standard_operators(chains, held):
    """D is the mass matrix of the covered facets, its row sums and Σ M_jl = D_jj hold."""
    mesh, x = chains(nonmortar=6, mortar=8, span=(-0.1, 1.1), held=held)
    mesh = replace(mesh, basis="standard")
    D, M, _ = matrix_of(mesh, entries(mesh, x))
    np.testing.assert_allclose(M.sum(1), D, atol=1e-15)
    n = mesh.n_nonmortar
    expected = np.zeros((n, n))
    for a, b in mesh.nonmortar:
        h = np.linalg.norm(x[b] - x[a])
        for j, k in ((a, b), (b, a)):
            if mesh.has_multiplier[j] and mesh.has_multiplier[k]:
                expected[j, [j, k]] += (h / 3, h / 6)
            elif mesh.has_multiplier[j]:  # Φ_j = 1
                expected[j, [j, k]] += (h / 2, h / 2)
    np.testing.assert_allclose(np.diag(D) - M[:, :n], expected, rtol=1e-13, atol=1e-15)


@pytest.mark.parametrize("held", [(), PRESCRIBED])
def test_dual_and_standard_span_the_same_constants(chains, held):
    """Sums over all multipliers see ΣΦ_j = 1 in both bases: forces of a constant λ are equal."""
    mesh, x = chains(nonmortar=6, mortar=5, span=(0.1, 0.7), held=held)
    dual, standard = (
        matrix_of(mesh, entries(replace(mesh, basis=kind), x)) for kind in ("dual", "standard")
    )
    n = mesh.n_nonmortar
    np.testing.assert_allclose(dual[0], standard[0], rtol=1e-13, atol=1e-16)
    np.testing.assert_allclose(dual[1][:, n:].sum(0), standard[1][:, n:].sum(0), atol=1e-14)
    np.testing.assert_allclose(dual[2].sum(), standard[2].sum(), rtol=1e-12)
    assert abs(dual[1] - standard[1]).max() > 1e-3


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("held", [(), PRESCRIBED])
def test_derivatives_of_standard_operators(chains, held, seed):
    mesh, x = chains(nonmortar=6, mortar=5, span=(0.1, 0.7), held=held, wave=0.1, seed=seed)
    mesh = replace(mesh, basis="standard")
    found = entries(mesh, x, differentiate=True)
    v, h = np.random.default_rng(seed).normal(size=x.shape), 1e-6
    ahead, behind = entries(mesh, x + h * v), entries(mesh, x - h * v)
    difference = (ahead.value - behind.value) / (2 * h)
    for of_gap in (False, True):
        at = (found.col == GAP_ENTRY) == of_gap
        exact = (found.derivative.scipy() @ v.ravel())[at]
        assert abs(exact - difference[at]).max() <= 1e-7 * abs(exact).max()


PATCHES = [
    None, "mesh_5_3", "mesh_7_4", "mesh_1_50", "mesh_50_1", "held_ends", "held_ends_fine",
    "cover_1e-2", "cover_1e-6", "cover_1e-12", "cover_by_nonmortar", "triangles_nonmortar",
    "stiff_mortar", "stiff_nonmortar", "confined",
]  # fmt: skip


@pytest.mark.parametrize("variant", PATCHES)
def test_standard_multipliers_pass_the_patch_test(variant):
    """Same numbers, same tolerances as the case expects of dual ones: 1e-9 of stress and p."""
    overrides = [SADDLE, "interfaces.contact.multiplier=standard"]
    if variant == "stiff_nonmortar":  # forces of a body 1e5 stiffer, on facets 50 times shorter
        overrides.append('expect."contact.pressure_error_max".max=2e-6')
    case = read_case(CASES / "patch.toml", overrides, variant)
    result = run_case(case, MPI.COMM_SELF, None)
    verdicts = judge(case, measure(result))
    assert len(verdicts) > 5
    assert result.steps[0].iterations <= 6
    assert [v for v in verdicts if not v.passed] == []


def test_westergaard_with_standard_multipliers():
    """Wholly in contact both bases have the same accuracy; partly, the edge costs more."""
    kind = "interfaces.contact.multiplier=standard"
    for variant, limit in (("full", 0.0025), ("half", 0.011), (None, 0.025)):
        dual, standard = solve(variant=variant), solve(SADDLE, kind, variant=variant)
        errors = [measure(r)["contact.pressure_error_l2"] for r in (dual, standard)]
        assert errors[1] < limit
        assert errors[1] < 1.4 * errors[0]
        center = measure(standard)["contact.pressure_at_center"]
        exact = {"full": 3.7261498e6, "half": 2.6276604e6, None: 1.8580365e6}[variant]
        assert abs(center / exact - 1) < 0.005
