"""Rigid obstacles of a case file."""

import itertools
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, ValidationInfo, field_validator

from contactfem.case.base import AXES, Displacement, Finite, Flag, Model, unit_vector
from contactfem.common.time_table import Table, constant
from contactfem.common.typing import Floats
from contactfem.common.units import Length, TemperatureTable

Position = Annotated[tuple[Length, ...], Field(min_length=2, max_length=3)]
Direction = Annotated[tuple[Finite, ...], Field(min_length=2, max_length=3)]
Place = tuple[Length, Length, Length]


def _at_rest() -> Displacement:
    return {"x": constant(0.0), "y": constant(0.0)}


class RigidObstacle(Model):
    """Rigid mortar side.

    With a `temperature` it conducts heat. Without one it only takes its share of frictional heat.
    """

    displacement: Displacement = Field(
        default_factory=_at_rest, description="motion over time; at rest if not given"
    )
    temperature: TemperatureTable | None = Field(
        default=None,
        description="temperature over time; without it no heat flows into the obstacle but "
        "its share of frictional heat",
    )

    @field_validator("displacement")
    @classmethod
    def _both(cls, value: Displacement) -> Displacement:
        return _at_rest() | value

    def motion(self, axes: int) -> tuple[Table, ...]:
        """Its displacement over time [m], one table per axis."""
        return tuple(self.displacement.get(axis, constant(0.0)) for axis in AXES[:axes])


class Plane(RigidObstacle):
    """Half-plane, or half-space."""

    shape: Literal["plane"] = Field(description="half-plane, or half-space")
    point: Position = Field(description="any point on the plane")
    normal: Direction = Field(description="points out of the obstacle's solid")

    @field_validator("normal")
    @classmethod
    def _unit(cls, value: tuple[float, ...]) -> tuple[float, ...]:
        return unit_vector(value)


class Circle(RigidObstacle):
    """Disk, or a round hole."""

    shape: Literal["circle"] = Field(description="circle")
    center: tuple[Length, Length] = Field(description="centre")
    radius: Annotated[Length, Field(gt=0)] = Field(description="radius")
    inside: Flag = Field(
        default=False,
        description="true: the body touches the circle from inside, the solid is outside",
    )


class Polyline(RigidObstacle):
    """Chain of straight lines."""

    shape: Literal["polyline"] = Field(description="chain of straight lines")
    points: Annotated[tuple[tuple[Length, Length], ...], Field(min_length=2)] = Field(
        description="corners in order, with the solid on the left of the walk along them"
    )
    closed: bool = Field(default=False, description="whether the chain returns to its first corner")

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


class Sphere(RigidObstacle):
    """Ball, or a round hollow."""

    shape: Literal["sphere"] = Field(description="sphere")
    center: Place = Field(description="centre")
    radius: Annotated[Length, Field(gt=0)] = Field(description="radius")
    inside: Flag = Field(
        default=False,
        description="true: the body touches the sphere from inside, the solid is outside",
    )


class RigidCylinder(RigidObstacle):
    """Long cylinder, or a bore."""

    shape: Literal["cylinder"] = Field(description="cylinder without ends")
    point: Place = Field(description="any point on its axis")
    axis: tuple[Finite, Finite, Finite] = Field(description="direction of its axis")
    radius: Annotated[Length, Field(gt=0)] = Field(description="radius")
    inside: Flag = Field(
        default=False,
        description="true: the body touches the cylinder from inside, the solid is outside",
    )

    @field_validator("axis")
    @classmethod
    def _unit(cls, value: tuple[float, ...]) -> tuple[float, ...]:
        return unit_vector(value)


class RigidSurface(RigidObstacle):
    """Surface of triangles from a file."""

    shape: Literal["surface"] = Field(description="surface of triangles from a file")
    file: Path = Field(
        description="STL, or what meshio reads; triangles counter-clockwise seen from outside"
    )
    unit: Length = Field(gt=0, description="length unit of the coordinates", examples=["mm"])

    @field_validator("unit", mode="before")
    @classmethod
    def _one(cls, value: object) -> object:
        return f"1 {value}" if isinstance(value, str) and value[:1].isalpha() else value

    @field_validator("file")
    @classmethod
    def _found(cls, value: Path, info: ValidationInfo) -> Path:
        path = Path((info.context or {}).get("folder", "")) / value
        if not path.is_file():
            raise ValueError(f"there is no file '{path}'")
        return path


Obstacle = Annotated[
    Plane | Circle | Polyline | Sphere | RigidCylinder | RigidSurface,
    Field(discriminator="shape"),
]
