"""Rigid obstacles of a case file."""

import itertools
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, field_validator

from contactfem.case.base import Displacement, Finite, Flag, Model, unit_vector
from contactfem.common.time_table import constant
from contactfem.common.typing import Floats
from contactfem.common.units import Length, TemperatureTable


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
        if "z" in value:
            raise ValueError("an obstacle moves in x and y")
        return _at_rest() | value


class Plane(RigidObstacle):
    """Half-plane."""

    shape: Literal["plane"] = Field(description="half-plane")
    point: tuple[Length, Length] = Field(description="any point on the plane")
    normal: tuple[Finite, Finite] = Field(description="points out of the obstacle's solid")

    @field_validator("normal")
    @classmethod
    def _unit(cls, value: tuple[float, float]) -> tuple[float, float]:
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


Obstacle = Annotated[Plane | Circle | Polyline, Field(discriminator="shape")]
