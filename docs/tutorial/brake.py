"""Mesh of a brake pad on a rail, with gmsh: python3 brake.py [SIZE in mm] [FILE]."""

import sys

import gmsh

SIZE = float(sys.argv[1]) if len(sys.argv) > 1 else 1.0
FILE = sys.argv[2] if len(sys.argv) > 2 else "brake.msh"
WIDTH, HEIGHT, RADIUS = 40.0, 15.0, 3.0  # of the pad [mm]; the radius of its lower corners
LENGTH, DEPTH = 120.0, 10.0  # of the rail [mm]

Point = tuple[float, float]

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
geometry = gmsh.model.geo


def closed(points: list[Point], arcs: dict[int, Point]) -> tuple[list[int], int]:
    """Lines from each (x, y) to the next and back; where `arcs` has a centre, a quarter circle."""
    tags = [geometry.addPoint(x, y, 0.0, SIZE) for x, y in points]
    curves = []
    for k, start in enumerate(tags):
        end = tags[(k + 1) % len(tags)]
        if k in arcs:
            centre = geometry.addPoint(*arcs[k], 0.0)
            curves.append(geometry.addCircleArc(start, centre, end))
        else:
            curves.append(geometry.addLine(start, end))
    return curves, geometry.addPlaneSurface([geometry.addCurveLoop(curves)])


# the pad, counter-clockwise from the left end of its flat sole, which stands on y = 0
left, right = 10.0, 10.0 + WIDTH
pad, pad_area = closed(
    [(left + RADIUS, 0.0), (right - RADIUS, 0.0), (right, RADIUS), (right, HEIGHT),
     (left, HEIGHT), (left, RADIUS)],
    {1: (right - RADIUS, RADIUS), 5: (left + RADIUS, RADIUS)},
)  # fmt: skip
rail, rail_area = closed([(0.0, -DEPTH), (LENGTH, -DEPTH), (LENGTH, 0.0), (0.0, 0.0)], {})
geometry.synchronize()

# named groups are what the case file calls bodies and surfaces
gmsh.model.addPhysicalGroup(2, [pad_area], name="pad")
gmsh.model.addPhysicalGroup(2, [rail_area], name="rail")
gmsh.model.addPhysicalGroup(1, [pad[0]], name="sole")
gmsh.model.addPhysicalGroup(1, [pad[3]], name="back")
gmsh.model.addPhysicalGroup(1, [rail[2]], name="track")
gmsh.model.addPhysicalGroup(1, [rail[0]], name="base")

gmsh.option.setNumber("Mesh.Algorithm", 6)  # Frontal-Delaunay
gmsh.model.mesh.generate(2)
gmsh.write(FILE)
gmsh.finalize()
