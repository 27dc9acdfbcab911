"""Options of PETSc: those of one case do not reach the next, and the user's count most."""

import pytest

from petsc4py import PETSc

from contactfem.errors import CaseError
from contactfem.fem.petsc_options import configure, forget


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
