"""A case: everything that a case file says, checked, in SI."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator
from pydantic.json_schema import SkipJsonSchema

from contactfem.case.base import Flag, Model, Name
from contactfem.case.scene import Body, Condition, Interface, Material, Obstacle, Probe
from contactfem.case.settings import (
    Adaptivity,
    ClosedForm,
    Expectation,
    Heat,
    Output,
    Solver,
    Study,
    Time,
)


class Case(Model):
    """A whole case; names that refer to something are known to exist.

    `heat`: heat is solved for where this table stands; with `mechanics = false` it alone.
    `path` and `contents` are those of the file, with a variant and changed values put in.
    """

    title: str
    references: tuple[str, ...] = ()
    dimension: Literal["plane strain", "axisymmetric", "3d"] = "plane strain"
    strain: Literal["finite", "small"] = "finite"
    time: Time
    materials: Annotated[dict[Name, Material], Field(min_length=1)]
    bodies: Annotated[dict[Name, Body], Field(min_length=1)]
    obstacles: dict[Name, Obstacle] = {}
    interfaces: dict[Name, Interface] = {}
    mechanics: Flag = True
    heat: Heat | None = None
    adaptivity: Adaptivity | None = None
    conditions: tuple[Condition, ...] = ()
    probes: dict[Name, Probe] = {}
    closed_form: dict[Name, ClosedForm] = {}
    solver: Solver = Field(default_factory=Solver)
    output: Output = Field(default_factory=Output)
    expect: dict[str, Expectation] = {}
    study: Study | None = None
    variants: dict[Name, dict[str, Any]] = {}
    path: SkipJsonSchema[Path] = Field(default=Path("case.toml"), exclude=True)
    contents: SkipJsonSchema[dict[str, Any]] = Field(default={}, exclude=True, repr=False)

    @field_validator("heat", "adaptivity", mode="before")
    @classmethod
    def _off(cls, value: object) -> object:
        return None if value is False else value

    @field_validator("expect", mode="before")
    @classmethod
    def _nothing(cls, value: object) -> object:
        return {} if value is False else value

    @property
    def axes(self) -> int:
        """Number of displacement components."""
        return 3 if self.dimension == "3d" else 2

    @property
    def axisymmetric(self) -> bool:
        """Whether x is the distance from the axis of bodies of revolution, and y their height."""
        return self.dimension == "axisymmetric"

    @property
    def force_unit(self) -> str:
        """SI unit of forces: per metre of depth in plane strain."""
        return force_unit(self.dimension)


def force_unit(dimension: object) -> str:
    """SI unit of forces, by the dimension of the case."""
    return "N" if dimension in ("axisymmetric", "3d") else "N/m"
