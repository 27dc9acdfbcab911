"""Tables of a case beside its scene: time, solver, heat, adaptivity, output."""

from typing import Annotated, Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from contactfem.case.base import Flag, Model, Name, NonNegative
from contactfem.common.units import (
    Difference,
    Duration,
    Length,
    Number,
    TemperatureDifference,
    read_quantity,
)
from contactfem.verification.contact import CLOSED_FORMS, closed_form

PositiveTime = Annotated[Duration, Field(gt=0)]
Fraction = Annotated[float, Field(strict=True, gt=0, lt=1)]
Count = Annotated[int, Field(strict=True, ge=0, le=1_000_000)]
Ratio = Annotated[Number, Field(gt=0, lt=1)]
STEPS = 1024.0  # the smallest step, unless given, is this many times smaller than the first


class Time(Model):
    """Time from zero to `end`; the first step is `step`, later ones adapt between the limits."""

    end: PositiveTime = Field(description="time at which the run ends; it starts at zero")
    step: PositiveTime = Field(description="first step; steps adapt from there")
    step_min: PositiveTime = Field(
        default_factory=lambda data: data.get("step", 0.0) / STEPS,
        description="shortest step; by default step / 1024",
    )
    step_max: PositiveTime = Field(
        default_factory=lambda data: data.get("step", 0.0),
        description="longest step; by default step",
    )

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        names = ("step_min", "step", "step_max")
        for low, high in (names[:2], names[1:], ("step", "end")):
            if getattr(self, low) > getattr(self, high):
                raise ValueError(
                    f"{low} = {getattr(self, low):g} s is longer than "
                    f"{high} = {getattr(self, high):g} s"
                )
        return self


class Solver(Model):
    """Newton's method, its linear systems, and the independent look at accepted states.

    The look finds states that cannot be: bodies in each other, cells turned over, a body thrown
    away, forces out of balance, contact that pulls, friction that gives work, heat from nowhere.
    """

    system: Literal["condensed", "saddle"] = Field(
        default="condensed",
        description="multipliers are eliminated (condensed), or unknowns beside u (saddle)",
    )
    tolerance: Fraction = Field(
        default=1e-10, description="scaled residual at which Newton's method has converged"
    )
    max_iterations: Annotated[Count, Field(ge=1)] = Field(
        default=30, description="Newton iterations after which a step has failed"
    )
    max_cutbacks: Count = Field(
        default=8, description="how often a step is halved before the run gives up"
    )
    reuse: Flag = Field(
        default=True,
        description="whether a factorisation may be used again where that is faster "
        "(condensed, without `petsc`); the answer is the same",
    )
    verify: Literal["stop", "warn", False] = Field(
        default="stop",
        description="what follows such a state: end the run with exit code 5 (stop), go on with a "
        "warning (warn), or do not look (false)",
    )
    petsc: dict[str, str] = Field(
        default={}, description="PETSc options of the linear solver, over the defaults"
    )


class Heat(Model):
    """Heat conduction, solved after the mechanics of each step (isothermal split).

    The default scheme dG(1) is of third order, and what is much faster than a step dies out. cG(1)
    is of second order and has half the unknowns, but where the start is inconsistent or ρc tiny its
    temperatures may change sign in every step (ringing); the run warns of that. A step in which a
    pass of mechanics and heat changes temperatures, or by its gap a conductance, by more than a
    percent is passed over again up to the fixed point, unless `max_passes` is given.
    """

    scheme: Literal["cG(1)", "cG(2)", "cG(3)", "cG(4)", "dG(0)", "dG(1)", "dG(2)", "steady"] = (
        Field(
            default="dG(1)",
            description='time scheme: the L-stable dG(k), cG(k) (22)-(27), or "steady"',
        )
    )
    max_passes: Annotated[Count, Field(ge=1)] | None = Field(
        default=None,
        description="most passes of mechanics and heat per step, 1 for the split of the article; "
        "by default as many as a step needs",
    )
    tolerance: Fraction = Field(
        default=1e-6,
        description="change of the temperature, relative to its range, below which no more "
        "passes are made",
    )
    relaxation: Literal["aitken"] | Annotated[float, Field(strict=True, gt=0, le=1)] = Field(
        default="aitken", description='"aitken", or a fixed factor between passes'
    )
    thermoelastic: Flag = Field(
        default=False,
        description="whether strain rates change the temperature; needs `reference_temperature`",
    )
    petsc: dict[str, str] = Field(
        default={}, description="PETSc options of the linear solver, over the defaults"
    )

    @field_validator("relaxation", mode="before")
    @classmethod
    def _factor(cls, value: object) -> object:
        if value == "aitken":
            return value
        if isinstance(value, int | float) and not isinstance(value, bool) and 0 < value <= 1:
            return float(value)
        raise ValueError("must be 'aitken' or a factor above 0 and at most 1")


class Adaptivity(Model):
    """Meshes and steps that follow a given error, a ratio of norms such as "5 %".

    `contact_size` resolves pressures that need finer meshes than the stress. With an `aspect` new
    thermal cells on interfaces may be that many times longer than thick, up to `contact_size` if
    that is given: a thin layer of heat then needs few cells. Without differences of temperature
    above `least_temperature` errors of heat and time are not judged.
    """

    tolerance: Ratio | None = Field(
        default=None,
        description='relative error such as 0.05 or "5 %", for all of the next three that are '
        "not given",
    )
    mechanics: Ratio | None = Field(default=None, description="relative error of the stress")
    heat: Ratio | None = Field(
        default=None, description="relative error of the heat flux; needs heat"
    )
    time: Ratio | None = Field(
        default=None, description="relative error of the rate of temperature; needs heat"
    )
    bodies: tuple[Name, ...] | None = Field(
        default=None, description="bodies that may get new meshes; all by default"
    )
    size_min: Annotated[Length, Field(gt=0)] | None = Field(
        default=None, description="smallest cell size; by default 1/2048 of each body's extent"
    )
    size_max: Annotated[Length, Field(gt=0)] | None = Field(
        default=None, description="largest cell size; by default 1/8 of each body's extent"
    )
    contact_size: Annotated[Length, Field(gt=0)] | None = Field(
        default=None, description="largest size of new cells on surfaces of interfaces"
    )
    aspect: Annotated[float, Field(strict=True, ge=1, le=100)] = Field(
        default=1.0,
        description="how many times longer than thick thermal cells on interfaces may be",
    )
    growth: Annotated[float, Field(strict=True, gt=0, le=1)] = Field(
        default=0.3, description="growth of the cell size per distance"
    )
    max_cells: Annotated[Count, Field(ge=10)] = Field(
        default=200_000, description="most cells of all meshes of one problem"
    )
    max_remeshes: Count = Field(
        default=3, description="most new meshes of one problem within one step"
    )
    start: Annotated[Duration, Field(ge=0)] = Field(
        default=0.0, description="time from which errors are judged"
    )
    least_temperature: Annotated[TemperatureDifference, Field(ge=0)] = Field(
        default=1e-3,
        description="spread of temperatures in a body above which errors of heat and time are "
        "judged",
    )
    least_strain: Annotated[Number, Field(ge=0)] = Field(
        default=1e-9,
        description="stress over Young's modulus above which errors of mechanics are judged",
    )

    @model_validator(mode="after")
    def _some(self) -> Self:
        if not any((self.tolerance, self.mechanics, self.heat, self.time)):
            raise ValueError("give a tolerance, or one for mechanics, heat or time")
        return self

    def for_mechanics(self) -> float | None:
        """Tolerance of the stress, None to leave the meshes of mechanics."""
        return self.mechanics or self.tolerance

    def for_heat(self) -> float | None:
        """Tolerance of the heat flux, None to leave the thermal meshes."""
        return self.heat or self.tolerance

    def for_time(self) -> float | None:
        """Tolerance of the rate of temperature, None to leave the steps."""
        return self.time or self.tolerance


class Output(Model):
    """Files that are written besides the history and the summary."""

    fields: Literal["vtkhdf", "vtx", False] = Field(
        default="vtkhdf",
        description="field files for ParaView: one of the run, a folder for each body (by ADIOS2), "
        "or none",
    )
    figures: Flag = Field(default=True, description="draw figures")
    times: tuple[PositiveTime, ...] = Field(
        default=(), description="times before the end at which interfaces are written"
    )
    snapshots: Count = Field(
        default=0, description="about how many frames of all bodies are kept for an animation"
    )
    checkpoint_every: Annotated[Count, Field(ge=1)] | None = Field(
        default=None, description="write the state for `contactfem resume` every so many steps"
    )
    checkpoint_interval: PositiveTime = Field(
        default=600.0, description="write it after so much wall-clock time as well"
    )

    @field_validator("fields", mode="before")
    @classmethod
    def _usual(cls, value: object) -> object:
        return "vtkhdf" if value is True else value

    @field_validator("times")
    @classmethod
    def _ascending(cls, value: tuple[float, ...]) -> tuple[float, ...]:
        if list(value) != sorted(set(value)):
            raise ValueError("times are out of order; give ascending times")
        return value


class Expectation(Model):
    """Allowed values of a measured number: near `value`, or between `min` and `max`."""

    value: Number | None = Field(
        default=None, description="expected value [SI]; give it with `rel` or `abs`"
    )
    rel: NonNegative | None = Field(
        default=None, description="allowed deviation, relative to `value`"
    )
    abs: Annotated[Difference, Field(ge=0)] | None = Field(
        default=None, description="allowed deviation, absolute [SI]"
    )
    min: Number | None = Field(default=None, description="smallest allowed value [SI]")
    max: Number | None = Field(default=None, description="largest allowed value [SI]")

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        near = self.value is not None and (self.rel is not None or self.abs is not None)
        between = self.min is not None or self.max is not None
        any_near = (self.value, self.rel, self.abs) != (None, None, None)
        if near == between or (between and any_near):
            raise ValueError("must have 'value' with 'rel' or 'abs', or else 'min' or 'max'")
        if self.min is not None and self.max is not None and self.min > self.max:
            raise ValueError("min is above max")
        return self


class Study(Model):
    """Error of a run for `contactfem study`: an `error`, or a `quantity`."""

    error: str | None = Field(
        default=None,
        description='measured number that is an error itself, such as "sole.pressure_error_l2"',
    )
    quantity: str | None = Field(
        default=None, description="measured number whose distance from `reference` is the error"
    )
    reference: Number | None = Field(
        default=None,
        description="exact value of `quantity` [SI]; by default that of the finest run",
    )

    @model_validator(mode="after")
    def _one(self) -> Self:
        if (self.error is None) == (self.quantity is None):
            raise ValueError("give either an error or a quantity")
        if self.reference is not None and self.quantity is None:
            raise ValueError("a reference goes with a quantity")
        return self


class ClosedForm(Model):
    """Closed form to compare an interface with."""

    solution: Literal["hertz_line", "cattaneo_mindlin", "westergaard", "uniform"] = Field(
        description="name of the closed form"
    )
    parameters: dict[str, Number] = Field(default={}, description="its parameters by name")

    @field_validator("parameters", mode="before")
    @classmethod
    def _in_si(cls, value: object, info: ValidationInfo) -> object:
        units = CLOSED_FORMS[info.data["solution"]].units if "solution" in info.data else {}
        if not isinstance(value, dict):
            return value
        read = {}
        for name, quantity in value.items():
            try:
                read[name] = read_quantity(quantity, units.get(name, ""), info)
            except ValueError as error:
                if name in units:
                    raise ValueError(f"{name} = {quantity}: {error}") from None
                read[name] = 0.0  # closed_form says that there is no such parameter
        return read

    @model_validator(mode="after")
    def _complete(self) -> Self:
        closed_form(self.solution, self.parameters)
        return self
