"""The time loop, from the first step to the last."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from contactfem.run.driver import run_case

__all__ = ["run_case"]


def __getattr__(name: str) -> Any:
    """Load `run_case`, and dolfinx with it, when it is first asked for (PEP 562)."""
    if name != "run_case":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from contactfem.run.driver import run_case

    return run_case
