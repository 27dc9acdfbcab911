"""Which friction law an interface has."""

from collections.abc import Callable

import numpy as np

from contactfem.case.interface_laws import Friction, InterfaceHeat
from contactfem.case.schema import Case
from contactfem.common import user_function as functions
from contactfem.common.time_table import Table
from contactfem.common.typing import Floats
from contactfem.common.user_function import is_reference, reference
from contactfem.errors import CaseError
from contactfem.laws.conductance import Conductance, ConductanceLaw, Constant, GasGap, PowerLaw
from contactfem.laws.friction import (
    Coulomb,
    FrictionLaw,
    Tresca,
    UserFriction,
    VariableCoulomb,
    frictionless,
    rough,
)


def friction_law(case: Case, friction: Friction | None) -> FrictionLaw:
    """Friction law of an interface of the case.

    Raises:
        CaseError: A user's law that cannot be loaded.
    """
    if friction is not None and functions.is_reference(friction.law):
        try:
            function = functions.reference(friction.law).load(case.path.parent)
            law = UserFriction(friction.law, function)
            law.check()
        except CaseError as error:
            raise CaseError(f"{case.path}: friction {error}") from None
        return law
    if friction is not None and friction.law == "rough":
        return rough
    if friction is None or friction.coefficient == 0.0:
        return frictionless
    if friction.limit is not None:
        return Tresca(friction.limit)
    if friction.coefficient_table is not None:
        table = friction.coefficient_table
        return VariableCoulomb(table.variable, table.table)
    return Coulomb(friction.coefficient or 0.0)


def conductance_law(case: Case, heat: InterfaceHeat) -> ConductanceLaw | None:
    """Conductance law of an interface of a case; None where no heat passes.

    Raises:
        CaseError: A user's law that cannot be loaded.
    """
    if heat.law == "pressure":
        return PowerLaw(_uniform(heat), heat.hardness or 0.0, heat.exponent or 0.0)
    if heat.law == "constant":
        return Constant(_uniform(heat))
    if heat.law == "gas":
        return GasGap(heat.gas_conductivity or 0.0, heat.gas_distance or 0.0)
    if is_reference(heat.law):
        return _users_law(reference(heat.law).load(case.path.parent))
    return None


def varies(heat: InterfaceHeat) -> bool:
    """Whether the coefficient of the conductance varies over place or time."""
    h = heat.conductance
    return h is not None and (not isinstance(h, Table) or bool(h.times))


def _uniform(heat: InterfaceHeat) -> float:
    """Coefficient of the conductance; 1 where one that varies is multiplied with later."""
    return 1.0 if varies(heat) or heat.conductance is None else heat.conductance.values[0]


def _users_law(function: Callable[[Floats, Floats], Floats]) -> ConductanceLaw:
    """A user's h(p, g) as a law; its slopes, which nothing here needs, are not known."""

    def law(pressure: Floats, gap: Floats) -> Conductance:
        h = np.broadcast_to(np.asarray(function(pressure, gap), np.float64), pressure.shape)
        unknown = np.full_like(h, np.nan)
        return Conductance(h, unknown, unknown)

    return law
