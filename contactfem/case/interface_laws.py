"""Laws of an interface in a case file: contact, friction, heat."""

import itertools
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, WithJsonSchema, field_validator, model_validator

from contactfem.case.base import Model, NonNegative, Positive
from contactfem.common.time_table import Table
from contactfem.common.typing import Floats
from contactfem.common.unit_parser import UnitError
from contactfem.common.units import (
    ConductanceField,
    Conductivity,
    ForcePerVolume,
    Given,
    HeatFluxTable,
    Length,
    Pressure,
    PressureTable,
    si,
)
from contactfem.common.user_function import is_reference


class CoefficientTable(Model):
    """Friction coefficient over one variable, ascending [Pa, m/s or K]."""

    variable: Literal["pressure", "speed", "temperature"] = Field(
        description="what the coefficient depends on"
    )
    table: Table = Field(description="coefficients over it, ascending")


VARIABLES: dict[str, Literal["pressure", "speed", "temperature"]] = {
    "Pa": "pressure", "m/s": "speed", "K": "temperature",
}  # fmt: skip


ROWS: dict[str, Any] = {
    "type": "array",
    "minItems": 2,
    "examples": [[["0 MPa", 0.5], ["9 MPa", 0.3]]],
}


def coefficient_table(rows: object) -> CoefficientTable:
    """Read [["0 MPa", 0.5], ["9 MPa", 0.3]].

    Raises:
        ValueError: not such a table.
    """
    pairs = [row for row in rows if isinstance(row, list)] if isinstance(rows, list) else []
    for symbol, variable in VARIABLES.items():
        try:
            places = tuple(si(str(row[0]), symbol) for row in pairs)
            values = tuple(float(row[1]) for row in pairs)
        except (UnitError, TypeError, ValueError, IndexError):
            continue
        ascending = all(a < b for a, b in itertools.pairwise(places))
        if len(pairs) > 1 and ascending and all(0 <= v < float("inf") for v in values):
            return CoefficientTable(variable=variable, table=Table(places, values))
    raise ValueError(
        "must be a table over pressure, slip speed or temperature, ascending, with values >= 0, "
        "such as [['0 MPa', 0.5], ['9 MPa', 0.3]]"
    )


class NormalLaw(Model):
    """Impenetrability: exact by multipliers, by a penalty (13), or by an augmented Lagrangian.

    Ten times the stiffness of the facets in contact is 10 / (h_nm/E_nm + h_m/E_m).
    """

    law: Literal["multiplier", "penalty", "augmented", "tied"] = Field(
        default="multiplier",
        description="exact (multiplier), or regularised by a penalty (13) or an augmented "
        "Lagrangian; tied surfaces stay together (10)",
    )
    c_factor: Positive = Field(
        default=1.0, description="factor on the constant c of the active set"
    )
    penalty: Annotated[ForcePerVolume, Field(gt=0)] | None = Field(
        default=None,
        description="penalty ε_N; by default `penalty_factor` times ten times the stiffness "
        "of the facets in contact",
    )
    penalty_factor: Positive = Field(default=1.0, description="factor on the default penalty")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.law in ("multiplier", "tied") and (
            self.penalty is not None or self.penalty_factor != 1.0
        ):
            raise ValueError("a penalty goes with law = 'penalty' or 'augmented'")
        return self


class Friction(Model):
    """Friction: Coulomb's law, Tresca's, or a law of your own; exact with exact normal contact.

    With a penalty for normal contact friction is regularised by c_T. A `c_factor` far from 1 may
    make the active set cycle. A coefficient table is such as [["0 MPa", 0.5], ["9 MPa", 0.3]]. A
    law of your own gives the friction bound and its slopes from pressure, speed and temperature.
    """

    law: Annotated[str, Field(pattern=r"^(coulomb|tresca|rough|[^:]+\.py:[A-Za-z_]\w*)$")] = Field(
        default="coulomb",
        description='"coulomb" with a coefficient, "tresca" with a `limit`, "rough" (what touches '
        'never slips), or a law of your own as "file.py:function"',
    )
    coefficient: NonNegative | None = Field(default=None, description="friction coefficient")
    coefficient_table: Annotated[CoefficientTable | None, WithJsonSchema(ROWS)] = Field(
        default=None,
        description="friction coefficient over pressure, slip speed or the temperature of the "
        "nonmortar side; the unit tells which",
    )
    limit: Annotated[Pressure, Field(gt=0)] | None = Field(
        default=None, description="largest shear traction of Tresca's law"
    )
    c_factor: Positive = Field(
        default=1.0,
        description="constant of the active set of friction over that of normal contact",
    )
    penalty: Annotated[ForcePerVolume, Field(gt=0)] | None = Field(
        default=None,
        description="tangential penalty c_T, with a penalty for normal contact; by default "
        "`penalty_factor` times ε_N",
    )
    penalty_factor: Positive = Field(
        default=1.0, description="c_T over ε_N, where `penalty` is not given"
    )

    @field_validator("coefficient_table", mode="before")
    @classmethod
    def _table(cls, value: object) -> object:
        return coefficient_table(value)

    @model_validator(mode="after")
    def _fits(self) -> Self:
        given = [
            k for k in ("coefficient", "coefficient_table", "limit") if getattr(self, k) is not None
        ]
        if is_reference(self.law) or self.law == "rough":
            if given:
                raise ValueError(f"law = '{self.law}' takes no {given[0]}")
            return self
        allowed = ("limit",) if self.law == "tresca" else ("coefficient", "coefficient_table")
        if len(given) != 1 or given[0] not in allowed:
            raise ValueError(f"law = '{self.law}' takes one of {', '.join(allowed)}")
        return self

    def largest_traction(self, pressure: Floats) -> Floats | None:
        """Largest traction at some pressures [Pa]; None where it also depends on something else."""
        if is_reference(self.law) or self.law == "rough":
            return None
        if self.limit is not None:
            return np.where(pressure > 0.0, self.limit, 0.0)
        if self.coefficient_table is not None:
            table = self.coefficient_table.table
            known = self.coefficient_table.variable == "pressure"
            return np.interp(pressure, table.times, table.values) * pressure if known else None
        return (self.coefficient or 0.0) * pressure

    def words(self) -> str:
        """The law in a few words."""
        if self.law == "rough":
            return "rough"
        if is_reference(self.law):
            return f"by {self.law}"
        if self.limit is not None:
            return f"Tresca {self.limit:g} Pa"
        if self.coefficient_table is not None:
            return f"Coulomb, a function of {self.coefficient_table.variable}"
        return f"Coulomb {self.coefficient:g}"


class InterfaceHeat(Model):
    """Heat through an interface, q = h (ϑ_nm - ϑ_m) (15), and the share of frictional heat (16).

    Law "pressure": h = conductance (p / hardness)^exponent. Law "constant": h = conductance where
    the surfaces touch. Law "gas": h = gas_conductivity / (gap + gas_distance), across open gaps
    too. The conductance may vary over time and place, on the undeformed nonmortar side.
    """

    law: Annotated[
        str, Field(pattern=r"^(insulated|pressure|constant|gas|[^:]+\.py:[A-Za-z_]\w*)$")
    ] = Field(
        default="insulated",
        description="conductance h: none (insulated), by `pressure`, `constant`, by the `gas` "
        'in the gap, or a function h(p, g) of your own as "file.py:function"',
    )
    conductance: ConductanceField | None = Field(
        default=None, description='h of law "constant"; h at p = hardness of law "pressure"'
    )
    hardness: Annotated[Pressure, Field(gt=0)] | None = Field(
        default=None, description='Vickers hardness of law "pressure"'
    )
    exponent: Positive | None = Field(default=None, description='exponent of law "pressure"')
    gas_conductivity: Annotated[Conductivity, Field(gt=0)] | None = Field(
        default=None, description="thermal conductivity of the gas"
    )
    gas_distance: Annotated[Length, Field(gt=0)] | None = Field(
        default=None, description="thickness of the gas between surfaces in contact"
    )
    partition: Annotated[float, Field(strict=True, ge=0, le=1)] = Field(
        default=0.5, description="share of frictional heat that enters the nonmortar side"
    )
    pressure: PressureTable | None = Field(
        default=None, description="contact pressure, in place of that of mechanics"
    )
    dissipation: HeatFluxTable | None = Field(
        default=None, description="frictional heat per current area, in place of that of mechanics"
    )

    @field_validator("conductance")
    @classmethod
    def _not_negative(cls, value: Given | None) -> Given | None:
        if value is not None and min(value.values, default=0.0) < 0.0:
            raise ValueError("must be >= 0")
        return value

    @model_validator(mode="after")
    def _fits(self) -> Self:
        keys = ("conductance", "hardness", "exponent", "gas_conductivity", "gas_distance")
        given = [key for key in keys if getattr(self, key) is not None]
        needed = HEAT_LAWS.get(self.law, ())
        if sorted(given) != sorted(needed):
            wanted = ", ".join(needed) if needed else "none of these"
            raise ValueError(
                f"law = '{self.law}' takes {wanted}; found {', '.join(given) or 'none'}"
            )
        return self

    @property
    def conducts(self) -> bool:
        """Whether heat can pass."""
        return self.law != "insulated"


HEAT_LAWS = {
    "pressure": ("conductance", "hardness", "exponent"),
    "constant": ("conductance",),
    "gas": ("gas_conductivity", "gas_distance"),
}
