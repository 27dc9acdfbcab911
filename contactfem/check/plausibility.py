"""Doubtful input: loads far above the stiffness, meshes in pieces."""

from collections.abc import Iterator

import numpy as np

from contactfem.case.scene import Condition
from contactfem.case.schema import Case
from contactfem.common.unit_display import engineering
from contactfem.common.units import Given
from contactfem.meshes.data import MeshData


def large_loads(case: Case) -> Iterator[str]:
    """Tractions and pressures above Young's modulus, which strain a body by more than one.

    Args:
        case: the case.

    Yields:
        A sentence about each.
    """
    for number, condition in enumerate(case.conditions if case.mechanics else ()):
        load = max((abs(v) for table in _loads(condition) for v in table.values), default=0.0)
        material = case.bodies[condition.body].material
        times = load / case.materials[material].E
        if times > 1.0:
            yield (
                f"conditions.{number}.{condition.kind}: {engineering(load, 'Pa')} is {times:.3g} "
                f"times Young's modulus of '{material}'; is the unit right?"
            )


def _loads(condition: Condition) -> list[Given]:
    """Loads per area [Pa]."""
    tables = list((condition.traction or {}).values())
    return tables + ([condition.pressure] if condition.pressure is not None else [])


def pieces(mesh: MeshData) -> int:
    """Number of pieces of a mesh that share no node.

    Args:
        mesh: the mesh.

    Returns:
        1 for a body in one piece; nodes without cells do not count.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    first, others = mesh.cells[:, :1], mesh.cells[:, 1:]
    ends = np.broadcast_to(first, others.shape).ravel(), others.ravel()
    count = len(mesh.points)
    edges = coo_array((np.ones(len(ends[0]), np.int8), ends), (count, count))
    labels = connected_components(edges, directed=False)[1]
    return len(np.unique(labels[mesh.cells]))
