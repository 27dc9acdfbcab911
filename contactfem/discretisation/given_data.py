"""Data of a case over place and time as equations take them."""

import numpy as np

from contactfem.case.schema import Case
from contactfem.common.place_time import Profile, Varying
from contactfem.common.time_table import Table
from contactfem.common.typing import Floats
from contactfem.common.user_function import FunctionRef
from contactfem.errors import CaseError


def given(case: Case, value: Table | Profile | FunctionRef) -> Table | Varying:
    """A value over time, or over place and time; a user's function is checked when it is called.

    Raises:
        CaseError: A function that cannot be loaded.
    """
    if isinstance(value, Table):
        return value
    if isinstance(value, Profile):
        return Varying(value, ramped=not value.times)
    function = value.load(case.path.parent)

    def checked(x: Floats, t: float) -> Floats:
        try:
            found = np.asarray(function(x, t), dtype=np.float64)
            values = np.broadcast_to(found, x.shape[1:])
        except Exception as error:  # whatever a user's function does
            kind = f"{type(error).__name__}: {error}"
            raise CaseError(
                f"{case.path}: {value}: did not give one value for each of {x.shape[1]} points at "
                f"t = {t:g} s: {kind}"
            ) from None
        if not np.isfinite(values).all():
            raise CaseError(f"{case.path}: {value}: gave a value that is not finite, t = {t:g} s")
        return values

    return Varying(checked)
