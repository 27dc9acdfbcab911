"""The inf-sup constant of the coupling of an interface, for dual and standard multipliers."""

from pathlib import Path

import pytest
import scipy.sparse as sp

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.common.timers import Timers
from contactfem.discretisation.discretise import discretise
from contactfem.mechanics.inf_sup import inf_sup, smallest_singular_value

CASES = Path(__file__).parents[3] / "cases"
SADDLE = "solver.system=saddle"


def beta(ratio, refinement, multiplier, stiffening=1.0):
    """Inf-sup constant of two held blocks with facets in a ratio, nonmortar : mortar."""
    meshes = [
        f"bodies.{body}.mesh.{n}={k * refinement}"
        for body, k in zip(("lower", "upper"), ratio, strict=True)
        for n in ("nx", "ny")
    ]
    held = "conditions.6={on='upper.top', displacement.y='0 mm'}"
    modulus = f"materials.soft.youngs_modulus={1000 * stiffening} N/mm^2"
    kind = f"interfaces.contact.multiplier={multiplier}"
    case = read_case(CASES / "patch.toml", [SADDLE, kind, held, modulus, *meshes])
    d = discretise(case, MPI.COMM_SELF, Timers())
    contact, nodes = d.interfaces[0].contact, d.interfaces[0].nodes
    return inf_sup(d.system, d.interfaces[0], contact.operators(nodes.X))


@pytest.mark.parametrize("multiplier", ["dual", "standard"])
@pytest.mark.parametrize("ratio", [(1, 1), (2, 3), (3, 2), (1, 4), (4, 1), (8, 1)])
def test_inf_sup_constant_is_bounded(multiplier, ratio):
    """It settles as h goes to zero, for coarser and for finer nonmortar facets."""
    found = [beta(ratio, k, multiplier) for k in (2, 4, 8)]
    assert min(found) > 0.29
    assert found[2] > 0.85 * found[1]
    assert (found[2] - found[1]) ** 2 < 0.5 * (found[1] - found[0]) ** 2  # differences decay


def test_inf_sup_constant_finds_instability():
    """Multipliers finer than the only side that can move have pressures that it cannot feel."""
    for multiplier in ("dual", "standard"):
        assert beta((3, 2), 4, multiplier, stiffening=1e8) < 1e-3
        assert beta((2, 3), 4, multiplier, stiffening=1e8) > 0.2


def test_smallest_singular_value():
    """Diagonal matrices: β = min |b| / √(s k)."""
    B, K, S = (sp.diags(v).tocsr() for v in ((3.0, 1.0, 4.0), (4.0, 1.0, 1.0), (1.0, 1.0, 100.0)))
    assert smallest_singular_value(B, K, S) == pytest.approx(0.4, rel=1e-12)
    assert smallest_singular_value(B[[0, 1]], K, S[:2][:, :2]) == pytest.approx(1.0, rel=1e-12)
