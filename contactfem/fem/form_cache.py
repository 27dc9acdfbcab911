"""The cache of compiled forms, cleared of what killed processes left.

What a run has looked up it remembers: forms of a new mesh are those of the old one, and a look-up
reads the whole folder.

X.c says that X is compiled or being compiled, X.c.cached that it is ready. dolfinx waits for the
second and then gives up.
"""

import fcntl
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

import ufl
from dolfinx import jit
from dolfinx.jit import get_options
from ffcx.naming import compute_signature

from mpi4py import MPI

from contactfem.fem.c_compiler import ensure_compiler

LEASE = "contactfem.lock"  # held by every run that may compile; the system frees it with a process
READY = ".cached"  # after the name of the source
LONG_AGO = 60.0  # seconds after which a compilation is given up although other runs are there


@contextmanager
def compiling(comm: MPI.Comm) -> Iterator[None]:
    """Forms may be compiled inside, without waiting for processes that are no more; collective.

    Each is looked up once.

    Args:
        comm: All ranks; the first one compiles.
    """
    lease: IO[bytes] | None = None
    if comm.rank == 0:
        ensure_compiler()
        options = get_options()
        with suppress(OSError):  # no cache to write to, or no locks there: nothing to clear
            lease = _lease(options["cache_dir"], float(options["timeout"]))
    comm.barrier()
    compiler = jit.ffcx_jit
    jit.ffcx_jit = _remembering(compiler)
    try:
        yield
    finally:
        jit.ffcx_jit = compiler
        if lease is not None:
            lease.close()


def _remembering(compiler: Callable[..., Any]) -> Callable[..., Any]:
    """The same compiler, but equal forms and expressions are the same; the ranks agree on that."""
    known: dict[str, Any] = {}

    def compiled(comm: MPI.Comm, form: Any, *args: Any, **options: Any) -> Any:
        if isinstance(form, ufl.Mesh):
            return compiler(comm, form, *args, **options)
        key = compute_signature([form], repr((comm.size, args, options)))
        if key not in known:
            known[key] = compiler(comm, form, *args, **options)
        return known[key]

    return compiled


def _lease(folder: Path, patience: float) -> IO[bytes]:
    """Clear the cache, with more care where other runs hold a lease, and take one."""
    folder.mkdir(parents=True, exist_ok=True)
    lease = (folder / LEASE).open("ab")
    try:
        fcntl.flock(lease, fcntl.LOCK_EX | fcntl.LOCK_NB)
        while clear(folder, patience):  # somebody else's, perhaps
            time.sleep(0.2)
    except BlockingIOError:
        clear(folder, LONG_AGO)
    fcntl.flock(lease, fcntl.LOCK_SH)
    return lease


def clear(folder: Path, age: float) -> list[Path]:
    """Remove the marks of compilations that do not end.

    If one ends all the same, its mark is put back by the next call: without it dolfinx would
    compile again and then trip over what is there.

    Args:
        folder: The cache.
        age: How long ago they have begun, at least [s].

    Returns:
        Marks of younger ones that have not ended.
    """
    names, now, left = _names(folder), time.time(), []
    for name in names:
        path = folder / name
        if name.endswith(".c") and name + READY not in names:
            with suppress(FileNotFoundError):
                if abs(now - path.stat().st_mtime) < age:
                    left.append(path)
                else:
                    path.unlink()
        elif name.endswith(READY) and name.removesuffix(READY) not in names:
            (folder / name.removesuffix(READY)).touch()
    return left


def _names(folder: Path) -> set[str]:
    """Files of the cache, by name: there may be tens of thousands."""
    try:
        with os.scandir(folder) as entries:
            return {entry.name for entry in entries if entry.name.startswith("libffcx_")}
    except FileNotFoundError:
        return set()
