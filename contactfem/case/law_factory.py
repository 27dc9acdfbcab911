"""Which friction law an interface has."""

from contactfem.case.interface_laws import Friction
from contactfem.case.schema import Case
from contactfem.common import user_function as functions
from contactfem.errors import CaseError
from contactfem.laws.complementarity import (
    Coulomb,
    FrictionLaw,
    GivenFriction,
    Tresca,
    VariableCoulomb,
    frictionless,
)


def friction_law(case: Case, friction: Friction | None) -> FrictionLaw:
    """Friction law of an interface of the case.

    Raises:
        CaseError: A user's law that cannot be loaded.
    """
    if friction is not None and functions.is_reference(friction.law):
        try:
            function = functions.reference(friction.law).load(case.path.parent)
            law = GivenFriction(friction.law, function)
            law.check()
        except CaseError as error:
            raise CaseError(f"{case.path}: friction {error}") from None
        return law
    if friction is None or friction.coefficient == 0.0:
        return frictionless
    if friction.limit is not None:
        return Tresca(friction.limit)
    if friction.coefficient_table is not None:
        table = friction.coefficient_table
        return VariableCoulomb(table.variable, table.table)
    return Coulomb(friction.coefficient or 0.0)
