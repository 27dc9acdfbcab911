"""Every builder's mesh fills its outline, with named sides that face outward."""

import signal
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from contactfem.errors import MeshError
from contactfem.meshes import BUILDERS, Builder, MeshSpec
from contactfem.meshes.curves import Edge
from contactfem.meshes.data import MeshData, boundary_facets, jacobians, mesh_data
from contactfem.meshes.polygon import triangulate

PI = np.pi
BLOCK = {"builder": "block", "width": "2 m", "height": "1 m", "nx": 7, "ny": 4}
WAVE = {"builder": "wave", "width": "2 m", "height": "1 m", "nx": 16, "ny": 3}
WAVE |= {"amplitude": "10 mm", "wavelength": "2 m"}
DISK = {"builder": "cylinder", "radius": "8 mm", "zone": "0.9 mm", "size": "50 um", "growth": 0.2}
FINE = {"builder": "graded_block", "width": "100 mm", "height": "200 mm", "zone": ["0 mm", "9 mm"]}
FINE |= {"size": "0.5 mm", "growth": 0.2}
BOX = {"builder": "box", "width": "2 m", "height": "1 m", "depth": "3 m", "nx": 3, "ny": 2, "nz": 4}
DIE = {"builder": "die", "width": "1.2 m", "straight": "0.9 m", "radius": "0.75 m", "n_side": 7}
DIE |= {"point": ["1 m", "2 m"], "n_arc": 96}
TIRE = {"builder": "tire", "point": ["1 m", "2 m"], "size": "5 mm", "tread_size": "1 mm"}
EXTRUDED = {"builder": "extrusion", "plane": BLOCK, "depth": "3 m", "layers": 2}
HOOP = {"builder": "ring", "inner_radius": "2 m", "outer_radius": "3 m", "facets": 36, "layers": 4}
AWAY = BLOCK | {"corner": ["1 m", "2 m"]}
REVOLVED = {"builder": "revolution", "plane": AWAY, "layers": 24}
GRADED = {"builder": "graded_box", "width": "2 m", "height": "1 m", "depth": "2 m"}
GRADED |= {"zone_x": ["0.8 m", "1.2 m"], "zone_z": ["0.8 m", "1.2 m"], "size": "0.1 m"}
FLAT: dict[str, dict[str, Any]] = {
    "block": BLOCK,
    "graded": BLOCK | {"grading": [3, 0.5], "corner": ["-1 m", "2 m"]},
    "right": BLOCK | {"cell": "triangle"},
    "left": BLOCK | {"cell": "triangle", "pattern": "left"},
    "alternating": BLOCK | {"cell": "triangle", "pattern": "alternating"},
    "crossed": BLOCK | {"cell": "triangle", "pattern": "crossed"},
    "one cell": BLOCK | {"nx": 1, "ny": 1},
    "split": BLOCK | {"nx": 5, "corner": ["-1 m", "2 m"], "split": ["-0.6 m", "0.6 m"]},
    "wave below": WAVE,
    "wave above": WAVE | {"side": "top", "width": "1 m", "grading": [1, 0.2], "cell": "triangle"},
    "half disk": DISK,
    "lower half disk": DISK | {"side": "lower", "point": ["1 mm", "2 mm"]},
    "quarter disk": DISK | {"part": "quarter"},
    "lower quarter disk": DISK | {"part": "quarter", "side": "lower", "point": ["1 mm", "2 mm"]},
    "array half disk": DISK | {"cell": "quadrilateral"},
    "array lower quarter disk": DISK
    | {"part": "quarter", "side": "lower", "point": ["1 mm", "2 mm"], "cell": "quadrilateral"},
    "fine corner": FINE | {"corner": ["0 mm", "-200 mm"]},
    "fine below": FINE | {"zone": ["20 mm", "40 mm"], "side": "bottom"},
    "fine side": FINE | {"zone": ["0 mm", "100 mm"], "size": "2 mm"},
    "die": DIE,
    "tire": TIRE,
    "flat tire": TIRE | {"crown": "0 mm", "tread_size": "2 mm"},
}
ROUND: dict[str, dict[str, Any]] = {
    "disk": {"builder": "disk", "radius": "2 m", "center": ["1 m", "2 m"], "facets": 40}
    | {"layers": 4},
    "ring": {"builder": "ring", "inner_radius": "2 m", "outer_radius": "3 m", "facets": 36}
    | {"layers": 4, "center": ["1 m", "2 m"]},
}
SOLID: dict[str, dict[str, Any]] = {
    "hexahedra": BOX,
    "tetrahedra": BOX | {"cell": "tetrahedron", "corner": ["1 m", "2 m", "3 m"]},
    "turned": BOX | {"cell": "tetrahedron", "rotate": 1},
    "extruded block": EXTRUDED,
    "extruded triangles": EXTRUDED | {"plane": BLOCK | {"cell": "triangle"}, "z": "1 m"},
    "extruded ring": EXTRUDED | {"plane": HOOP},
    "tube": REVOLVED,
    "tube of tetrahedra": REVOLVED | {"plane": AWAY | {"cell": "triangle"}},
    "rod": REVOLVED | {"plane": BLOCK},
    "quarter of a rod": REVOLVED | {"plane": BLOCK, "angle": 90.0, "layers": 6},
    "eighth of a ball": REVOLVED
    | {"plane": DISK | {"part": "quarter", "size": "0.3 mm"}}
    | {"angle": 90.0, "layers": 9},
    "fine box": GRADED,
    "fine tetrahedra": GRADED | {"cell": "tetrahedron", "zone_x": ["0 m", "1 m"]},
    "round box": GRADED | {"side": "bottom", "radius_x": "9 m", "radius_z": "9 m"},
    "cylindrical box": GRADED | {"radius_x": "9 m"},
}
ALL = FLAT | ROUND | SOLID


def spec(**table: Any) -> Builder:
    return TypeAdapter(MeshSpec).validate_python(table, context={"strict_units": True})


@pytest.fixture(scope="module")
def built() -> Callable[[str], MeshData]:
    known: dict[str, MeshData] = {}
    return lambda name: known.setdefault(name, spec(**ALL[name]).build())


def enclosed(polyline: np.ndarray) -> float:
    """Its share of the area inside a counter-clockwise boundary, ∮ x dy - y dx over 2."""
    (x, y), (dx, dy) = (polyline[:-1] + polyline[1:]).T / 2, np.diff(polyline, axis=0).T
    return float(np.sum(x * dy - y * dx)) / 2


def arcs_area(body: Builder) -> float:
    """Area of a body bounded by lines and arcs: of the polygon of their ends, and segments."""
    edges = [edge for loop in body.curves() for edge in loop if isinstance(edge, Edge)]
    polygon = sum(enclosed(np.array([edge.start, edge.end])) for edge in edges)
    arcs = [(np.hypot(*np.subtract(e.start, e.centre)), e.angle()) for e in edges if e.centre]
    return polygon + sum(r**2 * (angle - np.sin(angle)) / 2 for r, angle in arcs)


def test_every_builder_is_tested() -> None:
    assert {table["builder"] for table in ALL.values()} == set(BUILDERS)


@pytest.mark.parametrize("name", ALL)
def test_groups_cover_the_boundary_outward(name: str, built: Callable[[str], MeshData]) -> None:
    """Every boundary facet is in a group, turned like its cell; only parts of sides are in two."""
    data = built(name)
    assert np.all(jacobians(data.points, data.cells, data.cell_type) > 0)
    assert np.array_equal(np.unique(data.cells), np.arange(len(data.points)))
    boundary = {tuple(f) for f in boundary_facets(data.cells, data.cell_type)}
    sides = [fs for group, fs in data.groups.items() if not group.startswith(("contact", "top_"))]
    named = [tuple(f) for fs in sides for f in fs]
    assert len(named) == len(boundary)
    assert set(named) == boundary
    if "contact" in data.groups:
        parent = data.groups["arc" if "arc" in data.groups else ALL[name].get("side", "top")]
        assert {tuple(f) for f in data.groups["contact"]} <= {tuple(f) for f in parent}


def test_parts_of_the_top(built: Callable[[str], MeshData]) -> None:
    """One after the other from left to right they are the top."""
    data = built("split")
    parts = [data.groups[f"top_{k}"] for k in (1, 2, 3)]
    assert [len(part) for part in parts] == [1, 3, 1]
    assert np.array_equal(np.concatenate(parts[::-1]), data.groups["top"])
    assert data.surface("top_2").X[:, 0].max() == pytest.approx(0.6)


@pytest.mark.parametrize("name", FLAT)
def test_area_by_cells_and_by_boundary(name: str, built: Callable[[str], MeshData]) -> None:
    """Cells add up to what the oriented boundary encloses: no overlap, no hole, all outward."""
    data = built(name)
    share = 0.5 if data.cell_type == "triangle" else 1.0
    area = share * jacobians(data.points, data.cells, data.cell_type).mean(axis=1).sum()
    around = boundary_facets(data.cells, data.cell_type)
    assert area == pytest.approx(sum(enclosed(data.points[f]) for f in around), rel=1e-12)
    exact = {"block": 2.0, "wave": 2.0 - 0.02, "cylinder": PI * 32e-6, "graded_block": 0.02}
    exact["tire"] = arcs_area(spec(**ALL[name])) if "tire" in name else 0.0
    exact["die"] = 1.2 * 0.9 + 0.75**2 * np.arcsin(0.8) - 0.6 * 0.45
    expected = exact[ALL[name]["builder"]]
    expected *= 0.5 if "quarter" in name or name == "wave above" else 1.0
    assert area == pytest.approx(expected, rel=4e-3 if "di" in name or "tire" in name else 1e-12)


@pytest.mark.parametrize("name", FLAT)
def test_outline_is_the_boundary(name: str, built: Callable[[str], MeshData]) -> None:
    """Same groups, ends and direction as the mesh; the same area up to the chords of an arc."""
    data, outline = built(name), spec(**ALL[name]).outline()
    assert outline.keys() == data.groups.keys()
    size = np.ptp(data.points)
    for group, line in outline.items():
        walk = data.surface(group)
        chain = np.arange(len(walk.vertices))
        assert np.array_equal(walk.facets, np.stack([chain[:-1], chain[1:]], axis=1))
        np.testing.assert_allclose(line[[0, -1]], walk.X[[0, -1]], atol=1e-14 * size)
        straight = group not in ("arc", "contact", "sole") and "tire" not in name
        error = (1e-14 if straight else 2e-3) * size**2
        assert enclosed(line) == pytest.approx(enclosed(walk.X), abs=error)
    low, high = spec(**ALL[name]).extent()
    np.testing.assert_allclose(data.points.min(axis=0), low, atol=1e-4 * size)
    np.testing.assert_allclose(data.points.max(axis=0), high, atol=1e-4 * size)


@pytest.mark.parametrize("name", ROUND)
def test_round_bodies_are_as_large_as_their_circles(
    name: str, built: Callable[[str], MeshData]
) -> None:
    """Polygons that touch have the area of the circle; the outline is the mesh's boundary."""
    data, outline = built(name), spec(**ALL[name]).outline()
    area = jacobians(data.points, data.cells, data.cell_type).mean(axis=1).sum()
    corners = 9 * 18 * np.sin(PI / 18)  # of the ring's outer polygon, on the circle
    assert area == pytest.approx(4 * PI if name == "disk" else corners - 4 * PI, rel=1e-12)
    for group, line in outline.items():
        chain = data.points[data.groups[group]]
        assert enclosed(line) == pytest.approx(sum(enclosed(facet) for facet in chain), rel=1e-12)
        np.testing.assert_allclose(line[0], line[-1])
        assert {tuple(x) for x in np.round(line, 9)} == {tuple(x) for x in np.round(chain[:, 0], 9)}
    on_axes = {"disk": [(1, 2)], "ring": [(4, 2), (1, 5), (-2, 2), (1, -1)]}[name]
    for x in on_axes:
        assert np.hypot(*(data.points - x).T).min() < 1e-14


@pytest.mark.parametrize("name", ["hexahedra", "tetrahedra", "turned"])
def test_boxes(name: str, built: Callable[[str], MeshData]) -> None:
    """Volume by cells and, through the divergence of x/3, by the oriented sides."""
    data = built(name)
    assert volume(data) == pytest.approx(6, rel=1e-13)
    flux = 0.0
    for facets in data.groups.values():
        a, b, c = np.moveaxis(data.points[facets[:, :3]], 1, 0)
        middle = data.points[facets].mean(axis=1)
        normal = np.cross(b - a, c - a) / (2 if data.cell_type == "tetrahedron" else 1)
        flux += float(np.sum(middle * normal)) / 3
    assert flux == pytest.approx(6, rel=1e-13)
    outline = spec(**ALL[name]).outline()
    for group, corners in outline.items():
        X = data.surface(group).X
        np.testing.assert_allclose(
            [X.min(axis=0), X.max(axis=0)], [corners.min(axis=0), corners.max(axis=0)], atol=1e-14
        )


def test_turned_tetrahedra_do_not_match(built: Callable[[str], MeshData]) -> None:
    plain, turned = (
        {tuple(np.sort(f)) for f in built_.groups["top"]}
        for built_ in (spec(**BOX | {"cell": "tetrahedron"}).build(), built("turned"))
    )
    assert not plain & turned


@pytest.mark.parametrize("ratio", [1.0, 4.0, 0.25])
def test_grading(ratio: float) -> None:
    """Neighbouring cells grow by one factor; last over first is the ratio."""
    X = spec(**BLOCK | {"grading": [ratio, 1]}).build().surface("bottom").X[:, 0]
    sizes = np.diff(X)
    np.testing.assert_allclose(sizes[1:] / sizes[:-1], ratio ** (1 / 6), rtol=1e-12)
    assert X[0] == 0 and X[-1] == 2


def test_wave_is_the_formula() -> None:
    data = spec(**WAVE | {"corner": ["1 m", "5 m"], "crest": "0.5 m"}).build()
    x, y = data.surface("bottom").X.T
    np.testing.assert_allclose(y, 5 + 0.01 * (1 - np.cos(PI * (x - 0.5))), rtol=1e-15)
    assert np.allclose(data.surface("top").X[:, 1], 6, rtol=1e-15)


@pytest.mark.parametrize("name", ["half disk", "lower half disk", "quarter disk"])
def test_fine_facets_are_equal_and_on_the_circle(
    name: str, built: Callable[[str], MeshData]
) -> None:
    data = built(name)
    centre = np.array([1e-3, 2e-3 - 8e-3]) if "lower" in name else np.array([0, 8e-3])
    arc = data.surface("arc").X - centre
    np.testing.assert_allclose(np.hypot(*arc.T), 8e-3, rtol=1e-15)
    fine = data.surface("contact").X
    lengths = np.hypot(*np.diff(fine, axis=0).T)
    assert np.ptp(lengths) < 1e-12 * lengths[0]
    assert 0.9 * 50e-6 < lengths[0] <= 50e-6
    assert np.max(np.abs(fine[:, 0] - centre[0])) == pytest.approx(0.9e-3, rel=1e-12)
    touching = centre + np.array([0, 8e-3 if "lower" in name else -8e-3])
    assert np.min(np.abs(fine - touching).sum(axis=1)) < 1e-17 + 1e-15 * np.abs(touching).sum()


def test_half_disk_is_symmetric(built: Callable[[str], MeshData]) -> None:
    points = built("half disk").points
    mirrored = {tuple(p) for p in points * [-1, 1] + 0.0}
    assert mirrored == {tuple(p) for p in points + 0.0}


def test_cells_grow_away_from_the_fine_edge(built: Callable[[str], MeshData]) -> None:
    """Cell size is size + growth * distance within a factor of two; the fine part is even."""
    data = built("fine below")
    middle = data.points[data.cells].mean(axis=1)
    length = np.sqrt(jacobians(data.points, data.cells, "triangle")[:, 0] * 2 / np.sqrt(3))
    aside = np.maximum(0, np.abs(middle[:, 0] - 30e-3) - 10e-3)
    wanted = np.minimum(0.5e-3 + 0.2 * np.hypot(aside, middle[:, 1]), 25e-3)
    assert np.all((length < 2 * wanted) & (length > wanted / 2))
    lengths = np.diff(data.surface("contact").X[:, 0])
    np.testing.assert_allclose(lengths, 0.5e-3, rtol=1e-12)


def test_tire_is_smooth_and_symmetric(built: Callable[[str], MeshData]) -> None:
    """Arcs of either surface meet without a corner; walls are as thick as asked for."""
    body, data = spec(**TIRE), built("tire")
    (loop,) = body.curves()
    smooth, sharp = [], []
    for before, after in zip(loop, (*loop[1:], loop[0]), strict=True):
        a, b = before.at(np.array([1 - 1e-7, 1])), after.at(np.array([0, 1e-7]))
        (ax, ay), (bx, by) = a[1] - a[0], b[1] - b[0]
        at_flange = any("flange" in name for name in before.groups + after.groups)
        (sharp if at_flange else smooth).append(
            abs(np.arctan2(ax * by - ay * bx, ax * bx + ay * by))
        )
    assert len(sharp) == 4 and min(sharp) > 0.5
    assert max(smooth) < 1e-6
    points = np.round((data.points - [1, 2]) * 1e12).astype(int)
    assert {tuple(p) for p in points} == {tuple(p) for p in points * [-1, 1]}
    x, y = (data.surface("inner").X - [1, 2]).T
    assert y.min() == pytest.approx(0.02, rel=1e-12)
    assert x.max() == pytest.approx(0.088, rel=2e-3)
    left, right = data.surface("left_flange").X, data.surface("right_flange").X
    np.testing.assert_allclose(np.ptp(left[:, 0]), 0.018, rtol=1e-12)
    np.testing.assert_allclose(np.sort(2 - left[:, 0]), np.sort(right[:, 0]), rtol=1e-12)
    np.testing.assert_allclose(right[:, 1], 2.15, rtol=1e-15)


def test_same_mesh_every_time() -> None:
    first, second = (spec(**DISK).build() for _ in range(2))
    assert np.array_equal(first.points, second.points)
    assert np.array_equal(first.cells, second.cells)


def test_gmsh_leaves_the_signal_handler_alone() -> None:
    """A run that writes its state when interrupted must still be able to after meshing."""
    before = signal.getsignal(signal.SIGINT)
    spec(**DISK).build()
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"builder": "sphere"}, "block, box, cylinder"),
        ({}, "'file' or a 'builder'"),
        (BLOCK | {"nx": 0}, "greater than or equal to 1"),
        (BLOCK | {"height": "-1 m"}, "greater than 0"),
        (BLOCK | {"height": "1 s"}, "length"),
        (BLOCK | {"depth": "1 m"}, "depth"),
        (BLOCK | {"nx": 5, "split": ["0.5 m"]}, "split: no line of the array is at x = 0.5 m"),
        (BLOCK | {"nx": 5, "split": ["0.8 m", "0.4 m"]}, "split: positions are out of order"),
        (DISK | {"zone": "8 mm"}, "zone: must be smaller"),
        (DISK | {"size": "1 mm"}, "size: must not be larger"),
        (DIE | {"width": "1.6 m"}, "width: must be smaller than the diameter"),
        (ROUND["disk"] | {"facets": 12}, "multiple of 8"),
        (ROUND["ring"] | {"outer_radius": "2 m"}, "outer_radius: must be larger"),
        (FINE | {"zone": ["9 mm", "101 mm"]}, "zone: must be a part"),
        (TIRE | {"rim_width": "200 mm"}, "rim_width: must be smaller than the width"),
        (TIRE | {"tread_width": "150 mm"}, "tread_width: with both shoulders"),
        (TIRE | {"crown": "70 mm"}, "crown: must be smaller than half"),
        (TIRE | {"crown": "65 mm"}, "crown: must be smaller for this tread_thickness"),
        (TIRE | {"tread_size": "6 mm"}, "tread_size: must not be larger"),
        (TIRE | {"flange_thickness": "80 mm"}, "flange_thickness: must be smaller than half"),
        (TIRE | {"wall_thickness": "50 mm"}, "wall_thickness: the inner surface must be wider"),
        (TIRE | {"inner_shoulder": "90 mm"}, "inner_shoulder: leaves no width"),
        (TIRE | {"height": "40 mm"}, "height: leaves no room for round sidewalls"),
        (TIRE | {"tread_thickness": "80 mm", "inner_shoulder": "1 mm"}, "inner surface comes as"),
    ],
)
def test_wrong_parameters(table: dict[str, Any], words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        spec(**table)


def test_unusable_meshes() -> None:
    square = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    with pytest.raises(MeshError, match="flat or twisted"):
        mesh_data(square, np.array([[0, 1, 3, 2]]), "quadrilateral", {})
    with pytest.raises(MeshError, match="group 'cut': 1 of 1 facets are not on"):
        mesh_data(square, np.array([[0, 1, 3], [0, 3, 2]]), "triangle", {"cut": np.array([[0, 3]])})
    data = mesh_data(square, np.array([[0, 1, 2]]), "triangle", {"none": np.empty((0, 2), int)})
    assert len(data.points) == 3
    with pytest.raises(MeshError, match="'none' has no facets"):
        data.surface("none")
    with pytest.raises(MeshError, match="'lid' is not a group of this mesh; groups: none"):
        data.surface("lid")
    with pytest.raises(MeshError, match="gmsh cannot mesh"):
        there, back = ((0.0, 0.0), (1.0, 0.0)), ((1.0, 0.0), (0.0, 0.0))
        triangulate([Edge(*there, ("side",), fine=True), Edge(*back, ("side",))], 0.1, 0.1, 0.2)


@pytest.mark.parametrize(
    ("points", "cells", "message"),
    [
        ([[0, 0], [1, 0], [0, 1]], np.empty((0, 3), int), "has no cells"),
        ([[0, 0], [1, 0], [0, 1]], [[0, 1, 3]], "vertices that are none of its 3 points"),
        ([[0, 0], [1, 0], [0, 1]], [[0, 1, -1]], "vertices that are none of its 3 points"),
        ([[0, 0], [1, 0], [0, np.nan]], [[0, 1, 2]], "1 points have coordinates that are not"),
        ([[0, 0], [1, 0], [0, 1e200]], [[0, 1, 2]], "1 points have coordinates .* beyond 1e[+]30"),
        ([[0, 0], [1e-99, 0], [0, 1e-99]], [[0, 1, 2]], "all of whose points lie within 1e-30 m"),
    ],
)
def test_points_that_are_nowhere(points: Any, cells: Any, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        mesh_data(np.array(points, float), np.array(cells), "triangle", {})


TOO_MANY = {
    "block": {"width": "1 m", "height": "1 m", "nx": 100_000, "ny": 51},
    "box": {"width": "1 m", "height": "1 m", "depth": "1 m", "nx": 200, "ny": 200, "nz": 200},
    "die": {"width": "1 m", "straight": "1 m", "radius": "2 m", "n_arc": 5000, "n_side": 5000},
    "disk": {"radius": "1 m", "facets": 80_000, "layers": 1},
    "ring": {"inner_radius": "1 m", "outer_radius": "2 m", "facets": 80_000, "layers": 100},
    "cylinder": {"radius": "1 m", "zone": "0.1 m", "size": "1e-12 m"},
    "graded_block": {
        "width": "1 m", "height": "1 m", "zone": ["0 m", "1 m"], "size": "0.1 mm", "growth": 1e-9,
    },
    "tire": {"tread_size": "1e-12 m"},
}  # fmt: skip


@pytest.mark.parametrize("name", TOO_MANY)
def test_meshes_of_too_many_cells_are_refused_before_they_are_made(name: str) -> None:
    with pytest.raises(ValidationError, match=r"asks for .* cells; a body may have 5e\+06"):
        spec(builder=name, **TOO_MANY[name])


@pytest.mark.parametrize("name", ["cylinder", "graded_block", "tire"])
@pytest.mark.parametrize("growth", [0.02, 0.1, 0.5])
def test_cells_are_counted_before_they_are_made(name: str, growth: float) -> None:
    """The estimate is right by a factor of three: it only has to tell many from too many."""
    table = {
        "cylinder": {"radius": "1 m", "zone": "0.2 m", "size": "0.02 m", "part": "quarter"},
        "graded_block": {
            "width": "2 m", "height": "1 m", "zone": ["0.5 m", "0.8 m"], "size": "0.02 m",
        },
        "tire": {},
    }[name]  # fmt: skip
    body = spec(builder=name, growth=growth, **table)
    made = len(body.build().cells) / (2 if name == "tire" else 1)
    assert made / 3 < body.cell_count() < 3 * made


def test_mirrored_cells_are_turned() -> None:
    square = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]) * [-1, 1]
    data = mesh_data(square, np.array([[0, 1, 2, 3]]), "quadrilateral", {"low": np.array([[0, 1]])})
    assert np.all(jacobians(data.points, data.cells, data.cell_type) > 0)
    assert data.groups["low"].tolist() == [[1, 0]]


def test_a_surface_of_two_chains_is_walked_chain_by_chain() -> None:
    data = spec(**BLOCK).build()
    both = np.concatenate([data.groups["top"][::-1], data.groups["bottom"]])
    surface = mesh_data(data.points, data.cells, data.cell_type, {"both": both}).surface("both")
    np.testing.assert_array_equal(surface.facets[:, 1] - surface.facets[:, 0], 1)
    assert np.sum(surface.facets[1:, 0] != surface.facets[:-1, 1]) == 1


def volume(data: MeshData) -> float:
    """Of the cells: tetrahedra, or hexahedra by the mean of their corners' Jacobians."""
    share = 1.0 / 6.0 if data.cell_type == "tetrahedron" else 1.0
    return share * float(jacobians(data.points, data.cells, data.cell_type).mean(axis=1).sum())


def polygon(sides: int) -> float:
    """Area of a regular polygon in the unit circle."""
    return 0.5 * sides * np.sin(2.0 * PI / sides)


@pytest.mark.parametrize(
    ("name", "exact"),
    [
        ("extruded block", 6.0),
        ("extruded triangles", 6.0),
        ("tube", (9.0 - 1.0) * polygon(24)),
        ("tube of tetrahedra", (9.0 - 1.0) * polygon(24)),
        ("rod", 4.0 * polygon(24)),
        ("quarter of a rod", polygon(24)),
        ("fine box", 4.0),
        ("fine tetrahedra", 4.0),
    ],
)
def test_volume_of_swept_and_graded_bodies(
    name: str, exact: float, built: Callable[[str], MeshData]
) -> None:
    assert volume(built(name)) == pytest.approx(exact, rel=1e-12)


def test_round_sides_are_round(built: Callable[[str], MeshData]) -> None:
    """Nodes of the fine side lie on the sphere or the cylinder."""
    X = built("round box").surface("bottom").X - [1.0, 9.0, 1.0]
    assert np.linalg.norm(X, axis=1) == pytest.approx(9.0, rel=1e-14)
    X = built("cylindrical box").surface("top").X - [1.0, 1.0 - 9.0, 1.0]
    assert np.hypot(X[:, 0], X[:, 1]) == pytest.approx(9.0, rel=1e-14)


def test_fine_zone_has_the_size(built: Callable[[str], MeshData]) -> None:
    facets = built("fine box").groups["contact"]
    assert len(facets) == 16
    edges = np.ptp(built("fine box").points[facets], axis=1)
    assert edges[:, [0, 2]] == pytest.approx(0.1, rel=1e-12)


@pytest.mark.parametrize("name", SOLID)
def test_outlines_of_solids_bound_their_surfaces(
    name: str, built: Callable[[str], MeshData]
) -> None:
    """Every surface is as wide as its outline, to a chord of the arcs."""
    data, outline = built(name), spec(**ALL[name]).outline()
    size = np.ptp(data.points, axis=0).max()
    assert data.groups.keys() <= outline.keys()
    for group in data.groups:
        X = data.surface(group).X
        line = outline[group]
        assert X.min(axis=0) == pytest.approx(line.min(axis=0), abs=0.02 * size)
        assert X.max(axis=0) == pytest.approx(line.max(axis=0), abs=0.02 * size)


def test_a_swept_arc_is_part_of_a_sphere(built: Callable[[str], MeshData]) -> None:
    X = built("eighth of a ball").surface("arc").X - [0.0, 8e-3, 0.0]
    assert np.linalg.norm(X, axis=1) == pytest.approx(8e-3, rel=1e-12)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (REVOLVED | {"plane": BLOCK | {"corner": ["-1 m", "0 m"]}}, "x is the distance"),
        (REVOLVED | {"layers": 2}, "at least 3"),
        (GRADED | {"zone_x": ["-1 m", "1 m"]}, "zone_x"),
        (GRADED | {"radius_x": "1 m", "height": "0.9 m"}, "round side"),
    ],
)
def test_solid_builders_refuse(table: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        spec(**table)
