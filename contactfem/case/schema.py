"""A case: everything that a case file says, checked, in SI."""

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator
from pydantic.json_schema import SkipJsonSchema

from contactfem.case.base import Flag, Model, Name
from contactfem.case.materials import Material
from contactfem.case.obstacles import Obstacle
from contactfem.case.scene import Body, Condition, Interface, Probe
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
    """A whole case.

    With a table `heat`, heat conduction is solved for; with `mechanics = false` it alone.
    """

    title: str = Field(description="one line that says what the case is")
    references: tuple[str, ...] = Field(
        default=(), description="publications or manuals that the case comes from"
    )
    dimension: Literal["plane strain", "axisymmetric", "3d"] = Field(
        default="plane strain", description="what a plane mesh stands for, or 3d"
    )
    strain: Literal["finite", "small"] = Field(
        default="finite",
        description="finite strain, or small strain; contact follows the deformed geometry in both",
    )
    time: Time = Field(description="end of the run and its steps")
    materials: Annotated[dict[Name, Material], Field(min_length=1)] = Field(
        description="materials by name"
    )
    bodies: Annotated[dict[Name, Body], Field(min_length=1)] = Field(
        description="deformable bodies by name"
    )
    obstacles: dict[Name, Obstacle] = Field(default={}, description="rigid obstacles by name")
    interfaces: dict[Name, Interface] = Field(
        default={}, description="pairs of surfaces that may touch, by name"
    )
    mechanics: Flag = Field(default=True, description="whether displacements are solved for")
    heat: Heat | None = Field(
        default=None,
        description="heat conduction; without this table, or with false, temperatures are given",
    )
    adaptivity: Adaptivity | None = Field(
        default=None, description="meshes and steps that follow estimated errors; false for none"
    )
    conditions: tuple[Condition, ...] = Field(
        default=(), description="loads and supports, mechanical and thermal"
    )
    probes: dict[Name, Probe] = Field(default={}, description="values to record at points, by name")
    closed_form: dict[Name, ClosedForm] = Field(
        default={}, description="known solutions to compare with, by the name of the interface"
    )
    solver: Solver = Field(
        default_factory=Solver, description="Newton's method and the linear solver"
    )
    output: Output = Field(default_factory=Output, description="files to write")
    expect: dict[str, Expectation] = Field(
        default={},
        description="measured numbers and the values allowed for them, by name; false for none",
    )
    study: Study | None = Field(
        default=None, description="number that `contactfem study` takes as the error of a run"
    )
    variants: dict[Name, dict[str, Any]] = Field(
        default={}, description="changed keys that make another case of this one, by name"
    )
    path: SkipJsonSchema[Path] = Field(
        default=Path("case.toml"), exclude=True, description="path of the case file"
    )
    contents: SkipJsonSchema[dict[str, Any]] = Field(
        default={},
        exclude=True,
        repr=False,
        description="content of the case file, with a variant and changed values put in",
    )

    @field_validator("heat", "adaptivity", mode="before")
    @classmethod
    def _off(cls, value: object) -> object:
        return None if value is False else value

    @field_validator("expect", mode="before")
    @classmethod
    def _nothing(cls, value: object) -> object:
        return {} if value is False else value

    @classmethod
    def from_dict(cls, contents: Mapping[str, Any], folder: Path | str = ".") -> "Case":
        """A case from what its file would contain.

        Args:
            contents: tables and keys as in a case file.
            folder: where files that it names are looked for.

        Returns:
            The case in SI.

        Raises:
            CaseError: what is wrong, one line for each mistake.
        """
        read = import_module("contactfem.case.read")  # which stands above: it fills this model in
        case: Case = read.case_of(dict(contents), Path(folder) / "case.toml")
        return case

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
