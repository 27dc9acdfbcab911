"""Comparison of the facets of two surfaces, in the plane and in space."""

import numpy as np
import pytest

from contactfem.geometry.side_comparison import Comparison, Facets, compare, surface_ends


def polygon(corners, n):
    """Closed skin with n facets on each side, walked with the body on the left."""
    corners = np.asarray(corners, float)
    share = np.arange(n)[:, None] / n
    sides = [a + share * (b - a) for a, b in zip(corners, np.roll(corners, -1, 0), strict=True)]
    X = np.concatenate(sides)
    nodes = np.arange(len(X))
    return Facets(X, np.column_stack((nodes, np.roll(nodes, -1))))


def rectangle(low, high, n):
    (a, b), (c, d) = low, high
    return polygon([(a, b), (c, b), (c, d), (a, d)], n)


def patch(n, low, size, z, up):
    """Square in space at a height, as quadrilaterals in tensor order; its normal is z or -z."""
    line = np.linspace(0.0, size, n + 1)
    x, y = np.meshgrid(line + low, line + low, indexing="xy")
    X = np.column_stack((x.ravel(), y.ravel(), np.full(x.size, z)))
    i, j = (part.ravel() for part in np.meshgrid(np.arange(n), np.arange(n), indexing="xy"))
    a = i + (n + 1) * j
    nodes = np.column_stack((a, a + 1, a + n + 1, a + n + 2))
    return Facets(X, nodes if up else nodes[:, [0, 2, 1, 3]])


def triangles(side):
    a, b, c, d = side.nodes.T
    return Facets(side.X, np.concatenate((np.column_stack((a, b, d)), np.column_stack((a, d, c)))))


def test_skins_end_at_convex_corners_only():
    step = polygon([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], 4)  # one corner is inward
    ends = step.X[surface_ends(step)[:, 0]]
    assert sorted(map(tuple, ends)) == [(0, 0), (0, 2), (1, 2), (2, 0), (2, 1)]
    angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    round_one = polygon(np.column_stack((np.cos(angle), np.sin(angle))), 1)
    assert len(surface_ends(round_one)) == 0


@pytest.mark.parametrize("gap", [0.0, 0.2, -0.01])
def test_the_skin_of_a_wider_body_overhangs(gap):
    pad, slab = rectangle((0.5, 1.0 + gap), (1.5, 2.0 + gap), 8), rectangle((0, 0), (2, 1), 8)
    found = compare(pad, slab)
    assert (found.first_overhangs, found.second_overhangs) == (0, 2)
    assert found.ratio == pytest.approx(2.0)
    back = compare(slab, pad)
    assert (back.first_overhangs, back.second_overhangs) == (2, 0)


def test_equal_skins_do_not_overhang():
    found = compare(rectangle((0, 1), (1, 2), 6), rectangle((0, 0), (1, 1), 4))
    assert found == Comparison(pytest.approx(1.5), 0, 0)


@pytest.mark.parametrize("of", [lambda side: side, triangles])
def test_patches_in_space(of):
    slab, pad = of(patch(4, 0.0, 2.0, 0.0, up=True)), of(patch(5, 0.5, 1.0, 0.0, up=False))
    found = compare(pad, slab)
    assert found.ratio == pytest.approx(2.5)
    assert found.first_overhangs == 0
    assert found.second_overhangs == 20  # all nodes around the pad
    same = compare(of(patch(4, 0.0, 2.0, 0.0, up=False)), of(patch(6, 0.0, 2.0, 0.0, up=True)))
    assert same == Comparison(pytest.approx(2.0 / 3.0), 0, 0)


def test_surfaces_that_face_away_are_compared_as_wholes():
    down, up = patch(4, 0.0, 1.0, 1.0, up=True), patch(2, 0.0, 1.0, 0.0, up=False)
    assert compare(down, up) == Comparison(pytest.approx(2.0), 0, 0)
