"""What stands in a scene: bodies, obstacles, interfaces, conditions and probes."""

from typing import Annotated, Literal, Self

from pydantic import Field, PrivateAttr, field_validator, model_validator

from contactfem.case.base import (
    BodyForce,
    Displacement,
    Model,
    Motion,
    PlateForce,
    Traction,
)
from contactfem.case.interface_laws import Friction, InterfaceHeat, NormalLaw
from contactfem.common.time_table import Table, constant
from contactfem.common.units import (
    Conductance,
    Given,
    HeatFluxField,
    HeatSourceField,
    Length,
    LengthTable,
    PressureField,
    TemperatureField,
    TemperatureTable,
)
from contactfem.meshes import MeshSpec

Position = Annotated[tuple[Length, ...], Field(min_length=2, max_length=3)]


class Body(Model):
    """Deformable body, stress-free at its material's `reference_temperature`.

    With one, temperatures are absolute; without, they are rises above the stress-free state.
    """

    material: str | None = Field(
        default=None,
        description="name of its material, given here or of the library; with `materials` that "
        "of all other cells",
    )
    materials: dict[str, str] = Field(
        default={}, description="names of materials by group of cells of its mesh file"
    )
    mesh: MeshSpec = Field(description="geometry with its mesh, or a mesh file")
    element: Literal["auto", "P1", "MINI"] = Field(
        default="auto",
        description="linear (P1), or MINI for nearly incompressible simplices; auto takes "
        "MINI if K/μ > 20",
    )
    temperature: TemperatureTable | None = Field(
        default=None,
        description="temperature over time, where heat is not solved for; by default that of the "
        "stress-free state",
    )
    initial_temperature: TemperatureField | None = Field(
        default=None,
        description="temperature at the start, where heat is solved for; by default that of the "
        "stress-free state",
    )
    thermal_mesh: MeshSpec | None = Field(
        default=None, description="mesh for the temperature; by default that of `mesh`"
    )

    @model_validator(mode="after")
    def _of_something(self) -> Self:
        if self.material is None and not self.materials:
            raise ValueError("must have 'material', or 'materials' by groups of cells")
        return self

    @property
    def main_material(self) -> str:
        """Name of its material, or of the first one."""
        return self.material or next(iter(self.materials.values()))

    @property
    def all_materials(self) -> tuple[str, ...]:
        """Names of all materials that it has, each once."""
        own = (self.material,) if self.material is not None else ()
        return tuple(dict.fromkeys((*own, *self.materials.values())))


class Interface(Model):
    """Two surfaces that may touch."""

    nonmortar: str = Field(
        default="",
        description='surface "body.surface" that has the multipliers; give it with `mortar`, or '
        "give `between`",
    )
    mortar: str = Field(
        default="", description='opposite surface "body.surface", or the name of an obstacle'
    )
    between: tuple[str, str] | None = Field(
        default=None,
        description="the two sides in any order, in place of `nonmortar` and `mortar`: the program "
        "chooses, and `check` says why. Nonmortar is the side that does not extend beyond the "
        "other; else that with facets larger by half or more; else the softer; else the coarser",
        examples=[["pad.bottom", "floor"]],
    )
    search_radius: Annotated[Length, Field(gt=0)] | None = Field(
        default=None,
        description="distance within which the surfaces look for each other; by default any "
        "gap, and overlaps as deep as the bodies are thick",
    )
    multiplier: Literal["dual", "standard"] = Field(
        default="dual",
        description="dual functions, which can be eliminated, or the shape functions, which "
        "need `system` saddle",
    )
    normal: NormalLaw = Field(default_factory=NormalLaw, description="law of the contact pressure")
    friction: Friction | None = Field(
        default=None, description="law of friction; none if not given, or with false"
    )
    heat: InterfaceHeat = Field(
        default_factory=InterfaceHeat, description="law of heat through the interface"
    )
    interference: LengthTable | None = Field(
        default=None,
        description="by how much the parts are larger than their meshes, over time: press fits "
        "without overlapping meshes",
    )
    clearance: LengthTable | None = Field(
        default=None, description="play beside the gap of the meshes, over time"
    )
    adjust: Annotated[Length, Field(ge=0)] | None = Field(
        default=None,
        description="initial gaps and overlaps up to this count as none: nothing is moved, no "
        "stress comes of it; how far tied surfaces may be apart",
    )

    _why: str = PrivateAttr(default="")

    @field_validator("friction", mode="before")
    @classmethod
    def _named(cls, value: object) -> object:
        if value == "rough":
            return {"law": value}
        return None if value is False else value

    @model_validator(mode="after")
    def _two_sides(self) -> Self:
        given = [key for key in ("nonmortar", "mortar") if getattr(self, key)]
        if self.between is not None and given:
            raise ValueError(f"give either between, or nonmortar and mortar; found {given[0]} too")
        if self.between is None and len(given) < 2:
            lacks = [key for key in ("nonmortar", "mortar") if key not in given]
            raise ValueError(
                f"{' and '.join(lacks)}: missing; give nonmortar and mortar, or the two sides in "
                'any order as between = ["body.surface", "body.surface"]'
            )
        return self

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.normal.law == "tied":
            for key in ("friction", "interference", "clearance"):
                if getattr(self, key) is not None:
                    raise ValueError(f"{key}: does not go with normal.law = 'tied'")
        return self

    def with_sides(self, nonmortar: str, mortar: str, why: str) -> "Interface":
        """The same interface with its sides chosen; they do not count as given.

        Args:
            nonmortar: Surface that has the multipliers.
            mortar: The opposite surface, or an obstacle.
            why: What spoke for this choice.
        """
        values = dict(self) | {"nonmortar": nonmortar, "mortar": mortar}
        chosen = Interface.model_construct(set(self.model_fields_set), **values)
        chosen._why = why
        return chosen

    @property
    def why(self) -> str:
        """What spoke for the nonmortar side, where the program chose it."""
        return self._why

    def offset(self, t: float, ramp_end: float) -> float:
        """Interference less clearance at a time [m].

        Args:
            t: Time [s].
            ramp_end: Time at which constant values are reached [s].
        """
        given = [0.0 if x is None else x.at(t, ramp_end) for x in self.offsets]
        return given[0] - given[1]

    @property
    def offsets(self) -> tuple[Table | None, Table | None]:
        """Interference and clearance over time [m]."""
        return self.interference, self.clearance


class Grip(Model):
    """Surface that moves as a rigid plate without rotation; a component has a motion or a force."""

    displacement: Displacement = Field(
        default={}, description="prescribed components of the motion"
    )
    force: PlateForce = Field(default={}, description="prescribed components of the force")

    @model_validator(mode="after")
    def _once(self) -> Self:
        both = sorted(self.displacement.keys() & self.force.keys())
        if both:
            raise ValueError(f"'{both[0]}' is given both as displacement and as force")
        return self


class Convection(Model):
    """Heat exchange with surroundings, q = coefficient (ϑ - ambient), on the current surface."""

    coefficient: Annotated[Conductance, Field(gt=0)] = Field(
        description="heat transfer coefficient"
    )
    ambient: TemperatureTable = Field(
        default_factory=lambda: constant(0.0), description="temperature of the surroundings"
    )


MECHANICAL = ("displacement", "traction", "pressure", "body_force", "grip")
THERMAL = ("temperature", "heat_flux", "heat_source", "convection")
IN_VOLUME = ("body_force", "heat_source")


class Condition(Model):
    """One load or support: `on` with one other key, or with `displacement` and `at`.

    Values of all but a grip may vary over place: as a table over one coordinate of the undeformed
    body, { over = "x", table = [["0 mm", "1 MPa"], ["10 mm", "2 MPa"]] }, with a `factor` that may
    be one over time, or by a function "file.py:function" of places x (dim, n) and the time t.
    """

    on: str = Field(description='a surface "body.surface", or a "body"')
    at: Position | None = Field(
        default=None, description="position of one vertex of the body, with a displacement only"
    )
    displacement: Motion | None = Field(
        default=None, description="prescribed components; the others stay free"
    )
    traction: Traction | None = Field(default=None, description="force per reference area")
    pressure: PressureField | None = Field(
        default=None, description="pressure on the current surface; it follows the deformation"
    )
    body_force: BodyForce | None = Field(default=None, description="force per reference volume")
    grip: Grip | None = Field(
        default=None, description="the surface moves as a rigid plate without rotation"
    )
    temperature: TemperatureField | None = Field(default=None, description="prescribed temperature")
    heat_flux: HeatFluxField | None = Field(
        default=None, description="heat that enters through the current surface, per area"
    )
    heat_source: HeatSourceField | None = Field(
        default=None, description="heat that is produced, per reference volume"
    )
    convection: Convection | None = Field(
        default=None, description="heat exchange with the surroundings"
    )

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

    on: str = Field(description="name of the body")
    at: Position = Field(
        description="position of the material point in the reference configuration"
    )
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
    ] = Field(description="what to record there")
