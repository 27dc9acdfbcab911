"""What may become of a step that was solved: new meshes, another length, or the next step."""

from collections.abc import Mapping
from dataclasses import dataclass, field

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


@dataclass(frozen=True)
class Experience:
    """What earlier steps teach the next ones.

    Attributes:
        age: Steps since the last new mesh, by problem.
        life: Steps that the mesh before it lasted.
        rate_square: Sum of ⟨ż, ż⟩ dt over the steps.
        time: Sum of dt over the same steps [s].
    """

    age: dict[str, int] = field(default_factory=dict)
    life: dict[str, float] = field(default_factory=dict)
    rate_square: float = 0.0
    time: float = 0.0


Verdict = NewMeshes | ShorterStep | Accept
