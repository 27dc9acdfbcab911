"""What may become of a step that was solved: new meshes, another length, or the next step."""

from collections.abc import Mapping
from dataclasses import dataclass

from contactfem.results import ErrorStep, FloatArray


@dataclass(frozen=True)
class NewSizes:
    """Sizes that new meshes should have, at the vertices of the present ones [m], by body.

    Bodies that are not named keep their mesh.
    """

    mechanical: Mapping[str, FloatArray]
    thermal: Mapping[str, FloatArray]


@dataclass(frozen=True)
class NewMeshes:
    """Take the step again on meshes of these sizes."""

    sizes: NewSizes


@dataclass(frozen=True)
class ShorterStep:
    """Go back by one or two steps and on with this length [s]."""

    dt: float
    back: int


@dataclass(frozen=True)
class Accept:
    """Go on with a step of this length [s]; None to leave it to Newton's method."""

    dt: float | None
    errors: ErrorStep | None


Verdict = NewMeshes | ShorterStep | Accept
