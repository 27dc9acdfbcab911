"""Compilations that a killed process has left are done again, those of others are waited for."""

import fcntl
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import ufl
from dolfinx import fem, jit, mesh

from mpi4py import MPI

from contactfem.fem.compat import CellExpression
from contactfem.fem.form_cache import LEASE, clear, compiling

COMPILE = """
import sys
from mpi4py import MPI
from dolfinx import fem, mesh
import ufl
from contactfem.fem.form_cache import compiling
with compiling(MPI.COMM_WORLD):
    print("begin", flush=True)
    domain = mesh.create_unit_interval(MPI.COMM_WORLD, 3)
    fem.form(fem.Constant(domain, 1.0) * ufl.dx)
    print("end", flush=True)
"""


def left(folder: Path, name: str, age: float) -> Path:
    source = folder / f"libffcx_forms_{name}.c"
    source.touch()
    os.utime(source, (time.time() - age, time.time() - age))
    return source


def test_old_marks_go_and_young_ones_stay(tmp_path):
    old, young = left(tmp_path, "old", 100.0), left(tmp_path, "young", 5.0)
    ready = left(tmp_path, "ready", 1000.0)
    Path(f"{ready}.cached").touch()
    assert set(clear(tmp_path, math.inf)) == {old, young}
    assert clear(tmp_path, 60.0) == [young]
    assert not old.exists() and young.exists() and ready.exists()


def test_a_compilation_that_ended_after_all_is_marked_again(tmp_path):
    source = tmp_path / "libffcx_forms_slow.c"
    Path(f"{source}.cached").touch()
    clear(tmp_path, 60.0)
    assert source.exists()


@pytest.fixture
def cache(tmp_path, monkeypatch) -> Path:
    options = {"cache_dir": tmp_path, "timeout": 1}
    monkeypatch.setattr("contactfem.fem.form_cache.get_options", lambda: options)
    return tmp_path


def test_alone_it_waits_as_dolfinx_would_and_then_clears(cache):
    source = left(cache, "killed", 0.0)
    start = time.monotonic()
    with compiling(MPI.COMM_SELF):
        assert not source.exists()
    assert 0.5 < time.monotonic() - start < 60.0


def test_beside_another_run_what_it_may_be_compiling_stays(cache):
    source, old = left(cache, "others", 5.0), left(cache, "old", 100.0)
    with (cache / LEASE).open("ab") as lease:
        fcntl.flock(lease, fcntl.LOCK_SH)
        with compiling(MPI.COMM_SELF), compiling(MPI.COMM_SELF):
            assert source.exists() and not old.exists()


def test_without_a_cache_nothing_happens(monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    options = {"cache_dir": tmp_path / "file", "timeout": 1}
    monkeypatch.setattr("contactfem.fem.form_cache.get_options", lambda: options)
    with compiling(MPI.COMM_SELF):
        pass


def test_a_process_killed_while_it_compiles(tmp_path):
    """What dolfinx leaves is what is cleared: the next process compiles instead of giving up."""
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path)}
    options = {"stdout": subprocess.PIPE, "text": True, "env": environment}
    process = subprocess.Popen([sys.executable, "-c", COMPILE], **options)
    folder = tmp_path / "fenics"
    deadline = time.monotonic() + 60
    while not clear(folder, math.inf):
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.001)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    (source,) = clear(folder, math.inf)
    os.utime(source, (time.time() - 20, time.time() - 20))
    again = subprocess.run(
        [sys.executable, "-c", COMPILE], capture_output=True, text=True, env=environment, timeout=60
    )
    assert again.returncode == 0, again.stderr
    assert again.stdout == "begin\nend\n"
    assert clear(folder, math.inf) == []


def test_a_form_of_another_mesh_is_not_looked_up_again(monkeypatch):
    looked_up = []

    def compiler(comm, form, *args, **options):
        looked_up.append(form)
        return original(comm, form, *args, **options)

    original = jit.ffcx_jit
    monkeypatch.setattr(jit, "ffcx_jit", compiler)
    with compiling(MPI.COMM_SELF):
        found = [integral(n, power) for n, power in ((3, 1), (5, 1), (5, 2))]
        assert len(looked_up) == 2
    assert found == pytest.approx([0.5, 0.5, 1.0 / 3.0])
    assert jit.ffcx_jit is compiler
    assert integral(4, 1) == pytest.approx(0.5)
    assert len(looked_up) == 3


def integral(n: int, power: int) -> float:
    """∫ c x^p over the unit interval with n cells and c = 1."""
    domain = mesh.create_unit_interval(MPI.COMM_SELF, n)
    x = ufl.SpatialCoordinate(domain)[0]
    return fem.assemble_scalar(fem.form(fem.Constant(domain, 1.0) * x**power * ufl.dx))


def test_equal_expressions_of_two_meshes_have_one_name(monkeypatch):
    """ffcx numbers variables through the process: stresses were compiled anew for every mesh."""
    names = []

    def compiler(comm, form, *args, **options):
        found = original(comm, form, *args, **options)
        if isinstance(form, tuple):
            names.append(found[1].__name__)
        return found

    original = jit.ffcx_jit
    monkeypatch.setattr(jit, "ffcx_jit", compiler)
    for n in (3, 4):
        domain = mesh.create_unit_square(MPI.COMM_SELF, n, n)
        x = ufl.variable(ufl.SpatialCoordinate(domain)[0])
        value = CellExpression(domain, ufl.diff(x**2, x)).values()
        assert np.allclose(value.mean(), 1.0)
    assert len(names) == 2 and names[0] == names[1]
