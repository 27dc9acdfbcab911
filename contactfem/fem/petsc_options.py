"""PETSc options: of the program, a case file, and the user."""

from collections.abc import Mapping
from functools import cache

from petsc4py import PETSc

from contactfem.errors import CaseError
from contactfem.fem.compat import has_package

MECHANICS, HEAT = "mech_", "heat_"  # prefixes


def configure(
    solver: PETSc.SNES | PETSc.KSP, prefix: str, options: Mapping[str, str], key: str
) -> None:
    """Set a solver up; what an earlier one of this prefix was told is forgotten.

    What the user gave PETSc before the first one, in PETSC_OPTIONS, stays and counts most.

    Args:
        solver: the solver, its types as they should be if no option says otherwise.
        prefix: of its options, such as "mech_".
        options: value by name without the prefix.
        key: where a case file gives options, for errors.

    Raises:
        CaseError: PETSc does not know a value of an option.
    """
    database, users = PETSc.Options(), _users(prefix)
    forget(prefix)
    for name, value in options.items():
        if prefix + name not in users:
            database.setValue(prefix + name, value)
    solver.setOptionsPrefix(prefix)
    try:
        solver.setFromOptions()
    except PETSc.Error as error:
        why = str(error).strip().rpartition("] ")[2]
        raise CaseError(f"{key}: PETSc refuses these options: {why}") from None


def available(options: Mapping[str, str], key: str) -> tuple[dict[str, str], str]:
    """Options that this PETSc has the means for: GAMG stands in for hypre where that is missing.

    Args:
        options: value by name without the prefix.
        key: where a case file gives them.

    Returns:
        The options, and what to tell the user; empty if nothing changed.
    """
    if options.get("pc_type") != "hypre" or has_package("hypre"):
        return dict(options), ""
    kept = {name: value for name, value in options.items() if "hypre" not in name}
    note = f"{key}: this PETSc has no hypre; its own multigrid, GAMG, is taken instead"
    return kept | {"pc_type": "gamg"}, note


def forget(*prefixes: str) -> None:
    """Take back what solvers were told: PETSc warns at its end of what none of them came to use.

    Args:
        prefixes: of their options.
    """
    database = PETSc.Options()
    for name in database.getAll():
        if any(name.startswith(p) and name not in _users(p) for p in prefixes):
            database.delValue(name)


@cache
def _users(prefix: str) -> frozenset[str]:
    """Names of the options of a prefix that were there when it was first asked for."""
    return frozenset(name for name in PETSc.Options().getAll() if name.startswith(prefix))
