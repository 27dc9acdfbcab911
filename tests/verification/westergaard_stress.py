"""Stresses of Westergaard's wavy contact in both bodies, by his complex function."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class WavyContact:
    """Half-planes with the initial gap A (1 - cos 2πx/λ) under a mean pressure, without friction.

    Laterally held, ε_xx = 0 in the mean, as between lines of symmetry.
    """

    mean_pressure: float
    full_pressure: float  # p* = π E* A/λ
    wave_length: float
    nu: float

    @property
    def edge(self):
        """sin πa/λ of the half-width a; 1 in full contact."""
        return np.sqrt(min(self.mean_pressure / self.full_pressure, 1.0))

    def _function(self, z):
        """Z and Z' for Im z > 0, with Re Z = -p on the real axis."""
        k, p = np.pi / self.wave_length, self.mean_pressure
        if p >= self.full_pressure:
            wave = self.full_pressure * np.exp(2j * k * z)
            return -p - wave, -2j * k * wave
        S = self.edge
        sin, cos = np.sin(k * z), np.cos(k * z)
        root = -1j * np.sqrt(sin - S) * np.sqrt(sin + S)  # cut along the contact, -i sin far away
        bracket = root + 1j * sin
        slope = -sin * cos / root + 1j * cos
        Z = -2.0 * p / S**2 * cos * bracket
        return Z, -2.0 * p / S**2 * k * (cos * slope - sin * bracket)

    def stress(self, name, x):
        """(xx, yy, zz, xy) at points (..., 2); `name` does not matter."""
        side, y = np.sign(x[..., 1]), np.abs(x[..., 1])
        # next to the surface, not on it, where the root changes its branch
        y = np.maximum(y, 1e-12 * self.wave_length)
        Z, slope = self._function(x[..., 0] + 1j * y)
        sideways = self.mean_pressure * (1.0 - self.nu / (1.0 - self.nu))
        xx = Z.real - y * slope.imag + sideways
        yy = Z.real + y * slope.imag
        return np.stack((xx, yy, self.nu * (xx + yy), -side * y * slope.real), -1)
