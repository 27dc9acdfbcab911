"""Mesh files as arrays: cells and named groups."""

import pickle
import subprocess
import sys
from pathlib import Path
from subprocess import DEVNULL
from tempfile import TemporaryDirectory

from contactfem.errors import MeshError
from contactfem.meshes.raw import RawMesh

GMSH = (".msh", ".unv", ".bdf", ".nas")
ABAQUS = ".inp"
PATIENCE = 60.0  # seconds for a file of no size
SLOWEST = 100_000.0  # bytes per second of the rest


def read_mesh(path: Path) -> RawMesh:
    """Mesh in a format of gmsh, Abaqus or CalculiX, or in any other that meshio knows.

    gmsh and meshio read in a process of their own: some broken files make gmsh crash, or meshio
    read on for ever.

    Raises:
        MeshError: the file is not a mesh.
    """
    if path.suffix.lower() == ABAQUS:
        from contactfem.meshes.abaqus import read_abaqus

        return read_abaqus(path)
    child = "import sys; from contactfem.meshes import readers; readers.answer(*sys.argv[1:])"
    reader = "gmsh" if path.suffix.lower() in GMSH else "meshio"
    limit = PATIENCE + path.stat().st_size / SLOWEST
    with TemporaryDirectory() as folder:
        file = Path(folder) / "answer"
        command = [sys.executable, "-P", "-c", child, str(path), str(file)]
        try:
            done = subprocess.run(command, capture_output=True, stdin=DEVNULL, timeout=limit)
        except subprocess.TimeoutExpired:
            why = f"still not done after {limit:.0f} s"
            raise MeshError(f"not a mesh that {reader} reads ({why})") from None
        if done.returncode:
            said = done.stderr.decode(errors="replace").strip().rpartition("\n")[2]
            why = said if done.returncode > 0 else "it crashes"
            raise MeshError(f"not a mesh that {reader} reads ({why})")
        found: RawMesh | MeshError = pickle.loads(file.read_bytes())
    if isinstance(found, MeshError):
        raise found
    return found


def answer(path: str, file: str) -> None:
    """Read a mesh, and write it to a file, or the error that it is none."""
    from contactfem.meshes.gmsh_reader import read_gmsh
    from contactfem.meshes.meshio_reader import read_meshio

    found: RawMesh | MeshError
    try:
        found = (read_gmsh if Path(path).suffix.lower() in GMSH else read_meshio)(Path(path))
    except MeshError as error:
        found = error
    Path(file).write_bytes(pickle.dumps(found))
