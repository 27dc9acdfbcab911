"""Loads MPI before dolfinx where both come from PyPI."""

import sys
from importlib import import_module
from importlib.machinery import ModuleSpec, PathFinder

STACK = "dolfinx_solver"
USERS_OF_MPI = ("dolfinx", "petsc4py")


class MpiFirst:
    """Finds nothing itself, but imports `dolfinx_solver`, where it is installed, before its parts.

    That loads the MPI library out of the environment, which nothing else would find, and refuses a
    second PETSc. Without that package this does nothing.
    """

    def find_spec(self, name: str, path: object = None, target: object = None) -> ModuleSpec | None:
        """Look at what is about to be imported, once.

        Args:
            name: of the module.
            path: of its package.
            target: module that is loaded anew.

        Returns:
            None: other finders say where it is.

        Raises:
            ImportError: that package found a PETSc or MPI that it cannot work with.
        """
        if name in USERS_OF_MPI:
            sys.meta_path.remove(self)
            if PathFinder.find_spec(STACK) is not None:
                import_module(STACK)
        return None


def install() -> None:
    """Have MPI loaded first, whoever imports dolfinx."""
    if not any(name in sys.modules for name in USERS_OF_MPI):
        sys.meta_path.insert(0, MpiFirst())
