"""Fields of every body for ParaView, written by all ranks together."""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import dolfinx
from dolfinx import fem

from mpi4py import MPI

from contactfem.common.typing import Floats
from contactfem.errors import CaseError, WriteError
from contactfem.fem.nodal_average import nodal_average

if TYPE_CHECKING:
    from dolfinx.io import VTXWriter

    from contactfem.heat.body import HeatBody

SPARE = 1 << 20  # bytes that have to stay free for what ADIOS2 writes at the end
STRESSES = 6  # xx, yy, zz, xy, yz, xz, which ParaView knows as a symmetric tensor


def remove_later(directory: Path, names: Iterable[str], segment: int) -> None:
    """Remove files of later parts of a run, which are written again or do not count.

    Args:
        directory: where they are.
        names: file names without suffix and number.
        segment: number of the first one to remove, at least 2.
    """
    stems = set(names)
    for name in stems:
        for path in directory.glob(f"{name}_*.bp"):
            number = path.stem.removeprefix(f"{name}_")
            if number.isdecimal() and int(number) >= segment and path.stem not in stems:
                shutil.rmtree(path)


def check_room(comm: MPI.Comm, directory: Path, size: int) -> None:
    """Refuse to write where there is no room: ADIOS2 would end the process; collective.

    Args:
        comm: all ranks; the first one looks.
        directory: where it will be written.
        size: bytes that each rank is about to write.

    Raises:
        WriteError: there is not enough room, on all ranks alike.
    """
    total = comm.allreduce(size)
    fits = comm.rank > 0 or _fits(directory, 2 * total + SPARE)  # the mesh comes the first time
    if not comm.bcast(fits):
        raise WriteError(f"{directory}: cannot be written: no space left for fields")


def _fits(directory: Path, size: int) -> bool:
    """Whether so many bytes can be had, by asking for them: disks and quotas may be full."""
    if shutil.disk_usage(directory).free < size:
        return False
    try:
        with tempfile.TemporaryFile(dir=directory) as file:
            os.posix_fallocate(file.fileno(), 0, size)
    except OSError as error:
        return error.errno in (errno.EINVAL, errno.EOPNOTSUPP)  # cannot be told here
    return True


@dataclass(frozen=True)
class _BodyFile:
    displacement: fem.Function
    stress: fem.Function
    writer: VTXWriter


class FieldWriter:
    """One .bp directory per body with its displacement and Cauchy stress over time."""

    def __init__(
        self, directory: Path, displacements: Mapping[str, fem.Function], suffix: str = ""
    ) -> None:
        """Open the files, on all ranks together.

        Args:
            directory: where they go; it exists.
            displacements: displacement of each body, by its name [m].
            suffix: of the file names, for parts of a run after the first one.

        Raises:
            CaseError: if this dolfinx was built without ADIOS2, which writes them.
        """
        if not dolfinx.has_adios2:
            raise CaseError("output.fields: this dolfinx has no ADIOS2 to write them; give false")
        self._directory, self._sources = directory, dict(displacements)
        self._files = {
            name: self._open(directory / f"{name}{suffix}.bp", u)
            for name, u in self._sources.items()
        }

    def _open(self, path: Path, u: fem.Function) -> _BodyFile:
        from dolfinx.io import VTXWriter  # not there without ADIOS2

        mesh = u.function_space.mesh
        shape = (mesh.geometry.dim,)
        displacement = fem.Function(fem.functionspace(mesh, ("Lagrange", 1, shape)))
        stress = fem.Function(fem.functionspace(mesh, ("Lagrange", 1, (STRESSES,))))
        displacement.name, stress.name = "displacement", "stress"
        writer = VTXWriter(mesh.comm, path, [displacement, stress], engine="BP4")
        return _BodyFile(displacement, stress, writer)

    def write(self, t: float, cell_stresses: Mapping[str, Floats]) -> None:
        """Add a time to every file, on all ranks together.

        Args:
            t: the time [s].
            cell_stresses: Cauchy stress of each body's cells on this rank, owned ones first,
                xx, yy, zz, xy, yz, xz (m, 6) [Pa].

        Raises:
            WriteError: there is no room.
        """
        files = list(self._files.values())
        size = sum(f.displacement.x.array.nbytes + f.stress.x.array.nbytes for f in files)
        for file in files[:1]:
            check_room(file.stress.function_space.mesh.comm, self._directory, size)
        for name, file in self._files.items():
            file.displacement.interpolate(self._sources[name])
            average = nodal_average(file.stress.function_space, cell_stresses[name])
            file.stress.x.array[:] = average.x.array
            file.writer.write(t)

    def close(self) -> None:
        """Close the files, on all ranks together."""
        for file in self._files.values():
            file.writer.close()


@dataclass(frozen=True)
class _HeatFile:
    body: HeatBody
    flux: fem.Function
    writer: VTXWriter


class HeatFieldWriter:
    """One .bp directory per body with temperature, heat flux and displacement over time."""

    def __init__(self, directory: Path, bodies: Sequence[HeatBody], suffix: str = "") -> None:
        """Open the files, on all ranks together.

        Args:
            directory: where they go; it exists.
            bodies: the heat problems.
            suffix: of the file names, for parts of a run after the first one.
        """
        self._directory = directory
        self._files = [
            self._open(directory / f"{body.name}_heat{suffix}.bp", body) for body in bodies
        ]

    def _open(self, path: Path, body: HeatBody) -> _HeatFile:
        from dolfinx.io import VTXWriter  # not there without ADIOS2

        domain = body.mesh.mesh
        flux = fem.Function(fem.functionspace(domain, ("Lagrange", 1, (domain.geometry.dim,))))
        flux.name, body.theta.name, body.u.name = "heat_flux", "temperature", "displacement"
        writer = VTXWriter(domain.comm, path, [body.theta, flux, body.u], engine="BP4")
        return _HeatFile(body, flux, writer)

    def write(self, t: float) -> None:
        """Add a time to every file, on all ranks together.

        Args:
            t: the time [s].

        Raises:
            WriteError: there is no room.
        """
        size = sum(f.body.u.x.array.nbytes + 2 * f.flux.x.array.nbytes for f in self._files)
        for file in self._files[:1]:
            check_room(file.body.mesh.mesh.comm, self._directory, size)
        for file in self._files:
            average = nodal_average(file.flux.function_space, file.body.cell_flux())
            file.flux.x.array[:] = average.x.array
            file.writer.write(t)

    def close(self) -> None:
        """Close the files, on all ranks together."""
        for file in self._files:
            file.writer.close()
