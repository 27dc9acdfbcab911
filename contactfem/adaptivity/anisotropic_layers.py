"""Sizes of new cells at the surfaces of interfaces."""

from dataclasses import replace

import numpy as np

from contactfem.adaptivity.body_recovery import BodyErrors
from contactfem.adaptivity.mesh_decision import BodyCells
from contactfem.case.schema import Case
from contactfem.common.typing import Ints
from contactfem.geometry.cells import thicknesses
from contactfem.meshes.layers import Layers

ROWS = 3  # of regular cells, behind which those that are not disturb pressures little
THICK = 5.0  # of a layer of flat cells over their length, about


def surfaces(case: Case, body: str) -> frozenset[str]:
    """Surfaces of a body that may touch others."""
    sides = (side for i in case.interfaces.values() for side in (i.nonmortar, i.mortar))
    parts = (side.partition(".") for side in sides)
    return frozenset(surface for owner, _, surface in parts if owner == body)


def regular_rows(case: Case, body: str) -> Layers | None:
    """Where mechanical cells are regular: pressures scatter with the cells behind them."""
    asked = case.adaptivity
    if asked is None or asked.contact_size is None:
        return None
    return Layers(surfaces(case, body), aspect=1.0, longest=asked.contact_size, rows=ROWS)


def flat_cells(case: Case, body: str) -> Layers | None:
    """Where thermal cells may be longer than thick; None for nowhere."""
    asked = case.adaptivity
    if asked is None or asked.aspect == 1.0:
        return None
    return Layers(surfaces(case, body), asked.aspect, asked.contact_size or np.inf)


def mechanical_cells(case: Case, body: BodyErrors) -> BodyCells:
    """A mesh with its errors; its new cells have at most `contact_size` on such surfaces."""
    data, largest = body.view.data, np.full(len(body.errors), np.inf)
    if case.adaptivity is not None and case.adaptivity.contact_size is not None:
        touching = np.isin(data.cells, _vertices(case, body)).any(axis=1)
        largest[touching] = case.adaptivity.contact_size
    return BodyCells(body.name, data.points, data.cells, body.view.sizes, body.errors, largest)


def thermal_cells(case: Case, body: BodyErrors) -> BodyCells:
    """A mesh with its errors; its new cells may be flat near such surfaces."""
    from scipy.spatial import cKDTree

    data, free = body.view.data, np.full(len(body.errors), np.inf)
    cells = BodyCells(body.name, data.points, data.cells, body.view.sizes, body.errors, free)
    aspect = 1.0 if case.adaptivity is None else case.adaptivity.aspect
    vertices = _vertices(case, body)
    if aspect == 1.0 or not len(vertices):
        return cells
    sizes, lengths = thicknesses(data.points, data.cells), np.zeros(len(data.points))
    np.maximum.at(lengths, data.cells, (body.view.sizes**2 / sizes)[:, None])
    distance = cKDTree(data.points[vertices]).query(data.points)[0]
    return replace(cells, sizes=sizes, aspect=np.where(distance <= THICK * lengths, aspect, 1.0))


def _vertices(case: Case, body: BodyErrors) -> Ints:
    """Vertices of the surfaces."""
    groups = [body.view.data.groups[name] for name in sorted(surfaces(case, body.name))]
    return np.unique(np.concatenate(groups)) if groups else np.empty(0, dtype=np.int64)
