"""What `check` says of interfaces: the constants of a run, and which side would be better."""

from pathlib import Path

import numpy as np
import pytest

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.check.check import check_case
from contactfem.check.facet_matching import match
from contactfem.check.interface_summary import interface_facts
from contactfem.common.timers import Timers
from contactfem.discretisation.discretise import discretise
from contactfem.errors import CaseError, MeshError
from contactfem.meshes.data import Surface

CASES = Path(__file__).resolve().parents[3] / "cases"


def facts(stem, variant=None, overrides=()):
    case = read_case(CASES / f"{stem}.toml", overrides, variant)
    (interface,) = case.interfaces.values()
    return case, list(interface_facts(case, interface))


def strip(X):
    """Surface of facets from the first to the last point."""
    X = np.asarray(X, float)
    ends = np.arange(len(X) - 1)
    return Surface(np.arange(len(X)), np.column_stack((ends, ends + 1)), X)


def level(x, y):
    return strip(np.column_stack((x, np.full(len(x), y))))


UNDER = level(np.linspace(1.0, 0.0, 11), 0.0)  # its body lies below


@pytest.mark.parametrize(
    ("stem", "overrides", "lines"),
    [
        ("block", (), ["active set: c_n = 2.08e+14 Pa/m, c_t = 2.08e+14 Pa/m"]),
        (
            "hard/penalty",
            ("interfaces.sole.friction.penalty_factor=0.5",),
            ["active set: c_n = 1e+12 Pa/m, c_t = 1e+12 Pa/m",
             "penalty: epsilon_N = 1e+13 Pa/m, c_T = 5e+12 Pa/m"],
        ),
        (
            "cattaneo_mindlin",
            ("interfaces.contact.friction.c_factor=0.25",),
            ["active set: c_n = 3.017e+12 Pa/m, c_t = 7.544e+11 Pa/m"],
        ),
    ],
)  # fmt: skip
def test_constants_are_those_of_the_run(stem, overrides, lines):
    """As typed from E/h, and as the run's own interface has them."""
    case, found = facts(stem, overrides=overrides)
    assert [line for line in found[1:] if not line.startswith("search: ")] == lines
    assert sum(line.startswith("search: gaps of any width") for line in found) == 1
    law = discretise(case, MPI.COMM_SELF, Timers()).interfaces[0].contact.law
    for factor, name in ((law.c_n, "c_n"), (law.c_t, "c_t")):
        assert f"{name} = {(factor * law.c).min():.4g} Pa/m" in found[1]
    if len(lines) > 1:
        assert f"epsilon_N = {1 / law.normal_compliance.max():.4g} Pa/m" in found[2]
        assert f"c_T = {1 / law.tangential_compliance.max():.4g} Pa/m" in found[2]


def test_constants_that_vary_have_both_ends():
    grading = ("bodies.block.mesh.grading=[4.0, 1.0]", "bodies.block.mesh.nx=2")
    _, found = facts("block", overrides=grading)
    assert found[0] == "facets: 2 of 8 to 32 mm on an obstacle"
    ends = [130e9 / h for h in (32e-3, 8e-3)]
    assert found[1].startswith(f"active set: c_n = {ends[0]:.4g} to {ends[1]:.4g} Pa/m, c_t")


def test_finer_nonmortar_side_is_named():
    _, found = facts("hard/mortar_finer", "nonmortar_finer")
    (hint,) = [line for line in found if line.startswith("HINT")]
    assert "mortar facets are 3.8 times as long as nonmortar ones" in hint
    assert "better with cylinder.contact as nonmortar" in hint
    assert not [line for line in facts("hard/mortar_finer")[1] if line.startswith("HINT")]


def test_overhanging_nonmortar_side_is_named():
    _, found = facts("hard/corner_off_edge", "slab_nonmortar")
    (hint,) = [line for line in found if line.startswith("HINT")]
    assert "slab.top overhangs the end of block.bottom at (0.0031, 0.004) m and (0.0071" in hint
    assert not [line for line in facts("hard/corner_off_edge")[1] if line.startswith("HINT")]


def test_ratio_is_that_of_the_place_that_touches():
    """Coarse facets far away do not count: the arc is coarse in the middle and fine outside."""
    x = np.concatenate(
        (np.linspace(-1, -0.3, 30), np.linspace(-0.1, 0.1, 2), np.linspace(0.3, 1, 30))
    )
    arc = strip(np.column_stack((0.5 + x, 0.05 + x**2)))
    assert match(UNDER, arc).ratio == pytest.approx(0.2 / 0.1, rel=0.05)


@pytest.mark.parametrize(
    ("x", "edges"),
    [((-0.2, 1.3), 0), ((0.0, 1.0), 0), ((0.0, 0.52), 1), ((0.3, 0.7), 2), ((-0.5, 0.52), 1)],
)
def test_edges(x, edges):
    """Ends of the mortar side before the middle of the nonmortar one; an end on an end is none."""
    found = match(UNDER, level(np.linspace(*x, 6), 0.01))
    assert len(found.edges) == edges
    assert len(match(UNDER, level(np.linspace(*x, 6), 0.3)).edges) == 0  # out of touch


def test_surfaces_that_do_not_face_each_other_have_no_match():
    assert match(UNDER, level(np.linspace(1, 0, 6), 0.1)) is None


def test_check_shows_them():
    text = check_case(read_case(CASES / "hard" / "mortar_finer.toml", variant="nonmortar_finer"))
    assert "  HINT: mortar facets are 3.8 times as long" in text


def test_a_body_that_cannot_be_meshed_is_named():
    """Which the check would not find without meshing."""
    case = read_case(CASES / "ironing.toml")

    def broken(_):
        raise MeshError("no mesh")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(type(case.bodies["die"].mesh), "build", broken)
        with pytest.raises(CaseError, match=r"ironing\.toml: bodies\.die\.mesh: no mesh"):
            list(interface_facts(case, case.interfaces["sole"]))
