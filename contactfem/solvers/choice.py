"""Choice of the solver for Newton's linear systems."""

from collections.abc import Mapping

from mpi4py import MPI

from contactfem.common.timers import Timers
from contactfem.mechanics.condensed import Condensed
from contactfem.mechanics.saddle_point import Saddle
from contactfem.solvers.direct import Direct
from contactfem.solvers.interface_system import interface_unknowns
from contactfem.solvers.lagged_bulk import LaggedBulk
from contactfem.solvers.linear_bulk import LinearBulk
from contactfem.solvers.substructuring import Substructure

FEWEST = 10_000  # unknowns of a bulk that is not linear below which a new factor costs little
MOST = 2500  # unknowns of the interfaces and between ranks beyond which dense matrices are dear


def linear_solver(
    equations: Condensed, options: Mapping[str, str], timers: Timers, reuse: bool
) -> Direct:
    """The way that suits a system.

    A factor serves on where the multipliers are eliminated, without options of one's own, and where
    few unknowns are left on the interfaces and between the ranks; collective.

    Args:
        equations: The system.
        options: PETSc options for the linear solver.
        timers: Where time is booked.
        reuse: Whether a factor may serve longer than one iteration.
    """
    system = equations.system
    found: LinearBulk | LaggedBulk | None = None
    may = reuse and not options and not isinstance(equations, Saddle)
    if may and equations.interfaces and len(interface_unknowns(equations.interfaces)) <= MOST:
        if system.is_linear:
            found = LinearBulk(equations, timers)
        elif system.numbering.n_global >= FEWEST:
            found = LaggedBulk(equations, timers)
    if found is not None and _pays(found.bulk, system.comm):
        return found
    return Direct(equations, options, timers)


def _pays(bulk: Substructure, comm: MPI.Comm) -> bool:
    """Whether the dense matrix is small, and every rank has something to eliminate."""
    return len(bulk.border) <= MOST and bool(comm.allreduce(bulk.n_inner, MPI.MIN) > 0)
