"""Search and segments of an interface: who faces whom, and what lies in front."""

import numpy as np
import pytest

from contactfem.mortar.interface_mesh import InterfaceMesh
from contactfem.mortar.normals import nodal_normals
from contactfem.mortar.segments import cut, find_pairs, hidden

ALL = slice(None)


def segments(mesh, x, chosen=ALL, radius=0.3, differentiate=False):
    facets = np.arange(len(mesh.nonmortar))[chosen]
    normals = nodal_normals(mesh, x).n
    return cut(mesh, x, normals, find_pairs(mesh, x, normals, facets, radius), differentiate)


def over_unit_facet(*sheets):
    """Make one nonmortar facet from x = 1 to 0 and mortar facets (x_c, x_d, height) above it."""
    X = [(1.0, 0.0), (0.0, 0.0)]
    for start, end, height in sheets:
        X += [(start, height), (end, height)]
    mortar = 2 + np.arange(2 * len(sheets)).reshape(-1, 2)
    return InterfaceMesh(2, np.array([[0, 1]]), mortar, np.array(X), np.ones((len(X), 2), bool))


def rings(inner, outer, radii=(1.0, 1.02)):
    """Make a disk's polygon as nonmortar side in the hole of a ring, which walks backwards."""
    X, facets, start = [], [], 0
    for n, radius, sense in ((inner, radii[0], 1), (outer, radii[1], -1)):
        angle = sense * 2 * np.pi * (np.arange(n) + 0.3) / n
        X.append(radius * np.column_stack((np.cos(angle), np.sin(angle))))
        facets.append(start + np.column_stack((np.arange(n), (np.arange(n) + 1) % n)))
        start += n
    X = np.vstack(X)
    return InterfaceMesh(inner, *facets, X, np.ones(X.shape, bool))


def brute_force(mesh, x, normals, chosen, radius):
    """Every nonmortar facet against every mortar one: boxes that meet, and facing each other.

    The search may leave out those of them that are beside what a facet sweeps.
    """
    pairs = []
    for e in chosen:
        ends = mesh.nonmortar[e]
        swept = np.concatenate([x[ends] + r * normals[ends] for r in (-radius, radius)])
        for f, facet in enumerate(mesh.mortar):
            apart = (swept.min(0) > x[facet].max(0)) | (swept.max(0) < x[facet].min(0))
            edges = [x[pair[1]] - x[pair[0]] for pair in (ends, facet)]
            if not apart.any() and edges[0] @ edges[1] < 0:
                pairs.append((e, f))
    return np.array(pairs).reshape(-1, 2)


@pytest.mark.parametrize(
    ("nonmortar", "mortar", "radius"), [(20, 31, 0.01), (31, 7, 0.05), (1, 40, 0.3), (50, 50, 5)]
)
def test_pairs_against_brute_force(chains, nonmortar, mortar, radius):
    """Also for some facets only, as every rank searches for its own."""
    mesh, x = chains(nonmortar, mortar, seed=2, wave=0.1)
    normals = nodal_normals(mesh, x).n
    for chosen in (np.arange(nonmortar), np.arange(nonmortar)[::3], np.arange(0)):
        found = find_pairs(mesh, x, normals, chosen, radius)
        boxes = brute_force(mesh, x, normals, chosen, radius)
        assert {tuple(pair) for pair in found} <= {tuple(pair) for pair in boxes}
        np.testing.assert_array_equal(found, found[np.lexsort((found[:, 1], found[:, 0]))])
        every = cut(mesh, x, normals, boxes, differentiate=False)
        some = cut(mesh, x, normals, found, differentiate=False)
        np.testing.assert_array_equal(some.facets, every.facets)
        np.testing.assert_array_equal(some.integrals, every.integrals)


def test_pairs_when_most_facets_meet():
    """More pairs than there was room for at first."""
    mesh = over_unit_facet(*[(-0.1, 1.1, 0.1 + 1e-3 * k) for k in range(30)])
    many = InterfaceMesh(2, np.repeat(mesh.nonmortar, 40, 0), mesh.mortar, mesh.X, mesh.free)
    normals = np.tile((0.0, 1.0), (2, 1))
    found = find_pairs(many, many.X, normals, np.arange(40), 0.2)
    np.testing.assert_array_equal(found, np.indices((40, 30)).reshape(2, -1).T)


@pytest.mark.parametrize("radius", [0.0, -0.1, np.nan])
def test_bad_radius(chains, radius):
    """The kernel refuses it, and its refusal is not taken for a number of pairs."""
    mesh, x = chains()
    with pytest.raises(ValueError, match="search radius"):
        find_pairs(mesh, x, nodal_normals(mesh, x).n, np.arange(3), radius)


def test_segments_join_without_gap_or_overlap(chains):
    """Segments fill the facets that the chain covers wholly; beyond its ends there is none."""
    mesh, x = chains(nonmortar=6, mortar=17, span=(0.25, 1.1))
    found = segments(mesh, x)
    for f in range(6):
        spans = found.span[found.facets[:, 0] == f]
        spans = spans[np.argsort(spans[:, 0])]
        np.testing.assert_array_equal(spans[1:, 0], spans[:-1, 1])
        if x[mesh.nonmortar[f, 1], 0] > 0.3:
            assert (spans[0, 0], spans[-1, 1]) == (-1.0, 1.0)
    beyond = np.flatnonzero(x[mesh.nonmortar[:, 0], 0] < 0.22)
    assert len(beyond)
    assert not np.isin(beyond, found.facets[:, 0]).any()


@pytest.mark.parametrize("differentiate", [False, True])
def test_nothing_near(chains, differentiate):
    """Far bodies give empty arrays of the right shapes."""
    mesh, x = chains()
    x[mesh.n_nonmortar :, 1] += 10
    found = segments(mesh, x, differentiate=differentiate)
    assert [len(part) for part in (found.facets, found.span, found.integrals)] == [0, 0, 0]
    assert (found.derivatives.shape == (0, 7, 12)) if differentiate else found.derivatives is None


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("span", [(0.0, 1.0), (0.0, 0.5), (0.3, 0.7), (-0.4, 0.2)])
def test_nearest_of_two_sheets(span, order):
    """A sheet behind another one does not count, in whatever order they are numbered.

    Together two sheets over half the facet cover no more than one over the whole facet.
    """
    near, far = (*span, 0.1), (*span, 0.2)
    mesh = over_unit_facet(*(near, far)[::order])
    found = segments(mesh, mesh.X)
    np.testing.assert_array_equal(found.facets, [[0, 0 if order == 1 else 1]])
    length = min(span[1], 1.0) - max(span[0], 0.0)
    assert found.integrals[0, :3] @ (1, 2, 1) == pytest.approx(length, rel=1e-14)


def test_penetrated_sheet_is_near():
    """Distance counts, not side: slight penetration is nearer than a sheet above."""
    mesh = over_unit_facet((0.0, 1.0, 0.1), (0.0, 1.0, -0.05))
    np.testing.assert_array_equal(segments(mesh, mesh.X).facets, [[0, 1]])


def test_sheets_side_by_side_all_count():
    """Neighbours at different heights are not in front of each other."""
    mesh = over_unit_facet((0.0, 0.4, 0.1), (0.4, 0.7, 0.2), (0.7, 1.0, 0.05))
    found = segments(mesh, mesh.X)
    np.testing.assert_array_equal(found.facets[:, 1], [0, 1, 2])
    assert found.integrals[:, :3].sum(0) @ (1, 2, 1) == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize(("inner", "outer"), [(12, 12), (24, 17), (7, 40)])
def test_ring_does_not_see_its_far_side(inner, outer):
    """However large the search radius, a disk in a hole is covered once all around."""
    mesh = rings(inner, outer)
    found = segments(mesh, mesh.X, radius=5.0)
    covered = np.bincount(found.facets[:, 0], found.span[:, 1] - found.span[:, 0])
    np.testing.assert_allclose(covered, 2.0, rtol=1e-12)
    nm, m = mesh.nonmortar[found.facets[:, 0]], mesh.mortar[found.facets[:, 1]]
    middles = [mesh.X[facet].mean(1) for facet in (nm, m)]
    assert (np.einsum("si,si->s", *middles) > 0).all()


def test_sides_that_look_away_are_not_paired():
    """A mortar facet walked the other way has its body on this side."""
    mesh = over_unit_facet((1.0, 0.0, 0.1))
    assert len(segments(mesh, mesh.X).facets) == 0


def hidden_one_by_one(facet, span, distance, keep):
    """The definition of `hidden`, segment by segment from near to far."""
    found = []
    for f in np.unique(facet):
        stands = []
        mine = np.flatnonzero(keep & (facet == f))
        for s in mine[np.argsort(distance[mine], kind="stable")]:
            if any(span[q, 0] < span[s].mean() < span[q, 1] for q in stands):
                found.append(s)
            else:
                stands.append(s)
    return sorted(found)


@pytest.mark.parametrize("seed", range(20))
def test_hidden_segments_of_many_facets(seed):
    rng = np.random.default_rng(seed)
    n = rng.integers(40, 80)
    facet = np.sort(rng.integers(0, 12, n))
    start = rng.uniform(-1, 1, n)
    span = np.column_stack((start, start + rng.uniform(0.01, 0.8, n)))
    distance = rng.integers(0, 5, n).astype(float)  # some are equal
    keep = rng.random(n) < 0.8
    found = hidden(facet, span, distance, keep)
    assert sorted(found.tolist()) == hidden_one_by_one(facet, span, distance, keep)
    assert len(found) > 0
