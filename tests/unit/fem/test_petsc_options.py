"""Options of PETSc: those of one case do not reach the next, and the user's count most."""

import pytest

from petsc4py import PETSc

from contactfem.errors import CaseError
from contactfem.fem.petsc_options import available, configure, forget


@pytest.fixture
def prefix(request):
    """A prefix of each test's own, cleared in the end."""
    name = f"{request.node.name.replace('test_', '')}_"
    yield name
    database = PETSc.Options()
    for key in database.getAll():
        if key.startswith(name):
            database.delValue(key)


def given(prefix):
    return {k: v for k, v in PETSc.Options().getAll().items() if k.startswith(prefix)}


def solver():
    return PETSc.KSP().create(PETSc.COMM_SELF)


def test_the_users_options_stay_and_count_most(prefix):
    database = PETSc.Options()
    database.setValue(f"{prefix}ksp_type", "cg")
    database.setValue(f"{prefix}ksp_max_it", "7")
    for _ in range(2):
        ksp = solver()
        configure(ksp, prefix, {"ksp_type": "gmres", "ksp_rtol": "1e-3"}, "solver.petsc")
        assert ksp.getType() == "cg"
        assert ksp.getTolerances()[3] == 7
        assert ksp.getTolerances()[0] == 1e-3


def test_options_of_one_case_do_not_reach_the_next(prefix):
    configure(solver(), prefix, {"ksp_type": "cg", "ksp_rtol": "1e-3"}, "solver.petsc")
    ksp = solver()
    configure(ksp, prefix, {"ksp_type": "gmres"}, "solver.petsc")
    assert ksp.getType() == "gmres"
    assert given(prefix) == {f"{prefix}ksp_type": "gmres"}


def test_what_petsc_refuses_is_an_error_of_the_case(prefix):
    with pytest.raises(CaseError, match=r"solver\.petsc: PETSc refuses these options"):
        configure(solver(), prefix, {"ksp_type": "nonsense"}, "solver.petsc")


def test_what_solvers_were_told_is_taken_back(prefix):
    configure(solver(), prefix, {"ksp_type": "cg"}, "solver.petsc")
    assert f"{prefix}ksp_type" in PETSc.Options().getAll()
    forget(prefix)
    assert not [name for name in PETSc.Options().getAll() if name.startswith(prefix)]


def test_gamg_stands_in_for_hypre_where_that_is_missing(monkeypatch):
    given = {"ksp_type": "cg", "pc_type": "hypre", "pc_hypre_type": "boomeramg"}
    monkeypatch.setattr("contactfem.fem.petsc_options.has_package", lambda name: name == "hypre")
    assert available(given, "solver.petsc") == (given, "")
    monkeypatch.setattr("contactfem.fem.petsc_options.has_package", lambda name: False)
    found, note = available(given, "solver.petsc")
    assert found == {"ksp_type": "cg", "pc_type": "gamg"}
    assert note.startswith("solver.petsc: this PETSc has no hypre; its own multigrid, GAMG")
    assert available({"pc_type": "lu"}, "heat.petsc") == ({"pc_type": "lu"}, "")
