"""Options of PETSc's solvers: those of the program, and over them those of a case file."""

from collections.abc import Mapping

from petsc4py import PETSc

from contactfem.errors import CaseError


def configure(
    solver: PETSc.SNES | PETSc.KSP, prefix: str, options: Mapping[str, str], key: str
) -> None:
    """Set a solver up; what an earlier one of this prefix was told is forgotten.

    Args:
        solver: the solver, its types as they should be if no option says otherwise.
        prefix: of its options, such as "mech_".
        options: value by name without the prefix.
        key: where a case file gives options, for errors.

    Raises:
        CaseError: PETSc does not know a value of an option.
    """
    database = PETSc.Options()
    for name in database.getAll():
        if name.startswith(prefix):
            database.delValue(name)
    for name, value in options.items():
        database.setValue(prefix + name, value)
    solver.setOptionsPrefix(prefix)
    try:
        solver.setFromOptions()
    except PETSc.Error as error:
        why = str(error).strip().rpartition("] ")[2]
        raise CaseError(f"{key}: PETSc refuses these options: {why}") from None
