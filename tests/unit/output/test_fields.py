"""Fields for ParaView, on any number of ranks."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from dolfinx import fem, mesh

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.errors import CaseError, WriteError
from contactfem.fem.nodal_average import nodal_average
from contactfem.output.fields import FieldWriter, remove_later
from contactfem.run.driver import run_case

CASES = Path(__file__).parents[3] / "cases"


def unit_square(n: int) -> mesh.Mesh:
    return mesh.create_unit_square(MPI.COMM_WORLD, n, n, ghost_mode=mesh.GhostMode.shared_facet)


def cell_count(domain: mesh.Mesh) -> int:
    cells = domain.topology.index_map(domain.topology.dim)
    return cells.size_local + cells.num_ghosts


@pytest.mark.mpi
@pytest.mark.quick
@pytest.mark.parametrize("n", [1, 7])
def test_constants_are_averaged_to_themselves(n):
    domain = unit_square(n)
    V = fem.functionspace(domain, ("Lagrange", 1, (6,)))
    values = np.tile(np.arange(1.0, 7.0), (cell_count(domain), 1))
    found = nodal_average(V, values).x.array.reshape(-1, 6)
    assert np.allclose(found, np.arange(1.0, 7.0), rtol=1e-15)


@pytest.mark.mpi
@pytest.mark.quick
def test_averages_do_not_depend_on_the_ranks():
    """The sum over vertices of the mean of the cells around, weighted to tell cells apart."""
    domain = unit_square(8)
    V = fem.functionspace(domain, ("Lagrange", 1, (1,)))
    middles = mesh.compute_midpoints(domain, 2, np.arange(cell_count(domain), dtype=np.int32))
    average = nodal_average(V, middles[:, :1] ** 2)
    x = V.tabulate_dof_coordinates()
    owned = V.dofmap.index_map.size_local
    local = float(np.sum(average.x.array[:owned] * (1.0 + x[:owned, 1])))
    total = domain.comm.allreduce(local)
    serial = mesh.create_unit_square(MPI.COMM_SELF, 8, 8)
    W = fem.functionspace(serial, ("Lagrange", 1, (1,)))
    cells = serial.topology.index_map(2).size_local
    middles = mesh.compute_midpoints(serial, 2, np.arange(cells, dtype=np.int32))
    alone = nodal_average(W, middles[:, :1] ** 2).x.array
    expected = float(np.sum(alone * (1.0 + W.tabulate_dof_coordinates()[:, 1])))
    assert total == pytest.approx(expected, rel=1e-12)


def test_without_adios2_it_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr("dolfinx.has_adios2", False)
    with pytest.raises(CaseError, match=r"output\.fields: .* no ADIOS2"):
        FieldWriter(tmp_path, {})


@pytest.mark.mpi
@pytest.mark.quick
def test_a_full_disk_is_noticed_before_anything_is_written(tmp_path, monkeypatch):
    """ADIOS2 ends the process where it cannot write, even after its error was caught."""
    folder = Path(MPI.COMM_WORLD.bcast(str(tmp_path)))
    domain = unit_square(4)
    u = fem.Function(fem.functionspace(domain, ("Lagrange", 1, (2,))))
    writer = FieldWriter(folder, {"one": u})
    monkeypatch.setattr("shutil.disk_usage", lambda path: SimpleNamespace(free=1 << 20))
    with pytest.raises(WriteError, match=f"{folder}: cannot be written: no space left for fields"):
        writer.write(0.0, {"one": np.ones((cell_count(domain), 6))})
    writer.close()


def test_only_field_files_of_later_parts_are_removed(tmp_path):
    for name in ("a", "a_2", "a_2_2", "a_3", "a_heat_3", "a_x", "ab_3", "b_2"):
        (tmp_path / f"{name}.bp").mkdir()
    remove_later(tmp_path, ["a", "a_2", "a_heat", "b"], 3)
    left = {path.stem for path in tmp_path.iterdir()}
    assert left == {"a", "a_2", "a_2_2", "a_x", "ab_3", "b_2"}


@pytest.mark.mpi
@pytest.mark.quick
@pytest.mark.parametrize("n", [1, 5])
def test_one_file_per_body(n, tmp_path):
    folder = Path(MPI.COMM_WORLD.bcast(str(tmp_path)))
    domain = unit_square(n)
    u = fem.Function(fem.functionspace(domain, ("Lagrange", 1, (2,))))
    writer = FieldWriter(folder, {"one": u, "two": u})
    stresses = {name: np.ones((cell_count(domain), 6)) for name in ("one", "two")}
    for t in (0.0, 1.0):
        u.x.array[:] = t
        writer.write(t, stresses)
    writer.close()
    MPI.COMM_WORLD.barrier()
    for name in ("one", "two"):
        assert (folder / f"{name}.bp").is_dir()
        assert any(file.stat().st_size > 0 for file in (folder / f"{name}.bp").iterdir())


def test_no_stresses_without_mechanics(tmp_path):
    """Heat alone writes temperatures, and not a file of displacements that are zero."""
    case = read_case(CASES / "heated_rod.toml", ["output.figures=false", "output.fields=vtx"])
    run_case(case, MPI.COMM_SELF, tmp_path)
    written = {folder.name for folder in tmp_path.glob("*.bp")}
    assert written == {f"{name}_heat.bp" for name in case.bodies}
