"""Mortar contact with friction on FEniCSx, run from case files with units."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from contactfem.common import mpi_first

if TYPE_CHECKING:
    from contactfem.case.read import read_case
    from contactfem.case.schema import Case
    from contactfem.errors import CaseError
    from contactfem.run.api import Run, solve

__version__ = "0.1.0"
__all__ = ["Case", "CaseError", "Run", "read_case", "solve"]

HOMES = {  # of what is loaded when it is first asked for
    "Case": "case.schema",
    "CaseError": "errors",
    "Run": "run.api",
    "read_case": "case.read",
    "solve": "run.api",
}

mpi_first.install()


def __getattr__(name: str) -> Any:
    """Load a name of this package when it is first asked for (PEP 562)."""
    if name not in HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{HOMES[name]}"), name)


def __dir__() -> list[str]:
    """Names for those who look with the Tab key."""
    return [*__all__, "__version__"]
