"""Tables of a case beside its scene: time, solver, heat, adaptivity, output."""

from typing import Annotated, Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from contactfem.case.base import Flag, Model, Name, NonNegative
from contactfem.common.units import Duration, Length, Number, Temperature, read_quantity
from contactfem.verification.contact import CLOSED_FORMS, closed_form

PositiveTime = Annotated[Duration, Field(gt=0)]
Fraction = Annotated[float, Field(strict=True, gt=0, lt=1)]
Count = Annotated[int, Field(strict=True, ge=0, le=1_000_000)]
Ratio = Annotated[Number, Field(gt=0, lt=1)]
STEPS = 1024.0  # the smallest step, unless given, is this many times smaller than the first


class Time(Model):
    """Time from zero to `end`; steps start with `step` and adapt between the limits."""

    end: PositiveTime
    step: PositiveTime
    step_min: PositiveTime = Field(default_factory=lambda data: data.get("step", 0.0) / STEPS)
    step_max: PositiveTime = Field(default_factory=lambda data: data.get("step", 0.0))

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
    """Newton's method: `tolerance` of the scaled residual; `petsc`: linear solver's options.

    `system`: multipliers are eliminated (condensed) or unknowns beside u (saddle). `reuse`: whether
    a factor may serve on where that pays (condensed, no `petsc` options); the answer is the same.
    """

    system: Literal["condensed", "saddle"] = "condensed"
    tolerance: Fraction = 1e-10
    max_iterations: Annotated[Count, Field(ge=1)] = 30
    max_cutbacks: Count = 8
    reuse: Flag = True
    petsc: dict[str, str] = {}


class Heat(Model):
    """Heat conduction, solved after the mechanics of each step (isothermal split).

    `scheme`: in time, cG(k) (22)-(27), the L-stable dG(k), or "steady". cG(1) is the default:
    second order at the price of one solve; it may ring where a start is inconsistent or ρc tiny,
    which is said, and dG(1) is the remedy. `max_passes` of mechanics and heat per step, until
    temperatures change less than `tolerance` of their range; `relaxation` "aitken" or a fixed
    factor. `thermoelastic`: whether straining changes temperature (needs a reference_temperature).
    """

    scheme: Literal["cG(1)", "cG(2)", "cG(3)", "cG(4)", "dG(0)", "dG(1)", "dG(2)", "steady"] = (
        "cG(1)"
    )
    max_passes: Annotated[Count, Field(ge=1)] = 1
    tolerance: Fraction = 1e-6
    relaxation: Literal["aitken"] | Annotated[float, Field(strict=True, gt=0, le=1)] = "aitken"
    thermoelastic: Flag = False
    petsc: dict[str, str] = {}

    @field_validator("relaxation", mode="before")
    @classmethod
    def _factor(cls, value: object) -> object:
        if value == "aitken":
            return value
        if isinstance(value, int | float) and not isinstance(value, bool) and 0 < value <= 1:
            return float(value)
        raise ValueError("must be 'aitken' or a factor above 0 and at most 1")


class Adaptivity(Model):
    """Meshes and steps that follow from the error asked for, as ratios of norms such as "5 %".

    `tolerance` stands for all three that are not given: `mechanics`, `heat` and `time`; the latter
    two need heat. `bodies` may get new meshes, all by default. Sizes and growth limit the cells,
    `max_cells` those of all meshes of one problem; sizes are by default an eighth of each body's
    extent, and that over 256; `contact_size` is the largest of new cells of mechanics on surfaces
    of interfaces, for pressures that are finer than the stress asks for. `aspect` lets new thermal
    cells there be so many times longer than thick, up to `contact_size` if that is given: a thin
    layer of heat then needs few cells. Errors are judged after `start`; those of heat and time as
    soon as temperatures are further apart than `least_temperature`: next to no heat needs no mesh.
    """

    tolerance: Ratio | None = None
    mechanics: Ratio | None = None
    heat: Ratio | None = None
    time: Ratio | None = None
    bodies: tuple[Name, ...] | None = None
    size_min: Annotated[Length, Field(gt=0)] | None = None
    size_max: Annotated[Length, Field(gt=0)] | None = None
    contact_size: Annotated[Length, Field(gt=0)] | None = None
    aspect: Annotated[float, Field(strict=True, ge=1, le=100)] = 1.0
    growth: Annotated[float, Field(strict=True, gt=0, le=1)] = 0.3
    max_cells: Annotated[Count, Field(ge=10)] = 200_000
    max_remeshes: Count = 3
    start: Annotated[Duration, Field(ge=0)] = 0.0
    least_temperature: Annotated[Temperature, Field(ge=0)] = 1e-3

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
    """What is written besides the history.

    `times`: when interfaces are written before the end. `snapshots`: about how many pictures of all
    bodies are kept, over the time of the run, for a film. A run writes its state, to be resumed
    from, every `checkpoint_every` steps if that is given, and every `checkpoint_interval` of
    wall-clock time.
    """

    fields: Literal["vtkhdf", "vtx", False] = "vtkhdf"
    figures: Flag = True
    times: tuple[PositiveTime, ...] = ()
    snapshots: Count = 0
    checkpoint_every: Annotated[Count, Field(ge=1)] | None = None
    checkpoint_interval: PositiveTime = 600.0

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
    """What a measured number must be: near `value`, or between `min` and `max` [SI]."""

    value: Number | None = None
    rel: NonNegative | None = None
    abs: Annotated[Number, Field(ge=0)] | None = None
    min: Number | None = None
    max: Number | None = None

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
    """What `contactfem study` takes for the error of a run.

    `error`: a measured number that is one, such as "sole.pressure_error_l2". Or else a `quantity`,
    whose distance from its `reference` is taken [SI], or from that of the finest run.
    """

    error: str | None = None
    quantity: str | None = None
    reference: Number | None = None

    @model_validator(mode="after")
    def _one(self) -> Self:
        if (self.error is None) == (self.quantity is None):
            raise ValueError("give either an error or a quantity")
        if self.reference is not None and self.quantity is None:
            raise ValueError("a reference goes with a quantity")
        return self


class ClosedForm(Model):
    """Closed form that an interface is compared with."""

    solution: Literal["hertz_line", "cattaneo_mindlin", "westergaard", "uniform"]
    parameters: dict[str, Number] = {}

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
