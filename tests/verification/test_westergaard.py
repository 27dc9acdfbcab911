"""Rates of convergence of the contact pressure, on meshes that match and that do not."""

import numpy as np
import pytest

from contactfem.results.expectations import measure

PAIRS = {"matching": (5, 5), "nonmortar coarser": (3, 5), "nonmortar finer": (5, 3)}
LEVELS = 2 ** np.arange(5)  # the finer side has 10 to 160 facets per wave length
# The closed form is that of the limit of small slopes and deep bodies. On the finest level the
# slope of 0.03 and the depth of one wave length would show in the full contact, with 2e-3 and 2e-4.
SHALLOW = (
    'bodies.wavy.mesh.amplitude="0.1 um"',
    'closed_form.contact.parameters.amplitude="0.1 um"',
    'closed_form.contact.parameters.mean_pressure="0.02 N/mm^2"',
    'conditions.0.traction.y="-0.02 N/mm^2"',
    'bodies.wavy.mesh.height="3 mm"',
    'bodies.flat.mesh.height="3 mm"',
    'bodies.flat.mesh.corner=["0 mm", "-3 mm"]',
)


def slope(solved, counts, *overrides, variant=None):
    """Least-squares rate of the relative L2 distance from the closed form."""
    rows = 6 if overrides else 4
    errors = []
    for level in LEVELS:
        mesh = [
            f"bodies.{body}.mesh.{n}={count * level}"
            for body, facets in zip(("wavy", "flat"), counts, strict=True)
            for n, count in (("nx", facets), ("ny", rows))
        ]
        result = solved("westergaard", *mesh, *overrides, variant=variant)
        errors.append(measure(result)["contact.pressure_error_l2"])
    return -np.polyfit(np.log(LEVELS), np.log(errors), 1)[0]


@pytest.mark.parametrize("pair", PAIRS)
def test_rate_of_partial_contact(solved, pair):
    """First order at best: the edge of the contact falls between nodes."""
    assert slope(solved, PAIRS[pair]) >= 0.7


@pytest.mark.slow
@pytest.mark.parametrize("pair", PAIRS)
def test_rate_of_half_contact(solved, pair):
    assert slope(solved, PAIRS[pair], variant="half") >= 0.7


@pytest.mark.parametrize(
    ("pair", "rate"), [("matching", 1.9), ("nonmortar coarser", 0.95), ("nonmortar finer", 0.95)]
)
def test_rate_of_full_contact(solved, pair, rate):
    assert slope(solved, PAIRS[pair], *SHALLOW, variant="full") >= rate
