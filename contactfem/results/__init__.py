"""Results of a run, and numbers measured on them."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from contactfem.results.data import InterfaceTable, RunResult, StepReport
    from contactfem.results.measures import measure

__all__ = ["InterfaceTable", "RunResult", "StepReport", "measure"]


def __getattr__(name: str) -> Any:
    """Load a record of `results.data`, or `measure`, when it is first asked for (PEP 562)."""
    if not name.startswith("_"):
        for part in ("data", "measures"):
            module = import_module(f"contactfem.results.{part}")
            if name in vars(module):
                return vars(module)[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
