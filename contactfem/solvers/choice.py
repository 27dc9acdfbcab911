"""Choice of the solver for Newton's linear systems."""

from collections.abc import Mapping, Sequence

from mpi4py import MPI

from contactfem.common.timers import Timers
from contactfem.mechanics.bulk_system import System
from contactfem.mechanics.condensed import Condensed
from contactfem.mechanics.contact_equations import ContactEquations, Interface
from contactfem.mechanics.saddle_point import Saddle
from contactfem.solvers.direct import Direct
from contactfem.solvers.interface import LinearSolver
from contactfem.solvers.interface_system import interface_unknowns
from contactfem.solvers.lagged_bulk import LaggedBulk
from contactfem.solvers.linear_bulk import LinearBulk
from contactfem.solvers.substructuring import Substructure

FEWEST = 10_000  # unknowns of a bulk that is not linear below which a new factor costs little
MOST = 2500  # unknowns of the interfaces and between ranks beyond which dense matrices are dear


def contact_equations(
    system: System, interfaces: Sequence[Interface], timers: Timers
) -> ContactEquations:
    """The equations of a system: the saddle point where it has multipliers, else condensed.

    Args:
        system: The bodies.
        interfaces: The interfaces.
        timers: Where time is booked.
    """
    kept = len(system.numbering.multipliers) > 0
    return (Saddle if kept else Condensed)(system, interfaces, timers)


def linear_solver(
    equations: ContactEquations, options: Mapping[str, str], timers: Timers, reuse: bool
) -> LinearSolver:
    """The way that suits a system.

    A factor is kept where the multipliers are eliminated, without options of one's own, and where
    few unknowns are left on the interfaces and between the ranks; collective.

    Args:
        equations: The equations.
        options: PETSc options for the linear solver.
        timers: Where time is booked.
        reuse: Whether a factor may serve longer than one iteration.
    """
    system = equations.system
    found: LinearBulk | LaggedBulk | None = None
    may = reuse and not options and equations.eliminates_multipliers
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
