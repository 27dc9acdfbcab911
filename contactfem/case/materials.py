"""Materials of a scene."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from contactfem.case.base import Model
from contactfem.common.units import (
    Conductivity,
    Density,
    Expansion,
    HeatCapacity,
    Number,
    Pressure,
    Temperature,
)

Modulus = Annotated[Pressure, Field(gt=0)]
Poisson = Annotated[float, Field(strict=True, gt=-1, lt=0.5, allow_inf_nan=False)]


class Material(Model):
    """Isotropic solid with a pair of moduli: K and μ, or E and ν."""

    model: Annotated[str, Field(pattern=r"^(neo-hooke|[^:]+\.py:[A-Za-z_]\w*)$")] = Field(
        default="neo-hooke",
        description='"neo-hooke", or a strain energy of your own as "file.py:function"',
    )
    bulk_modulus: Modulus | None = Field(
        default=None, description="bulk modulus K; give it with `shear_modulus`"
    )
    shear_modulus: Modulus | None = Field(
        default=None, description="shear modulus μ; give it with `bulk_modulus`"
    )
    youngs_modulus: Modulus | None = Field(
        default=None, description="Young's modulus E; give it with `poisson_ratio`"
    )
    poisson_ratio: Poisson | None = Field(
        default=None, description="Poisson's ratio ν; give it with `youngs_modulus`"
    )
    expansion: Expansion = Field(
        default=0.0, description="coefficient of linear thermal expansion α"
    )
    density: Annotated[Density, Field(gt=0)] | None = Field(
        default=None, description="density ρ₀ of the reference configuration"
    )
    conductivity: Annotated[Conductivity, Field(gt=0)] | None = Field(
        default=None, description="thermal conductivity k"
    )
    heat_capacity: Annotated[HeatCapacity, Field(gt=0)] | None = Field(
        default=None, description="heat capacity c per mass"
    )
    reference_temperature: Annotated[Temperature, Field(gt=0)] | None = Field(
        default=None,
        description="absolute temperature of the stress-free state, that expansion counts from; "
        "with it all temperatures of the case are absolute",
    )
    parameters: dict[str, Number] = Field(
        default={}, description="numbers for a strain energy of your own, by name"
    )

    @model_validator(mode="after")
    def _one_pair(self) -> Self:
        pairs = (
            (self.bulk_modulus, self.shear_modulus),
            (self.youngs_modulus, self.poisson_ratio),
        )
        full = [None not in pair for pair in pairs]
        given = [any(value is not None for value in pair) for pair in pairs]
        if sum(full) != 1 or sum(given) != 1:
            raise ValueError(
                "give either bulk_modulus and shear_modulus, or youngs_modulus and poisson_ratio"
            )
        return self

    @property
    def K(self) -> float:
        """Bulk modulus [Pa]."""
        if self.bulk_modulus is not None:
            return self.bulk_modulus
        return self.E / (3.0 * (1.0 - 2.0 * self.nu))

    @property
    def mu(self) -> float:
        """Shear modulus [Pa]."""
        if self.shear_modulus is not None:
            return self.shear_modulus
        return self.E / (2.0 * (1.0 + self.nu))

    @property
    def E(self) -> float:
        """Young's modulus [Pa]."""
        if self.youngs_modulus is not None:
            return self.youngs_modulus
        return 9.0 * self.K * self.mu / (3.0 * self.K + self.mu)

    @property
    def nu(self) -> float:
        """Poisson's ratio [-]."""
        if self.poisson_ratio is not None:
            return self.poisson_ratio
        return (3.0 * self.K - 2.0 * self.mu) / (2.0 * (3.0 * self.K + self.mu))
