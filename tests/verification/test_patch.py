"""The patch test where a case file cannot go: on several ranks, and with a sign of every error."""

import pytest

from mpi4py import MPI

from contactfem.results.expectations import measure


@pytest.mark.mpi
@pytest.mark.parametrize("variant", [None, "mesh_50_1", "held_ends", "cover_1e-6", "confined"])
def test_ranks_agree(solved, same, variant):
    same(
        solved("patch", variant=variant),
        solved("patch", variant=variant, comm=MPI.COMM_WORLD),
    )


SWAPPED = (
    'interfaces.contact.nonmortar="upper.bottom"',
    'interfaces.contact.mortar="lower.top"',
)


def held(x):
    """Prescribe the exact settlement at a corner of the upper block's lower side."""
    return f'={{ on = "upper", at = ["{x} mm", "1.5 mm"], displacement.y = "-7 um" }}'


@pytest.mark.parametrize(
    ("variant", "overrides"),
    [
        ("confined", ()),
        ("confined_hot", ()),
        ("free_sides", ()),
        ("cover_1e-6", ()),
        ("cover_1e-12", ()),
        (None, (f"conditions.6{held(0)}", f"conditions.7{held(1)}")),
    ],
)
def test_other_side_as_nonmortar(solved, variant, overrides):
    result = solved("patch", *SWAPPED, *overrides, variant=variant)
    values = measure(result)
    pressure = values["contact.pressure_at_center"]
    assert values["contact.pressure_error_max"] < 1e-9
    for body in ("lower", "upper"):
        for end in ("min", "max"):
            assert values[f"{body}.stress_yy.{end}"] == pytest.approx(-pressure, rel=1e-9)


@pytest.mark.parametrize("factor", ["1e-4", "100.0"])
@pytest.mark.parametrize("variant", [None, "cover_1e-2", "cover_1e-12", "free_sides"])
def test_constant_of_the_active_set_does_not_matter(solved, same, variant, factor):
    same(
        solved("patch", variant=variant),
        solved("patch", f"interfaces.contact.normal.c_factor={factor}", variant=variant),
    )


def test_nothing_pulls_along_a_smooth_interface(solved):
    """Not even at a node that is covered by 1e-12, whose force has no digits left."""
    (table,) = solved("patch", variant="cover_1e-12").interfaces
    assert 0 < table.coverage.min(where=table.coverage > 0, initial=1) < 2e-12
    assert abs(table.traction).max() < 1e-9 * table.pressure.max()


def test_a_load_that_is_off_is_seen(solved):
    """One per cent more pressure on one facet beside the small block: no patch any more."""
    exact = solved("patch", variant="cover_1e-2")
    off = solved("patch", 'conditions.8.traction.y="-12.53 N/mm^2"', variant="cover_1e-2")
    assert measure(exact)["contact.pressure_error_max"] < 1e-9
    assert measure(off)["contact.pressure_error_max"] > 1e-4
