"""Plane meshes in pictures: triangles, outlines, and how displacements are magnified."""

from __future__ import annotations

import math

import numpy as np

from contactfem.common.typing import Floats
from contactfem.geometry.cells import cell_edges
from contactfem.results.data import InterfaceTable, RunResult

SHOWN_STRAIN = 0.06  # to which share of the scene's size small displacements are magnified
GAP_SHOWN = 0.05  # a first gap larger than this share of the displacements forbids to magnify them


def _mortar_before(result: RunResult, table: InterfaceTable) -> Floats | None:
    """Return where the mortar nodes of an interface started, None for a curved obstacle."""
    side = result.case.interfaces[table.name].mortar
    if side in result.case.obstacles:
        obstacle = result.case.obstacles[side]
        if obstacle.shape != "plane":
            return None
        normal, point = np.array(obstacle.normal), np.array(obstacle.point)
        above = (table.X - point) @ normal / float(normal @ normal)
        before: Floats = table.X - above[:, None] * normal
        return before
    body = next(body for body in result.bodies if body.name == side.partition(".")[0])
    rim = np.unique(cell_edges(body.cells)[1])
    now = body.points[rim] + body.displacement[rim]
    nearest = [int(np.argmin(np.sum((now - x) ** 2, axis=1))) for x in table.mortar_x]
    return body.points[rim[nearest]]


def _closed_at_start(result: RunResult, moved: float) -> bool:
    """Whether all interfaces started on straight lines without a gap, to a part of what moved."""
    for table in result.interfaces:
        before = _mortar_before(result, table)
        if before is None:
            return False
        away = np.concatenate([table.X, before]) - table.X.mean(axis=0)
        normal = np.linalg.svd(table.X - table.X.mean(axis=0))[2][-1]
        if np.abs(away @ normal).max() > GAP_SHOWN * moved:
            return False
    return True


def magnification(result: RunResult) -> float:
    """Factor by which displacements are shown: round, and 1 where a gap would be falsified.

    Args:
        result: the run.

    Returns:
        The factor [-].
    """
    points = np.concatenate([body.points for body in result.bodies])
    size = float(np.ptp(points, axis=0).max())
    moved = max(float(np.abs(body.displacement).max()) for body in result.bodies)
    if moved == 0.0 or moved > 0.5 * SHOWN_STRAIN * size or not _closed_at_start(result, moved):
        return 1.0
    factor = SHOWN_STRAIN * size / moved
    power = 10.0 ** math.floor(math.log10(factor))
    return max(step * power for step in (1, 2, 5) if step * power <= factor)
