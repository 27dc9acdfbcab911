"""Displacement and stress of every body for ParaView, written by all ranks together."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import dolfinx
import numpy as np
from dolfinx import fem

from contactfem.errors import CaseError
from contactfem.results import FloatArray

if TYPE_CHECKING:
    from dolfinx.io import VTXWriter

STRESSES = 6  # xx, yy, zz, xy, yz, xz, which ParaView knows as a symmetric tensor


def nodal_average(V: fem.FunctionSpace, cell_values: FloatArray) -> fem.Function:
    """Average cell values at the vertices, over the cells around each, on whatever rank they are.

    Args:
        V: space of degree one with as many components as there are values per cell.
        cell_values: values of the cells of this rank, owned ones first (m, k).

    Returns:
        The averages.
    """
    owned = V.mesh.topology.index_map(V.mesh.topology.dim).size_local
    dofs = V.dofmap.list[:owned]
    total, count = fem.Function(V), fem.Function(V)
    block = V.dofmap.index_map_bs
    values = np.repeat(cell_values[:owned, None, :], dofs.shape[1], axis=1)
    np.add.at(total.x.array.reshape(-1, block), dofs, values)
    np.add.at(count.x.array.reshape(-1, block), dofs, 1.0)
    for part in (total, count):
        part.x.scatter_reverse(dolfinx.la.InsertMode.add)
        part.x.scatter_forward()
    total.x.array[:] /= np.maximum(count.x.array, 1.0)
    return total


def _remove_from(directory: Path, name: str, done: int) -> None:
    """Remove what an earlier run has written of a body after the steps that are done."""
    for path in directory.glob(f"{name}_from_step_*.bp"):
        first = path.stem.rpartition("_")[2]
        if first.isdecimal() and int(first) > done:
            shutil.rmtree(path)


@dataclass(frozen=True)
class _BodyFile:
    displacement: fem.Function
    stress: fem.Function
    writer: VTXWriter


class FieldWriter:
    """One .bp directory per body with its displacement and Cauchy stress over time.

    Such a directory cannot be opened again to go on in it: a resumed run writes another one, BODY
    and the number of its first step, "block_from_step_13.bp".
    """

    def __init__(
        self, directory: Path, displacements: Mapping[str, fem.Function], done: int = 0
    ) -> None:
        """Open the files, on all ranks together.

        Args:
            directory: where they go; it exists.
            displacements: displacement of each body, by its name [m].
            done: steps that a resumed run has behind it.

        Raises:
            CaseError: if this dolfinx was built without ADIOS2, which writes them.
        """
        if not dolfinx.has_adios2:
            raise CaseError("output.fields: this dolfinx has no ADIOS2 to write them; give false")
        self._sources = dict(displacements)
        self._files = {}
        for name, u in self._sources.items():
            comm = u.function_space.mesh.comm
            if comm.rank == 0:
                _remove_from(directory, name, done)
            comm.barrier()
            path = directory / (f"{name}_from_step_{done + 1}.bp" if done else f"{name}.bp")
            self._files[name] = self._open(path, u)

    def _open(self, path: Path, u: fem.Function) -> _BodyFile:
        from dolfinx.io import VTXWriter  # not there without ADIOS2

        mesh = u.function_space.mesh
        shape = (mesh.geometry.dim,)
        displacement = fem.Function(fem.functionspace(mesh, ("Lagrange", 1, shape)))
        stress = fem.Function(fem.functionspace(mesh, ("Lagrange", 1, (STRESSES,))))
        displacement.name, stress.name = "displacement", "stress"
        writer = VTXWriter(mesh.comm, path, [displacement, stress], engine="BP4")
        return _BodyFile(displacement, stress, writer)

    def write(self, t: float, cell_stresses: Mapping[str, FloatArray]) -> None:
        """Add a time to every file, on all ranks together.

        Args:
            t: the time [s].
            cell_stresses: Cauchy stress of each body's cells on this rank, owned ones first,
                xx, yy, zz, xy, yz, xz (m, 6) [Pa].
        """
        for name, file in self._files.items():
            file.displacement.interpolate(self._sources[name])
            average = nodal_average(file.stress.function_space, cell_stresses[name])
            file.stress.x.array[:] = average.x.array
            file.writer.write(t)

    def close(self) -> None:
        """Close the files, on all ranks together."""
        for file in self._files.values():
            file.writer.close()
