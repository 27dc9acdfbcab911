"""Quarter disk of quadrilaterals around its lowest point."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import accumulate

import numpy as np

from contactfem.common.typing import Floats
from contactfem.meshes.data import MeshData
from contactfem.meshes.grid import grid

CORNER = np.pi / 3  # angle on the arc where the lower side of the array ends and its right begins


def fan(radius: float, zone: float, size: float, growth: float, coarse: float) -> MeshData:
    """Quarter of a disk above the origin, as an array between its arc, its axis and its flat side.

    The array is the transfinite map of its four sides: columns stand on the arc up to 60 degrees,
    rows start from the axis; both have the size min(coarse, size + growth * distance).

    Args:
        radius: radius of the disk, whose centre is (0, radius) [m].
        zone: x up to which facets on the arc are equal [m].
        size: length of these facets, at most [m].
        growth: increase of the cell size per distance [-].
        coarse: largest cell size [m].

    Returns:
        The mesh with the groups contact (up to `zone`), arc, flat, axis.
    """
    fine = float(np.arcsin(zone / radius))
    facets = int(np.ceil(fine * radius / size - 1e-9))
    rest = spaced(CORNER - fine, size / radius, growth, coarse / radius)
    below = np.concatenate([fine * np.arange(facets) / facets, fine + rest])
    rows = spaced(1.0, size / radius, growth, coarse / radius)
    data = grid(_points(radius, below, rows), "quadrilateral", "right")
    sides = data.groups
    groups = {
        "contact": sides["bottom"][:facets],
        "arc": np.concatenate([sides["bottom"], sides["right"]]),
        "flat": sides["top"],
        "axis": sides["left"],
    }
    return replace(data, groups=groups)


def spaced(length: float, size: float, growth: float, coarse: float) -> Floats:
    """Positions from 0 to a length, first `size` apart at most, then size + growth * distance."""

    def steps() -> Iterator[float]:
        reached = 0.0
        while reached < length:
            step = min(coarse, size + growth * reached)
            reached += step
            yield step

    positions = np.array([0.0, *accumulate(steps())])
    positions *= length / positions[-1]
    return positions


def _points(radius: float, below: Floats, rows: Floats) -> Floats:
    """Points (rows, columns, 2) from the angles of the columns and the parts of the height."""
    eta = rows[:, None, None]
    share = (below / below[-1])[None, :, None]
    beside = CORNER + (np.pi / 2 - CORNER) * rows
    top = np.stack([np.linspace(0.0, radius, len(below)), np.full(len(below), radius)], axis=-1)
    arc = _on_arc(radius, below)
    right = _on_arc(radius, beside)[:, None]
    right[-1, 0] = radius
    chord = (1 - eta) * right[:1] + eta * right[-1:]
    points: Floats = (1 - eta) * arc + eta * top + share * (right - chord)
    points[:, 0, 0] = 0.0
    return points


def _on_arc(radius: float, angle: Floats) -> Floats:
    """Points (k, 2) at angles from the lowest point."""
    on_arc: Floats = radius * np.stack([np.sin(angle), 1 - np.cos(angle)], axis=-1)
    return on_arc
