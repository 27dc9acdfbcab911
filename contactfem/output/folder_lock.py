"""Lock on the folder of a run."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mpi4py import MPI

from contactfem.errors import CaseError

NAME = ".lock"


@contextmanager
def locked(folder: Path | None, comm: MPI.Comm) -> Iterator[None]:
    """Hold the lock of a folder for the time inside; collective.

    The lock belongs to the process: it is gone with it, however it ends.

    Args:
        folder: The folder, made if it is missing; None for none.
        comm: All ranks; the first one holds the lock.

    Raises:
        CaseError: Another run holds it, or the folder cannot be made; on all ranks alike.
    """
    file, trouble = None, ""
    if folder is not None and comm.rank == 0:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            file = os.open(folder / NAME, os.O_RDWR | os.O_CREAT, 0o666)
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            os.ftruncate(file, 0)
            os.write(file, f"{os.getpid()}\n".encode())
        except BlockingIOError:
            owner = _owner(file)
            trouble = f"{folder}: another run{owner} writes into it; wait for it, or give --out"
        except OSError as error:
            trouble = f"{folder}: cannot be written to: {error.strerror}"
    trouble = comm.bcast(trouble)
    try:
        if trouble:
            raise CaseError(trouble)
        yield
        if file is not None and folder is not None:
            (folder / NAME).unlink(missing_ok=True)
    finally:
        if file is not None:
            os.close(file)


def _owner(file: int | None) -> str:
    """Process that holds a lock, in words."""
    text = b"" if file is None else os.read(file, 32).strip()
    return f" (process {text.decode()})" if text.isdigit() else ""
