"""What stands in a scene: materials, bodies, obstacles, interfaces, conditions and probes."""

import itertools
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, WithJsonSchema, field_validator, model_validator

from contactfem.dimensions import UnitError
from contactfem.functions import FunctionRef, is_reference
from contactfem.meshes import MeshSpec
from contactfem.model import (
    BodyForce,
    Displacement,
    Finite,
    Flag,
    Model,
    NonNegative,
    PlateForce,
    Positive,
    Traction,
    unit_vector,
)
from contactfem.tables import Table, constant
from contactfem.units import (
    Conductance,
    Conductivity,
    Density,
    Expansion,
    ForcePerVolume,
    HeatCapacity,
    HeatFluxField,
    HeatFluxTable,
    HeatSourceField,
    Length,
    Number,
    Pressure,
    PressureTable,
    Temperature,
    TemperatureField,
    TemperatureTable,
    si,
)

Floats = NDArray[np.float64]
Modulus = Annotated[Pressure, Field(gt=0)]
Poisson = Annotated[float, Field(strict=True, gt=-1, lt=0.5, allow_inf_nan=False)]
Position = Annotated[tuple[Length, ...], Field(min_length=2, max_length=3)]


class Material(Model):
    """Isotropic solid: `model` with a pair of moduli, or a user's energy "file.py:function"."""

    model: Annotated[str, Field(pattern=r"^(neo-hooke|[^:]+\.py:[A-Za-z_]\w*)$")] = "neo-hooke"
    bulk_modulus: Modulus | None = None
    shear_modulus: Modulus | None = None
    youngs_modulus: Modulus | None = None
    poisson_ratio: Poisson | None = None
    expansion: Expansion = 0.0
    density: Annotated[Density, Field(gt=0)] | None = None
    conductivity: Annotated[Conductivity, Field(gt=0)] | None = None
    heat_capacity: Annotated[HeatCapacity, Field(gt=0)] | None = None
    reference_temperature: Annotated[Temperature, Field(gt=0)] | None = None
    parameters: dict[str, Number] = {}

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


class Body(Model):
    """Deformable body; temperatures are relative to that of the stress-free state.

    `element`: linear (P1), or MINI for nearly incompressible simplices; auto: MINI if K/mu > 20.
    `temperature` is given over time where heat is not solved for; where it is, the body starts from
    `initial_temperature`, on a `thermal_mesh` of its own or else on the mechanical one.
    """

    material: str
    mesh: MeshSpec
    element: Literal["auto", "P1", "MINI"] = "auto"
    temperature: TemperatureTable = Field(default_factory=lambda: constant(0.0))
    initial_temperature: TemperatureField = Field(default_factory=lambda: constant(0.0))
    thermal_mesh: MeshSpec | None = None


def _at_rest() -> Displacement:
    return {"x": constant(0.0), "y": constant(0.0)}


class RigidObstacle(Model):
    """Rigid mortar side; `displacement` holds both components.

    With a `temperature` it conducts heat, without one it only takes its share of frictional heat.
    """

    displacement: Displacement = Field(default_factory=_at_rest)
    temperature: TemperatureTable | None = None

    @field_validator("displacement")
    @classmethod
    def _both(cls, value: Displacement) -> Displacement:
        if "z" in value:
            raise ValueError("an obstacle moves in x and y")
        return _at_rest() | value


class Plane(RigidObstacle):
    """Half-plane; `normal` points out of the obstacle's solid."""

    shape: Literal["plane"]
    point: tuple[Length, Length]
    normal: tuple[Finite, Finite]

    @field_validator("normal")
    @classmethod
    def _unit(cls, value: tuple[float, float]) -> tuple[float, float]:
        return unit_vector(value)


class Circle(RigidObstacle):
    """Disk, or with `inside` the hollow of a disk."""

    shape: Literal["circle"]
    center: tuple[Length, Length]
    radius: Annotated[Length, Field(gt=0)]
    inside: Flag = False


class Polyline(RigidObstacle):
    """Chain of straight pieces with the obstacle's solid on the left of the walk along it."""

    shape: Literal["polyline"]
    points: Annotated[tuple[tuple[Length, Length], ...], Field(min_length=2)]
    closed: bool = False

    @field_validator("points")
    @classmethod
    def _apart(cls, value: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
        if any(a == b for a, b in itertools.pairwise(value)):
            raise ValueError("two points in a row are the same")
        return value

    @property
    def chain(self) -> Floats:
        """The points, the first one again at the end of a closed chain [m], (n, 2)."""
        return np.array(self.points + self.points[: int(self.closed)])


Obstacle = Annotated[Plane | Circle | Polyline, Field(discriminator="shape")]


class CoefficientTable(Model):
    """Friction coefficient over one variable, ascending [Pa, m/s or K]."""

    variable: Literal["pressure", "speed", "temperature"]
    table: Table


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

    `c_factor` scales the constant of the active set; `penalty` is ε_N, by default `penalty_factor`
    times ten times the stiffness of the facets that touch, 1 / (h_nm/E_nm + h_m/E_m).
    """

    law: Literal["multiplier", "penalty", "augmented"] = "multiplier"
    c_factor: Positive = 1.0
    penalty: Annotated[ForcePerVolume, Field(gt=0)] | None = None
    penalty_factor: Positive = 1.0

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.law == "multiplier" and (self.penalty is not None or self.penalty_factor != 1.0):
            raise ValueError("a penalty goes with law = 'penalty' or 'augmented'")
        return self


class Friction(Model):
    """Coulomb's law with a `coefficient`, Tresca's with a shear `limit`, or a user's; exact.

    `c_factor` is the constant of the active set of friction over that of normal contact: far from 1
    the status may cycle.
    With a penalty for normal contact it is regularised by c_T = `penalty`, by default
    `penalty_factor` times ε_N. `coefficient_table` gives the coefficient over pressure, slip speed
    or the temperature of the nonmortar side, told apart by units: [["0 MPa", 0.5], ["9 MPa", 0.3]].
    A user's law "file.py:function" gives the largest traction and its slopes from all three.
    """

    law: Annotated[str, Field(pattern=r"^(coulomb|tresca|[^:]+\.py:[A-Za-z_]\w*)$")] = "coulomb"
    coefficient: NonNegative | None = None
    coefficient_table: Annotated[CoefficientTable | None, WithJsonSchema(ROWS)] = None
    limit: Annotated[Pressure, Field(gt=0)] | None = None
    c_factor: Positive = 1.0
    penalty: Annotated[ForcePerVolume, Field(gt=0)] | None = None
    penalty_factor: Positive = 1.0

    @field_validator("coefficient_table", mode="before")
    @classmethod
    def _table(cls, value: object) -> object:
        return coefficient_table(value)

    @model_validator(mode="after")
    def _fits(self) -> Self:
        given = [
            k for k in ("coefficient", "coefficient_table", "limit") if getattr(self, k) is not None
        ]
        if is_reference(self.law):
            if given:
                raise ValueError(f"law = '{self.law}' takes no {given[0]}")
            return self
        allowed = ("limit",) if self.law == "tresca" else ("coefficient", "coefficient_table")
        if len(given) != 1 or given[0] not in allowed:
            raise ValueError(f"law = '{self.law}' takes one of {', '.join(allowed)}")
        return self

    def largest_traction(self, pressure: Floats) -> Floats | None:
        """Largest traction at some pressures [Pa]; None where it also depends on something else."""
        if is_reference(self.law):
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
        if is_reference(self.law):
            return f"by {self.law}"
        if self.limit is not None:
            return f"Tresca {self.limit:g} Pa"
        if self.coefficient_table is not None:
            return f"Coulomb, a function of {self.coefficient_table.variable}"
        return f"Coulomb {self.coefficient:g}"


class InterfaceHeat(Model):
    """Heat through an interface, q = h (ϑ_nm - ϑ_m) (15), and the share of frictional heat (16).

    `law`: "insulated"; "pressure", h = conductance (p / hardness)^exponent; "constant" where the
    surfaces touch; "gas", h = gas_conductivity / (gap + gas_distance), across open gaps too; or a
    user's function h(p, g) as "file.py:function". `partition` of the frictional heat enters the
    nonmortar side. `pressure` and `dissipation` (frictional heat per current area) stand in for
    those of mechanics.
    """

    law: Annotated[
        str, Field(pattern=r"^(insulated|pressure|constant|gas|[^:]+\.py:[A-Za-z_]\w*)$")
    ] = "insulated"
    conductance: Annotated[Conductance, Field(ge=0)] | None = None
    hardness: Annotated[Pressure, Field(gt=0)] | None = None
    exponent: Positive | None = None
    gas_conductivity: Annotated[Conductivity, Field(gt=0)] | None = None
    gas_distance: Annotated[Length, Field(gt=0)] | None = None
    partition: Annotated[float, Field(strict=True, ge=0, le=1)] = 0.5
    pressure: PressureTable | None = None
    dissipation: HeatFluxTable | None = None

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


class Interface(Model):
    """Two sides that may touch: "body.surface", and "body.surface" or an obstacle.

    `multiplier`: dual functions, or the shape functions, which need the saddle-point system.
    """

    nonmortar: str
    mortar: str
    search_radius: Annotated[Length, Field(gt=0)] | None = None
    multiplier: Literal["dual", "standard"] = "dual"
    normal: NormalLaw = Field(default_factory=NormalLaw)
    friction: Friction | None = None
    heat: InterfaceHeat = Field(default_factory=InterfaceHeat)

    @field_validator("friction", mode="before")
    @classmethod
    def _none(cls, value: object) -> object:
        return None if value is False else value


class Grip(Model):
    """Surface that moves as a rigid plate without rotation: each component led or loaded."""

    displacement: Displacement = {}
    force: PlateForce = {}

    @model_validator(mode="after")
    def _once(self) -> Self:
        both = sorted(self.displacement.keys() & self.force.keys())
        if both:
            raise ValueError(f"'{both[0]}' is given both as displacement and as force")
        return self


class Convection(Model):
    """Heat exchange with surroundings, q = coefficient (ϑ - ambient), on the current surface."""

    coefficient: Annotated[Conductance, Field(gt=0)]
    ambient: TemperatureTable = Field(default_factory=lambda: constant(0.0))


MECHANICAL = ("displacement", "traction", "pressure", "body_force", "grip")
THERMAL = ("temperature", "heat_flux", "heat_source", "convection")
IN_VOLUME = ("body_force", "heat_source")


class Condition(Model):
    """One condition on a surface "body.surface", on a "body", or on a body's vertex `at`.

    `heat_flux` enters through the current surface, `heat_source` per reference volume.
    """

    on: str
    at: Position | None = None
    displacement: Displacement | None = None
    traction: Traction | None = None
    pressure: PressureTable | None = None
    body_force: BodyForce | None = None
    grip: Grip | None = None
    temperature: TemperatureField | None = None
    heat_flux: HeatFluxField | None = None
    heat_source: HeatSourceField | None = None
    convection: Convection | None = None

    @model_validator(mode="after")
    def _one(self) -> Self:
        kinds = MECHANICAL + THERMAL
        given = [kind for kind in kinds if getattr(self, kind) is not None]
        if len(given) != 1:
            raise ValueError(
                f"must have one of {', '.join(kinds)}; found {' and '.join(given) or 'none'}"
            )
        if self.at is not None and self.displacement is None:
            raise ValueError("'at' goes with a displacement only")
        return self

    @property
    def kind(self) -> str:
        """Which one it is: the key that it was given under."""
        return next(kind for kind in MECHANICAL + THERMAL if getattr(self, kind) is not None)

    @property
    def is_thermal(self) -> bool:
        """Whether it is a condition on heat."""
        return self.kind in THERMAL

    @property
    def field(self) -> Table | FunctionRef | None:
        """Value of a thermal condition over time, or over place and time: ϑ, flux or source."""
        return self.temperature or self.heat_flux or self.heat_source

    @property
    def body(self) -> str:
        """Name of the body."""
        return self.on.partition(".")[0]

    @property
    def surface(self) -> str | None:
        """Name of the body's surface, if it is on one."""
        return self.on.partition(".")[2] or None

    def components(self) -> dict[str, Table]:
        """Prescribed displacement components, of the surface or of its grip."""
        given = self.grip.displacement if self.grip is not None else self.displacement
        return {str(axis): table for axis, table in (given or {}).items()}


class Probe(Model):
    """A value at a material point of a body."""

    on: str
    at: Position
    value: Literal[
        "displacement.x",
        "displacement.y",
        "displacement.z",
        "stress.xx",
        "stress.yy",
        "stress.zz",
        "stress.xy",
        "stress.yz",
        "stress.xz",
        "temperature",
    ]
