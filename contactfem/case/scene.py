"""What stands in a scene: materials, bodies, obstacles, interfaces, conditions and probes."""

import itertools
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from contactfem.case.base import (
    BodyForce,
    Displacement,
    Finite,
    Flag,
    Model,
    Motion,
    PlateForce,
    Traction,
    unit_vector,
)
from contactfem.case.interface_laws import Friction, InterfaceHeat, NormalLaw
from contactfem.common.time_table import Table, constant
from contactfem.common.typing import Floats
from contactfem.common.units import (
    Conductance,
    Conductivity,
    Density,
    Expansion,
    HeatCapacity,
    HeatFluxField,
    HeatSourceField,
    Length,
    Number,
    Pressure,
    PressureField,
    Given,
    Temperature,
    TemperatureField,
    TemperatureTable,
)
from contactfem.meshes import MeshSpec

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
    """Deformable body, stress-free at its material's `reference_temperature`.

    With one, temperatures are absolute; without, they are rises above the stress-free state.
    A body starts, and stays where nothing else is said, at that of its stress-free state.
    `element`: linear (P1), or MINI for nearly incompressible simplices; auto: MINI if K/mu > 20.
    `temperature` is given over time where heat is not solved for; where it is, the body starts from
    `initial_temperature`, on a `thermal_mesh` of its own or else on the mechanical one.
    """

    material: str
    mesh: MeshSpec
    element: Literal["auto", "P1", "MINI"] = "auto"
    temperature: TemperatureTable | None = None
    initial_temperature: TemperatureField | None = None
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

    `heat_flux` enters through the current surface, `heat_source` per reference volume. Values of
    all but a grip may vary over place: as a table over one coordinate of the undeformed body,
    { over = "x", table = [["0 mm", "1 MPa"], ["10 mm", "2 MPa"]], factor = 1.0 }, whose `factor` may
    be one over time, or by a function "file.py:function" of x (dim, n) and t.
    """

    on: str
    at: Position | None = None
    displacement: Motion | None = None
    traction: Traction | None = None
    pressure: PressureField | None = None
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
    def field(self) -> Given | None:
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

    def components(self) -> dict[str, Given]:
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
