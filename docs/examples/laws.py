"""Laws of one's own for an interface: friction and the conductance of heat."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

COEFFICIENT, LARGEST = 0.3, 4e6  # friction coefficient [-], shear strength of the softer side [Pa]


def capped_friction(
    pressure: Floats, speed: Floats, temperature: Floats
) -> tuple[Floats, Floats, Floats]:
    """Largest traction b = k tanh(μp/k): Coulomb's law at small pressures, at most k.

    Args:
        pressure: p (n,) [Pa].
        speed: Slip speed (n,) [m/s], without effect.
        temperature: Relative temperature of the nonmortar side (n,) [K], without effect.

    Returns:
        b [Pa] and its slopes db/dp [-] and db/dv [Pa s/m], which Newton's method needs.
    """
    share = np.tanh(COEFFICIENT * pressure / LARGEST)
    return LARGEST * share, COEFFICIENT * (1.0 - share**2), np.zeros_like(pressure)


SPOTS, HARDNESS, FILM = 2e4, 5e6, 5e-5  # [W/m²/K], [Pa], resistance of the film [m² K/W]


def coated(pressure: Floats, gap: Floats) -> Floats:
    """Conductance of spots in contact with a film in series, 1/h = H/(h₀ p) + R; 0 where open.

    Args:
        pressure: p (n,) [Pa], 0 where open.
        gap: g (n,) [m], without effect.

    Returns:
        h [W/m²/K].
    """
    spots = SPOTS * pressure / HARDNESS
    return spots / (1.0 + FILM * spots)
