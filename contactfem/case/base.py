"""What all tables of a case file have in common."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidationInfo,
)
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from contactfem.common.units import (
    LengthField,
    LengthTable,
    LineForceTable,
    PressureField,
    VolumeForceField,
)

Axis = Literal["x", "y", "z"]
AXES: tuple[Axis, ...] = ("x", "y", "z")
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]*$")]
Positive = Annotated[float, Field(strict=True, gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(strict=True, ge=0, allow_inf_nan=False)]
Flag = Annotated[bool, Field(strict=True)]
Finite = Annotated[float, Field(strict=True, allow_inf_nan=False)]


class Model(BaseModel):
    """Frozen table of a case file; a key that it does not know is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


@dataclass(frozen=True)
class ByAxis:
    """Marks a dict of components that may also be given as a list, in the order x, y, z."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Name the components of a list."""
        return core_schema.with_info_before_validator_function(_by_axis, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Editors see a table of components or a list of all."""
        table = handler(schema)
        value = table.pop("additionalProperties", {})
        table.pop("propertyNames", None)
        table |= {
            "properties": {axis: value for axis in AXES},
            "additionalProperties": False,
            "minProperties": 1,
        }
        return {"anyOf": [table, {"type": "array", "items": value, "minItems": 2, "maxItems": 3}]}


def _by_axis(value: object, info: ValidationInfo) -> object:
    """Table of components.

    Raises:
        PydanticCustomError: no component, or a list that is too long or too short.
    """
    count = int((info.context or {}).get("axes", len(value) if isinstance(value, list) else 0))
    if isinstance(value, dict) and value:
        return value
    if isinstance(value, Sequence) and not isinstance(value, str) and len(value) == count:
        return dict(zip(AXES, value, strict=False))
    raise PydanticCustomError(
        "components", "must be a table with x, y or z, or a list of {count}", {"count": count or 2}
    )


Displacement = Annotated[dict[Axis, LengthTable], ByAxis()]
Motion = Annotated[dict[Axis, LengthField], ByAxis()]
Traction = Annotated[dict[Axis, PressureField], ByAxis()]
BodyForce = Annotated[dict[Axis, VolumeForceField], ByAxis()]
PlateForce = Annotated[dict[Axis, LineForceTable], ByAxis()]


def unit_vector(vector: tuple[float, ...]) -> tuple[float, ...]:
    """Vector of length one.

    Raises:
        ValueError: the vector is zero.
    """
    length = math.hypot(*vector)
    if not length > 0:
        raise ValueError("must not be zero")
    return tuple(component / length for component in vector)
