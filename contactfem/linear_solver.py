"""Which way Newton's linear systems are solved: factorised each time, or once where that pays."""

from collections.abc import Mapping

from contactfem.condensed import Condensed
from contactfem.constant import Constant
from contactfem.direct import Direct
from contactfem.interface_matrix import interface_unknowns
from contactfem.reused import Reused
from contactfem.saddle import Saddle
from contactfem.timers import Timers

FEWEST = 10_000  # unknowns of a bulk that is not linear below which a new factor costs little
MOST = 2500  # unknowns of the interfaces beyond which dense matrices cost more than they save


def linear_solver(
    equations: Condensed, options: Mapping[str, str], timers: Timers, reuse: bool
) -> Direct:
    """The way that suits a system.

    A factor serves on where the multipliers are eliminated, on one rank (MUMPS gives its Schur
    complement to PETSc on one only), without options of one's own.

    Args:
        equations: The system.
        options: PETSc options for the linear solver.
        timers: Where time is booked.
        reuse: Whether a factor may serve longer than one iteration.
    """
    system = equations.system
    may = reuse and not options and system.comm.size == 1 and not isinstance(equations, Saddle)
    if may and equations.interfaces:
        few = len(interface_unknowns(equations.interfaces)) <= MOST
        if few and system.is_linear:
            return Constant(equations, timers)
        if few and system.numbering.n_global >= FEWEST:
            return Reused(equations, timers)
    return Direct(equations, options, timers)
