"""Rectangle with one wavy side."""

from math import ceil
from typing import Literal

import numpy as np
from pydantic import Field

from contactfem.common.typing import Floats
from contactfem.common.units import Length
from contactfem.meshes.block import Structured, rectangle
from contactfem.meshes.builder import PositiveLength
from contactfem.meshes.curves import Boundary, Parametric, equal_parts, line
from contactfem.meshes.data import MeshData
from contactfem.meshes.grid import grid

KNOTS = 32  # per wavelength, where the exact boundary is sampled


class Wave(Structured):
    """Rectangle with groups left, right, bottom, top; one `side`, bottom or top, is a wave.

    It recedes from the straight line by amplitude (1 - cos(2 pi (x - crest) / wavelength)).
    """

    builder: Literal["wave"] = Field(default="wave", description="rectangle with one wavy side")
    amplitude: PositiveLength = Field(description="half of the height of the wave")
    wavelength: PositiveLength = Field(description="length of the wave")
    crest: Length = Field(default=0.0, description="x of a point of the wave on the straight line")
    side: Literal["bottom", "top"] = Field(default="bottom", description="side that is a wave")

    def build(self) -> MeshData:
        """Structured mesh; each column is stretched between its ends."""
        x, y = self.lines()
        depth = (y - y[0]) / self.height
        if self.side == "bottom":
            points_y = y[:, None] + np.outer(1 - depth, self.recess(x))
        else:
            points_y = y[:, None] - np.outer(depth, self.recess(x))
        points = np.stack([np.broadcast_to(x, points_y.shape), points_y], axis=-1)
        return grid(points, self.cell, self.pattern)

    def outline(self) -> dict[str, Floats]:
        """The four sides; the wavy one by its nodes."""
        x, y = self.lines()
        recess = self.recess(x)
        low = recess[[0, -1]] if self.side == "bottom" else np.zeros(2)
        high = recess[[0, -1]] if self.side == "top" else np.zeros(2)
        sides = rectangle(x[0], y[0], x[-1], y[-1])
        sides["left"][:, 1] += [-high[0], low[0]]
        sides["right"][:, 1] += [low[1], -high[1]]
        if self.side == "bottom":
            sides["bottom"] = np.stack([x, y[0] + recess], axis=1)
        else:
            sides["top"] = np.stack([x, y[-1] - recess], axis=1)[::-1]
        return sides

    def curves(self) -> Boundary:
        """Three straight sides and the wave."""
        edges = {name: line(side[[0, -1]], (name,)) for name, side in self.outline().items()}
        knots = equal_parts(max(1, ceil(KNOTS * self.width / self.wavelength)))
        wave = Parametric(self._wave, knots, (self.side,))
        return (
            (
                edges["bottom"] if self.side == "top" else wave,
                edges["right"],
                edges["top"] if self.side == "bottom" else wave,
                edges["left"],
            ),
        )

    def _wave(self, t: Floats) -> Floats:
        """Points (k, 2) [m] of the wavy side at the parts t (k,) of its width."""
        x0, y0 = self.corner
        if self.side == "bottom":
            x = x0 + self.width * t
            return np.stack([x, y0 + self.recess(x)], axis=1)
        x = x0 + self.width * (1.0 - t)
        return np.stack([x, y0 + self.height - self.recess(x)], axis=1)

    def recess(self, x: Floats) -> Floats:
        """How far the wavy side lies behind the straight one at x [m]."""
        phase = 2 * np.pi * (x - self.crest) / self.wavelength
        return np.asarray(self.amplitude * (1 - np.cos(phase)))
