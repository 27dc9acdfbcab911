"""Odd cases that pass the checks are solved or given up, with a reason that names the file."""

import contextlib
import io
import warnings
from pathlib import Path

import pytest
from fuzz.broken_meshes import mesh_files
from fuzz.examining import check, within
from fuzz.mutations import mutated
from fuzz.test_mesh_files import case_of
from fuzz.toml_text import dumps
from hypothesis import event, given
from hypothesis import strategies as st

from mpi4py import MPI

from contactfem.case.read import read_case
from contactfem.case.schema import Case
from contactfem.errors import ContactfemError
from contactfem.run.driver import run_case

DATA = Path(__file__).resolve().parents[1] / "data"
SMALL = tuple(DATA / f"{name}.toml" for name in ("two_blocks", "warm_blocks", "pressed_ball"))
MOST_CELLS = 1500
PATIENCE = 120.0  # seconds, most of which forms that are new to the cache take


def short(case: Case) -> Case:
    """The case with one step of a few iterations."""
    step = case.time.step
    end = case.time.model_copy(update={"end": step, "step_min": step, "step_max": step})
    few = {"max_cutbacks": 0, "max_iterations": min(6, case.solver.max_iterations)}
    solver = case.solver.model_copy(update=few)
    return case.model_copy(update={"time": end, "solver": solver})


def small(case: Case) -> bool:
    """Whether all meshes can be made and are small."""
    meshes = [mesh for body in case.bodies.values() for mesh in (body.mesh, body.thermal_mesh)]
    return all(len(mesh.build().cells) <= MOST_CELLS for mesh in meshes if mesh is not None)


def attempt(case: Case, out: Path) -> str:
    """Run a case for a step: why it was given up, or nothing."""
    try:
        with within(PATIENCE), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # numbers may overflow in a solve that comes to nothing
            if not small(case):
                return ""
            with contextlib.redirect_stdout(io.StringIO()):
                result = run_case(short(case), MPI.COMM_SELF, out)
    except ContactfemError as error:
        return str(error)
    assert result.converged == (not result.message)
    return result.message


@pytest.mark.parametrize("name", ["warm_blocks", "pressed_ball"])
@pytest.mark.parametrize("varied", [False, True])
def test_small_cases_run_as_they_are(name: str, varied: bool, tmp_path: Path) -> None:
    path = DATA / f"{name}.toml"
    variant = next(iter(read_case(path).variants)) if varied else None
    assert attempt(read_case(path, variant=variant), tmp_path) == ""


@pytest.mark.parametrize(
    ("change", "line"),
    [
        (
            "bodies.upper.mesh.corner = ['0 mm', '5 mm']",
            "'upper.bottom' differs between its meshes: ",
        ),
        (
            "conditions.6 = {on='upper', at=['7 mm', '6 mm'], displacement={x='0 m'}}",
            "condition on upper: no vertex at ",
        ),
        ("solver.petsc.ksp_type = no", "solver.petsc: PETSc refuses these options: "),
        ("heat.petsc.pc_type = no", "heat.petsc: PETSc refuses these options: "),
    ],
)
def test_what_only_a_run_finds_names_the_file_too(change: str, line: str, tmp_path: Path) -> None:
    path = DATA / "warm_blocks.toml"
    why = attempt(read_case(path, [change]), tmp_path)
    assert why.startswith(f"{path}: {line}")
    assert len(why.splitlines()) == 1


@given(raw=mutated(SMALL, most=2), varied=st.booleans())
def test_any_case_that_passes_the_checks_can_be_run(
    raw: dict[str, object], varied: bool, tmp_path: Path
) -> None:
    path = tmp_path / "case.toml"
    path.write_text(dumps(raw))
    if check(path):
        return
    names = list(read_case(path).variants) if varied else []
    case = read_case(path, variant=names[0] if names else None)
    why = attempt(case, tmp_path / "out")
    event("given up" if why else "solved or too large")
    assert all(line.startswith(f"{path}: ") for line in why.splitlines())


@given(data=st.data())
def test_any_mesh_that_passes_the_checks_can_be_used(data: st.DataObject, tmp_path: Path) -> None:
    path = case_of(data.draw(mesh_files(tmp_path)), body=False)
    if not check(path):
        why = attempt(read_case(path), tmp_path / "out")
        event("given up" if why else "solved")
        assert all(line.startswith(f"{path}: ") for line in why.splitlines())
