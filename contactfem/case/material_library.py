"""Materials that a case may name without giving their numbers."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

BOOKS = (
    "Callister, Materials Science and Engineering (moduli, expansion); "
    "Incropera, Fundamentals of Heat and Mass Transfer, table A (density, heat), at 300 K"
)
METAL = "elastic below yield, -50 to 200 °C; alloys and heat treatment change k by a factor of 2"


@dataclass(frozen=True)
class Entry:
    """A material of the library.

    Attributes:
        keys: as in the table of a material in a case file.
        source: where its numbers are from.
        validity: where they hold.
    """

    keys: Mapping[str, Any]
    source: str
    validity: str


def _metal(E: float, nu: float, alpha: float, rho: float, k: float, c: float) -> Entry:
    """A metal by E [GPa], ν, α [1e-6/K], ρ [kg/m³], k [W/m/K] and c [J/kg/K]."""
    keys = {
        "youngs_modulus": f"{E:g} GPa",
        "poisson_ratio": nu,
        "expansion": f"{alpha:g}e-6 1/K",
        "density": f"{rho:g} kg/m^3",
        "conductivity": f"{k:g} W/m/K",
        "heat_capacity": f"{c:g} J/kg/K",
    }
    return Entry(keys, BOOKS, METAL)


LIBRARY: Mapping[str, Entry] = {
    "steel": _metal(207, 0.30, 11.7, 7832, 63.9, 434),  # plain carbon, AISI 1010
    "stainless_steel": _metal(193, 0.30, 17.2, 7900, 14.9, 477),  # AISI 304
    "aluminium": _metal(69, 0.33, 23.6, 2702, 237, 903),
    "brass": _metal(97, 0.34, 19.9, 8530, 110, 380),  # 70 Cu, 30 Zn
    "copper": _metal(110, 0.34, 17.0, 8933, 401, 385),
    "titanium": _metal(107, 0.34, 8.6, 4500, 21.9, 522),
    "rubber": Entry(
        {
            "shear_modulus": "0.5 MPa",
            "bulk_modulus": "2 GPa",
            "expansion": "220e-6 1/K",
            "density": "1100 kg/m^3",
            "conductivity": "0.13 W/m/K",
            "heat_capacity": "2010 J/kg/K",
        },
        "Incropera, table A (soft, vulcanised: density, heat); Callister (expansion); soft natural "
        "rubber, about 40 Shore A (moduli)",
        "stretches below 1.5, no hysteresis; compounds differ by a factor of 10 in shear",
    ),
}


def with_library(raw: Mapping[str, Any]) -> dict[str, Any]:
    """Contents of a case file with the materials that its bodies name but it does not give.

    Args:
        raw: the contents, not checked yet.

    Returns:
        The contents; a material that the file gives itself is left as it is.
    """
    bodies, given = raw.get("bodies"), raw.get("materials", {})
    if not isinstance(bodies, dict) or not isinstance(given, dict):
        return dict(raw)
    tables = [body for body in bodies.values() if isinstance(body, dict)]
    names = [body.get("material") for body in tables]
    for body in tables:
        groups = body.get("materials", {})
        names += list(groups.values()) if isinstance(groups, dict) else []
    missing = {name for name in names if isinstance(name, str) and name not in given}
    found = {name: dict(LIBRARY[name].keys) for name in sorted(missing & LIBRARY.keys())}
    return {**raw, "materials": {**given, **found}} if found else dict(raw)
