"""What is wrong with a state, in one line."""

from dataclasses import dataclass

from contactfem.common.typing import Floats


@dataclass(frozen=True)
class Breach:
    """Something that a state cannot be.

    Attributes:
        kind: Which check it is: "depth", "cells", "motion", "balance", "pressure", ...
        what: What was found, with its place and size.
        advice: What to do.
        measure: How bad, to be compared between step lengths; larger is worse.
    """

    kind: str
    what: str
    advice: str
    measure: float = 0.0

    def __str__(self) -> str:
        return f"{self.what}; {self.advice}"


def place(x: Floats) -> str:
    """A position in words."""
    return f"({', '.join(f'{float(value):.6g}' for value in x)}) m"
