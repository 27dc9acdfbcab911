"""Parts of the loop over the steps: solver, verification, adaptation, heat."""

from __future__ import annotations

from typing import TYPE_CHECKING

from contactfem.adaptivity.decisions import MeshHistory
from contactfem.case.schema import Case
from contactfem.case.temperature_scale import given_temperature, responds_to_temperature
from contactfem.common.timers import Timers
from contactfem.discretisation.discretise import Discretisation
from contactfem.discretisation.state import State
from contactfem.solvers.newton import NewtonSolver

if TYPE_CHECKING:
    from contactfem.adaptivity.adaptation import Adaptation
    from contactfem.run.inspection import Verification
    from contactfem.thermomechanics.staggered import HeatStart
    from contactfem.thermomechanics.thermal_problem import Thermal


def newton_solver(
    case: Case, discretisation: Discretisation, timers: Timers, reuse: bool = True
) -> NewtonSolver:
    """Newton's method as a case sets it, with factors that serve on or without."""
    return NewtonSolver(
        discretisation.system,
        discretisation.interfaces,
        case.solver.tolerance,
        case.solver.max_iterations,
        case.solver.petsc,
        timers,
        case.solver.reuse and reuse,
    )


def verification_of(case: Case, thermal: Thermal | None, ramp_end: float) -> Verification | None:
    """What looks at accepted states, only imported where the case does not decline it."""
    if not case.solver.verify:
        return None
    from contactfem.run.inspection import Verification

    return Verification(case, thermal, ramp_end)


def adaptation_of(
    case: Case,
    discretisation: Discretisation,
    timers: Timers,
    lasting: tuple[MeshHistory, MeshHistory] | None,
) -> Adaptation | None:
    """What judges steps, only imported where the case asks for an error."""
    if case.adaptivity is None:
        return None
    from contactfem.adaptivity.adaptation import Adaptation

    return Adaptation(case, discretisation, timers, lasting)


class HeatSide:
    """Driver and record of heat; only imported where heat is solved for."""

    def __init__(self, case: Case, thermal: Thermal, solver: NewtonSolver | None) -> None:
        from contactfem.run.heat_report import HeatRecord
        from contactfem.thermomechanics.staggered import HeatStart, Passes, Staggered

        assert case.heat is not None
        respond, given = responds_to_temperature(case), case.heat
        passes = Passes(given.max_passes, given.tolerance, given.relaxation, respond)
        self._start = HeatStart
        self.driver = Staggered(solver, thermal, passes)
        self.record = HeatRecord(thermal)

    def start(self, state: State) -> HeatStart:
        """What heat starts a step from."""
        return self._start(state.t, state.theta, state.thermal_u, state.exchanges, state.rate)


def held_by_contact_alone(case: Case, discretisation: Discretisation) -> frozenset[int]:
    """Interfaces, by number, of which only contact holds a body."""
    found = []
    for k, interface in enumerate(discretisation.interfaces):
        sides = case.interfaces[interface.name]
        bodies = {side.partition(".")[0] for side in (sides.nonmortar, sides.mortar)}
        if not bodies.isdisjoint(discretisation.unrestrained):
            found.append(k)
    return frozenset(found)


def nonmortar_temperature(case: Case, discretisation: Discretisation, k: int, t: float) -> float:
    """Temperature of the nonmortar body of interface number k at a time [K]."""
    sides = case.interfaces[discretisation.interfaces[k].name]
    return given_temperature(case, sides.nonmortar.partition(".")[0])(t)
