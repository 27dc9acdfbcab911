"""Meshes of a case as files and pictures."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from contactfem.case.schema import Case
from contactfem.common.typing import Ints
from contactfem.errors import CaseError, MeshError
from contactfem.meshes import MeshData
from contactfem.meshes.file import CELLS

FACETS = {
    "triangle": "line",
    "quadrilateral": "line",
    "tetrahedron": "triangle",
    "hexahedron": "quad",
}


def write_meshes(case: Case, folder: Path) -> Iterator[str]:
    """Write BODY.msh (gmsh 2.2, lengths in metres) for every body, and BODY.png in 2D.

    Args:
        case: the case.
        folder: where to; made if it is missing.

    Yields:
        One line about each body, once it is written.

    Raises:
        CaseError: a body's mesh cannot be made, or the folder cannot be written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CaseError(f"{folder}: cannot be written to: {error.strerror}") from None
    for name, body in case.bodies.items():
        try:
            data = body.mesh.build()
        except MeshError as error:
            raise CaseError(f"{case.path}: bodies.{name}.mesh: {error}") from None
        write_msh(data, folder / f"{name}.msh")
        if data.points.shape[1] == 2:
            draw_mesh(data, folder / f"{name}.png")
        groups = ", ".join(f"{group} {len(facets)}" for group, facets in data.groups.items())
        yield (
            f"{folder / name}.msh: {len(data.points)} points, {len(data.cells)} "
            f"{data.cell_type}s, facets: {groups}"
        )


def write_msh(data: MeshData, path: Path) -> None:
    """Write a mesh with its groups as named physical groups; a facet is in its first group only.

    Args:
        data: the mesh.
        path: file to write.
    """
    import meshio

    kind, order = next(
        (k, order) for k, (_, name, order) in CELLS.items() if name == data.cell_type
    )
    dim = data.points.shape[1]
    blocks = [(kind, data.cells[:, order])]
    tags = [np.full(len(data.cells), 1)]
    names = {"body": np.array([1, dim])}
    seen: Ints = np.empty((0, dim if kind != "hexahedron" else 4), dtype=np.int64)
    for tag, (group, facets) in enumerate(data.groups.items(), start=2):
        keys = np.sort(facets, axis=1)
        new = ~(keys[:, None] == seen[None]).all(axis=2).any(axis=1)
        seen = np.concatenate([seen, keys])
        turn = [0, 1, 3, 2] if facets.shape[1] == 4 else list(range(facets.shape[1]))
        blocks.append((FACETS[data.cell_type], facets[new][:, turn]))
        tags.append(np.full(int(new.sum()), tag))
        names[group] = np.array([tag, dim - 1])
    points = np.zeros((len(data.points), 3))
    points[:, :dim] = data.points
    mesh = meshio.Mesh(
        points,
        blocks,
        cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
        field_data=names,
    )
    meshio.write(path, mesh, file_format="gmsh22", binary=False)


def draw_mesh(data: MeshData, path: Path) -> None:
    """Draw a 2D mesh with its groups in colour.

    Args:
        data: the mesh.
        path: PNG file to write.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.figure import Figure

    around = [0, 1, 3, 2] if data.cell_type == "quadrilateral" else [0, 1, 2]
    low, high = data.points.min(axis=0), data.points.max(axis=0)
    shape = np.clip((high - low) / np.max(high - low), 0.2, 1.0) * 7.0
    figure = Figure(figsize=(shape[0] + 2.5, shape[1] + 1.0), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    cells = list(data.points[data.cells[:, around]])
    axes.add_collection(PolyCollection(cells, facecolor="#f2f2f2", edgecolor="#7f7f7f", lw=0.3))
    for number, (group, facets) in enumerate(data.groups.items()):
        lines = LineCollection(
            list(data.points[facets]), color=f"C{number % 10}", lw=2, label=group
        )
        axes.add_collection(lines)
    axes.autoscale()
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    figure.savefig(path)
